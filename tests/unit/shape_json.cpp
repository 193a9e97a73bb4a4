// Shapes as JSON: nodes, references, animation, values set from outside, and what is wrong with them.
#include "volcaustic/error.h"
#include "volcaustic/scene.h"
#include "volcaustic/shape_fields.h"
#include "volcaustic/shape_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <unistd.h>

namespace volcaustic {
namespace {

/// A folder of shape files that goes with the test.
class Folder {
public:
  Folder() : mPath(std::filesystem::temp_directory_path() / ("volcaustic-shapes-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(mPath);
  }
  ~Folder() { std::filesystem::remove_all(mPath); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(mPath / name) << text;
    return mPath / name;
  }

private:
  std::filesystem::path mPath;
};

std::string fileWith(const std::string& shape, const std::string& more = "") {
  return R"({"volcaustic": 1, "shape": )" + shape + (more.empty() ? "" : ", " + more) + "}";
}
Shape parse(const std::string& shape, const ShapeReadOptions& options = {}, const std::string& more = "") {
  return parseShape(fileWith(shape, more), "s.json", options);
}

/// What is wrong with a file, in one line of readable length.
std::string errorOf(const std::string& text, ErrorKind kind = ErrorKind::Input, const ShapeReadOptions& options = {}) {
  try {
    (void)parseShape(text, "s.json", options);
  } catch (const Error& error) {
    const std::string what = error.what();
    EXPECT_EQ(error.kind(), kind) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    EXPECT_LT(what.size(), 600u) << what;
    return what;
  }
  ADD_FAILURE() << "no error: " << text.substr(0, 200);
  return "";
}
void expectError(const std::string& shape, const std::string& pointer, const std::string& part,
                 const std::string& more = "") {
  const std::string line = errorOf(fileWith(shape, more));
  EXPECT_TRUE(line.starts_with("s.json:" + pointer + ": ")) << line;
  EXPECT_NE(line.find(part), std::string::npos) << line;
}

template <class Kind>
Kind kindOf(const Shape& shape) {
  return std::get<Kind>(shape.node().kind);
}

/// A node of every type that is valid but not as it is by default.
std::vector<Shape> oneOfEachType() {
  const Shape ball = Shape::sphere(0.7);
  shapes::Profile profile{{{0.1, 0}, {0.5, 0.1}, {0.3, 1.0 / 3}}, {0, 0.25, -0.1}, false};
  Placement step{{0.1, 0.2, 0.3}, {10, 20, 30}, {1, 0.9, 1.1}, {0.01, 0, -0.02}};
  return {Shape::quadric({-1, -2, -3, 0.1, 0.2, 0.3, 0, 0, 0.1, 1}),
          Shape::plane({0, 1, 1}, 0.25),
          Shape::slab({1, 0, 0}, 0.3),
          ball,
          Shape::ellipsoid({1, 1.5, 2}),
          Shape(ShapeNode{"", shapes::Cylinder{{0.5, 0.25}, 3, true}, {}, {}, {}}),
          Shape::cone(0.3, 0.9),
          Shape::paraboloid(0.5, 0.7),
          Shape::hyperboloid(0.25, 0.75, 1.5),
          Shape::cuboid({1, 2, 3}, 0.1),
          Shape::torus(1, 0.1),
          Shape::capsule({0, 1, 0}, {1, 0, 0}, 0.2),
          Shape::revolution(profile),
          Shape::extrusion(profile, 0.4),
          Shape::unite({ball, Shape::torus(1, 0.2)}, 0.05),
          ball & Shape::plane({0, 0, 1}),
          ball - Shape::cone(0.1, 2) - Shape::capsule({0, 0, 0}, {1, 0, 0}, 0.1),
          ~ball,
          ball.offset(-0.125),
          ball.shell(0.01),
          ball.displaced(shapes::NoiseDisplacement{0.05, 0.3, 3, 0.4, {1, 2, 3}, -7}),
          ball.displaced(shapes::WaveDisplacement{0.01, 0.2, 0.3, {0, 1, 1}, true}),
          ball.repeated(5, step, 0.02),
          ball.copied({step, Placement{}}, 0.01)};
}

TEST(ShapeJson, EveryTypeComesBackTheSame) {
  const std::vector<Shape> all = oneOfEachType();
  ASSERT_EQ(all.size(), kShapeTypes.size()) << "a type is missing in this test";
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].node().kind.index(), i);
    const std::string text = shapeToJson(all[i]);
    EXPECT_EQ(shapeHash(parseShape(text, "s.json")), shapeHash(all[i])) << text;
    EXPECT_EQ(shapeToJson(parseShape(text, "s.json")), text) << "canonical";
  }
}

TEST(ShapeJson, NamesPlacementsAndDeviationsComeBackTheSame) {
  const Placement placement{{1, -0.0, 1e-300}, {0.1, 0, 360}, {1, -1, 2}, {0, 0, 1}};
  const Shape shape =
      Shape::ellipsoid({1, 2, 3}).bulge(Shape::sphere(0.5).translated({1, 0, 0}), 2).bulge(Shape::cone(1, 2), -0.25);
  const Shape whole = Shape::unite({shape.named("drop \"a\"/b~").placed(placement), oneOfEachType().back()});
  const std::string text = shapeToJson(whole);
  EXPECT_EQ(shapeHash(parseShape(text, "s.json")), shapeHash(whole)) << text;
}

TEST(ShapeJson, AsDeepAsShapesMayBeComesBackTheSame) {
  Shape shape = Shape::sphere(1);
  for (int i = 0; i < 800; ++i) shape = shape.offset(i % 2 ? 0.01 : -0.01);
  EXPECT_EQ(shapeHash(parseShape(shapeToJson(shape), "s.json")), shapeHash(shape));
}

TEST(ShapeJson, ReadsWhatIsGivenAndKeepsDefaults) {
  const Shape drop = parse(R"({"type": "ellipsoid", "semiAxes": [1, 1, 2], "name": "drop", "translate": [0, 0, 3],
      "deviations": [{"weight": -0.5, "region": {"type": "sphere"}}, {"region": {"type": "plane", "offset": 1}}]} // c)"
                           "\n");
  EXPECT_EQ(kindOf<shapes::Ellipsoid>(drop).semiAxes, (Vec3d{1, 1, 2}));
  EXPECT_EQ(drop.node().name, "drop");
  EXPECT_EQ(drop.node().placement.translate, (Vec3d{0, 0, 3}));
  ASSERT_EQ(drop.node().deviations.size(), 2u);
  EXPECT_EQ(drop.node().deviations[0].weight, -0.5);
  EXPECT_EQ(drop.node().deviations[1].weight, 1);
  EXPECT_EQ(kindOf<shapes::Plane>(drop.node().deviations[1].region).offset, 1);
  EXPECT_EQ(shapeHash(parse(R"({"type": "torus"})")), shapeHash(Shape::torus(1, 0.25)));
}

TEST(ShapeJson, UsesShareAndPlaceDefinitions) {
  const std::string definitions = R"("shapes": {"pair": {"type": "union", "parts": [{"use": "ball"},
      {"use": "ball", "name": "right", "translate": [2, 0, 0]}]}, "ball": {"type": "sphere", "radius": 0.5}})";
  const Shape ball = Shape::sphere(0.5);
  EXPECT_EQ(shapeHash(parse(R"({"use": "pair"})", {}, definitions)),
            shapeHash(Shape::unite({ball, ball.named("right").translated({2, 0, 0})})));
}

TEST(ShapeJson, FilesReferToFilesOfTheirFolder) {
  const Folder folder;
  std::filesystem::create_directories(folder.write("x", "").parent_path() / "parts");
  folder.write("parts/ball.json", fileWith(R"({"type": "sphere", "radius": 0.5})",
                                           R"("animation": {"/shape/radius": [[1, 0.5], [3, 1.5]]})"));
  folder.write("parts/pair.json", fileWith(R"({"type": "union", "parts": [{"file": "ball.json"},
                         {"file": "../parts/ball.json", "translate": [2, 0, 0]}]})"));
  const auto path = folder.write("top.json", fileWith(R"({"file": "parts/pair.json", "name": "pair"})"));
  const Shape ball = Shape::sphere(1);
  EXPECT_EQ(shapeHash(readShape(path, {{}, 2})),
            shapeHash(Shape::unite({ball, ball.translated({2, 0, 0})}).named("pair")))
      << "animations of files that are referred to are at the same frame";
  const auto scene = folder.write("scene.json", R"({"volcaustic": 1, "objects": [{"shape": "parts/ball.json"},
      {"shape": {"file": "parts/ball.json"}}]})");
  for (const SceneObject& o : readScene(scene, {{}, 3}).objects) EXPECT_EQ(kindOf<shapes::Sphere>(o.shape).radius, 1.5);
  EXPECT_TRUE(isShapeFile(path));
  EXPECT_FALSE(isShapeFile(scene));
  EXPECT_FALSE(isShapeFile(path.parent_path()));
}

TEST(ShapeJson, CirclesAreErrorsAtTheReference) {
  expectError(R"({"use": "a"})", "/shapes/a/use", "a -> a", R"("shapes": {"a": {"use": "a"}})");
  expectError(R"({"use": "a"})", "/shapes/b/parts/0/use", "a -> b -> a",
              R"("shapes": {"a": {"type": "shell", "part": {"use": "b"}},
                            "b": {"type": "union", "parts": [{"use": "a"}]}})");
  const Folder folder;
  const auto path = folder.write("one.json", fileWith(R"({"use": "x"})", R"("shapes": {"x": {"file": "two.json"}})"));
  folder.write("two.json", fileWith(R"({"type": "offset", "part": {"file": "./one.json"}})"));
  try {
    (void)readShape(path);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("two.json:/shape/part/file: goes in a circle"), std::string::npos)
        << error.what();
  }
}

TEST(ShapeJson, WrongNodesAreErrorsAtTheirPointer) {
  expectError(R"({"type": "elipsoid"})", "/shape/type", "\"ellipsoid\"");
  expectError(R"({"semiAxes": [1, 1, 1]})", "/shape/type", "missing");
  expectError(R"([1])", "/shape", "object");
  expectError(R"("ball.json")", "/shape", "object");
  expectError(R"({"type": "sphere", "raduis": 1})", "/shape/raduis", "\"radius\"");
  expectError(R"({"type": "sphere", "radius": -1})", "/shape/radius", "range");
  expectError(R"({"type": "sphere", "radius": "1"})", "/shape/radius", "number");
  expectError(R"({"type": "ellipsoid", "semiAxes": [1, 0, 1]})", "/shape/semiAxes/1", "range");
  expectError(R"({"type": "sphere", "scale": [1, 0, 1]})", "/shape", "flat");
  expectError(R"({"type": "sphere", "parts": []})", "/shape/parts", "solid");
  expectError(R"({"type": "sphere", "part": {}})", "/shape/part", "solid");
  expectError(R"({"type": "union"})", "/shape/parts", "missing");
  expectError(R"({"type": "union", "parts": []})", "/shape", "no parts");
  expectError(R"({"type": "union", "parts": {}})", "/shape/parts", "array");
  expectError(R"({"type": "union", "part": {"type": "sphere"}})", "/shape/part", "parts");
  expectError(R"({"type": "shell", "parts": [{"type": "sphere"}]})", "/shape/parts", "part");
  expectError(R"({"type": "shell"})", "/shape/part", "missing");
  expectError(R"({"type": "union", "parts": [{"type": "sphere"}, {"type": "cubiod"}]})", "/shape/parts/1/type",
              "cuboid");
  expectError(R"({"type": "torus", "deviations": []})", "/shape/deviations", "quadric");
  expectError(R"({"type": "sphere", "deviations": [{"weight": 1}]})", "/shape/deviations/0/region", "missing");
  expectError(R"({"type": "sphere", "deviations": [{"region": {"type": "torus"}}]})", "/shape", "no quadric");
  expectError(R"({"type": "sphere", "deviations": [{"wieght": 1}]})", "/shape/deviations/0/wieght", "\"weight\"");
  expectError(R"({"type": "quadric", "coefficients": [1, 2]})", "/shape/coefficients", "10");
  expectError(R"({"type": "quadric", "coefficients": [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]})", "/shape", "surface");
  expectError(R"({"type": "revolution"})", "/shape/points", "missing");
  expectError(R"({"type": "revolution", "points": [[0, 1], [1, "x"]]})", "/shape/points/1/1", "number");
  expectError(R"({"type": "revolution", "points": [[0, 0], [-1, 0], [0, 1]]})", "/shape", "axis");
  expectError(R"({"type": "instances", "part": {"type": "sphere"}, "placements": [{"sacle": [1, 1, 1]}]})",
              "/shape/placements/0/sacle", "\"scale\"");
  expectError(R"({"type": "array", "part": {"type": "sphere"}, "step": {"scale": [0, 1, 1]}})", "/shape", "flat");
}

TEST(ShapeJson, WrongReferencesAreErrorsAtTheirPointer) {
  expectError(R"({"use": "bal"})", "/shape/use", "\"ball\"", R"("shapes": {"ball": {"type": "sphere"}})");
  expectError(R"({"use": "ball"})", "/shape/use", "/shapes");
  expectError(R"({"use": "a", "radius": 3})", "/shape/radius", "unknown", R"("shapes": {"a": {"type": "sphere"}})");
  expectError(R"({"type": "sphere"})", "/shapes/unused/type", "missing", R"("shapes": {"unused": {}})");
  expectError(R"({"type": "sphere"})", "/shapes", "object", R"("shapes": [])");
  EXPECT_NE(errorOf(fileWith(R"({"file": "none.json"})"), ErrorKind::File).find("s.json:/shape/file: "),
            std::string::npos);
  EXPECT_EQ(errorOf(R"({"volcaustic": 1})").find("s.json:/shape: is missing"), 0u);
  EXPECT_NE(errorOf(R"({"volcaustic": 1, "shpae": {}})").find("\"shape\""), std::string::npos);
  EXPECT_NE(errorOf(R"({"shape": {"type": "sphere"}})").find("volcaustic"), std::string::npos);
}

TEST(ShapeJson, BombsEndBeforeTheyGoOff) {
  std::string doubling = R"("shapes": {"d0": {"type": "sphere"})";
  for (int i = 1; i <= 40; ++i) {
    const std::string before = R"({"use": "d)" + std::to_string(i - 1) + "\"}";
    doubling += R"(, "d)" + std::to_string(i) + R"(": {"type": "union", "parts": [)" + before + ", " + before + "]}";
  }
  const std::string line = errorOf(fileWith(R"({"use": "d40"})", doubling + "}"));
  EXPECT_NE(line.find("a million"), std::string::npos) << line;
  expectError(R"({"type": "array", "step": {}, "count": 1e9, "part": {"type": "sphere"}})", "/shape/count", "range");
  expectError(
      R"({"type": "array", "step": {}, "count": 2000, "part": {"type": "array", "step": {}, "count": 2000, "part":
      {"type": "sphere"}}})",
      "/shape", "a million");
  std::string points = "[[0, 0]";
  for (int i = 1; i < 60000; ++i) points += ", [" + std::to_string(i) + ", 1]";
  expectError(R"({"type": "array", "step": {}, "count": 1000, "part": {"type": "revolution", "points": )" + points +
                  "]}}",
              "/shape", "a million");
  // A chain of definitions, each referring to the next one: deep, but not in the text.
  std::string chain = R"("shapes": {"c100000": {"type": "sphere"})";
  for (int i = 0; i < 100000; ++i)
    chain += R"(, "c)" + std::to_string(i) + R"(": {"use": "c)" + std::to_string(i + 1) + "\"}";
  EXPECT_NE(errorOf(fileWith(R"({"use": "c0"})", chain + "}")).find("deep"), std::string::npos);
  EXPECT_NE(errorOf(fileWith(std::string(100000, '['))).find("64 levels"), std::string::npos);
}

TEST(ShapeJson, EveryNumberOfANodeCanBeAnimated) {
  const std::string tracks = R"("shapes": {"ball": {"type": "sphere"}}, "animation": {
      "/shape/parts/0/coefficients/4": [[1, 0], [5, 1]], "/shape/parts/1/translate": [[1, [0, 0, 0]], [5, [4, 0, 0]]],
      "/shape/parts/1/deviations/0/weight": [[1, 0], [5, 2]], "/shape/blend": [[1, 0], [5, 0.4]],
      "/shape/parts/2/points/1/0": [[1, 1], [5, 2]], "/shapes/ball/radius": [[1, 1], [5, 3]],
      "/shape/parts/1/scale/2": [[1, 1], [5, 2]]})";
  const Shape shape = parse(R"({"type": "union", "parts": [{"type": "quadric"},
      {"type": "cone", "deviations": [{"region": {"use": "ball"}}]},
      {"type": "revolution", "points": [[0, 0], [1, 0], [0, 1]]}]})",
                            {{}, 2}, tracks);
  const std::vector<Shape>& parts = shape.node().parts;
  EXPECT_EQ(kindOf<shapes::Union>(shape).blend, 0.1);
  EXPECT_EQ(kindOf<shapes::Quadric>(parts[0]).coefficients[4], 0.25);
  EXPECT_EQ(parts[1].node().placement.translate, (Vec3d{1, 0, 0}));
  EXPECT_EQ(parts[1].node().placement.scale, (Vec3d{1, 1, 1.25})) << "the rest keeps its default";
  EXPECT_EQ(parts[1].node().deviations[0].weight, 0.5);
  EXPECT_EQ(kindOf<shapes::Sphere>(parts[1].node().deviations[0].region).radius, 1.5);
  EXPECT_EQ(kindOf<shapes::Revolution>(parts[2]).profile.points[1][0], 1.25);
  expectError(R"({"type": "sphere"})", "/animation/~1shape~1raduis", "radius",
              R"("animation": {"/shape/raduis": [[1, 1]]})");
  expectError(R"({"type": "noise", "part": {"type": "sphere"}})", "/animation/~1shape~1octaves", "whole",
              R"("animation": {"/shape/octaves": [[1, 1]]})");
  expectError(R"({"type": "sphere"})", "/shape/radius", "range", R"("animation": {"/shape/radius": [[1, -1]]})");
}

TEST(ShapeJson, ValuesSetFromOutsideReachIntoShapes) {
  const std::string pair = R"({"type": "union", "parts": [{"type": "torus"}, {"type": "sphere"}]})";
  EXPECT_EQ(kindOf<shapes::Sphere>(parse(pair, {{"shape.parts.1.radius=0.2"}, 1}).node().parts[1]).radius, 0.2);
  EXPECT_EQ(parse(pair, {{"shape.parts.2={\"type\":\"cone\"}"}, 1}).node().parts.size(), 3u);
  EXPECT_EQ(parse(pair, {{"shape.translate.2=4"}, 1}).node().placement.translate, (Vec3d{0, 0, 4}));
  EXPECT_EQ(parse(pair, {{"shapes.ball={\"type\":\"cone\"}", "shape.parts.0={\"use\":\"ball\"}"}, 1})
                .node()
                .parts[0]
                .node()
                .kind.index(),
            6u);
  EXPECT_NE(errorOf(fileWith(pair), ErrorKind::Usage, {{"shape.parts.1.raduis=1"}, 1}).find("shape.parts.1.radius"),
            std::string::npos);
  EXPECT_NE(errorOf(fileWith(pair), ErrorKind::Usage, {{"shape.parts.1.radius=-1"}, 1}).find("range"),
            std::string::npos);
}

constexpr const char* kScene = R"({"volcaustic": 1, "shapes": {"ball": {"type": "sphere", "radius": 0.5}},
  "objects": [{"shape": {"type": "union", "parts": [{"use": "ball"}, {"type": "cone"}]}, "translate": [1, 0, 0]},
              {"mesh": "a.obj"}, {"shape": {"use": "ball"}, "triangulate": true, "tolerance": 0.01}],
  "animation": {"/objects/0/shape/parts/1/height": [[1, 2], [3, 4]], "/shapes/ball/radius": [[1, 0.5], [3, 1]]}})";

TEST(ShapeInScene, StandsInPlaceOfAMesh) {
  const Scene scene = parseScene(kScene, "scene.json", {{"objects.0.shape.parts.1.radius=0.25"}, 2});
  const std::vector<Shape>& parts = scene.objects[0].shape.node().parts;
  EXPECT_EQ(kindOf<shapes::Sphere>(parts[0]).radius, 0.75);
  EXPECT_EQ(kindOf<shapes::Cone>(parts[1]).height, 3);
  EXPECT_EQ(kindOf<shapes::Cone>(parts[1]).radius, 0.25);
  EXPECT_TRUE(scene.objects[1].shape.empty());
  EXPECT_TRUE(scene.objects[2].triangulate);
  EXPECT_EQ(scene.objects[2].polygonise.tolerance, 0.01);
}

TEST(ShapeInScene, CanonicalFormComesBackTheSame) {
  const Scene scene = parseScene(kScene, "scene.json");
  const Scene again = parseScene(sceneToJson(scene), "scene.json");
  EXPECT_EQ(sceneToJson(again), sceneToJson(scene));
  EXPECT_EQ(shapeHash(again.objects[0].shape), shapeHash(scene.objects[0].shape));
  EXPECT_NE(sceneHash(parseScene(kScene, "scene.json", {{}, 2})), sceneHash(scene));
}

TEST(ShapeInScene, MistakesAreErrorsAtTheirPointer) {
  const auto lineOf = [](const std::string& object) {
    try {
      (void)parseScene(R"({"volcaustic": 1, "objects": [)" + object + "]}", "scene.json");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const auto starts = [&](const std::string& object, const std::string& pointer) {
    EXPECT_TRUE(lineOf(object).starts_with("scene.json:/objects/0" + pointer + ": ")) << lineOf(object);
  };
  starts(R"({})", "/mesh");
  starts(R"({"shape": ""})", "/mesh");
  starts(R"({"shape": 3})", "/shape");
  starts(R"({"shape": "none.json"})", "/shape");
  starts(R"({"shape": {"type": "sphere"}, "mesh": "a.obj"})", "/shape");
  starts(R"({"shape": {"type": "sphere"}, "volume": "a.vdb"})", "/shape");
  starts(R"({"shape": {"type": "sphere"}, "groups": [{"name": "a", "material": "glass"}]})", "/groups");
  starts(R"({"shape": {"type": "sphere"}, "material": "water"})", "/material");
  starts(R"({"shape": {"type": "shell", "part": {"type": "spere"}}})", "/shape/part/type");
}

/// Whatever is done to a file: it is read, or it ends in one line.
TEST(ShapeJson, MutationsAreReadOrEndInOneLine) {
  Shape all = Shape::unite(oneOfEachType(), 0.1).named("all");
  all = Shape::unite({all, Shape::cone(1, 2).bulge(Shape::sphere(1), 3)});
  const std::string text = shapeToJson(all);
  const std::vector<std::string> pieces{"{",
                                        "}",
                                        "[",
                                        "]",
                                        ",",
                                        "1e999",
                                        "-1",
                                        "null",
                                        "\"use\": \"all\",",
                                        "1e300",
                                        "\"type\": \"shell\",",
                                        "\"file\": \".\",",
                                        "0",
                                        "\"",
                                        "\\u0000",
                                        "\xff"};
  std::mt19937 random(5);
  int read = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string changed = text;
    for (int edits = 1 + static_cast<int>(random() % 3); edits > 0; --edits) {
      const std::size_t at = random() % changed.size(), length = random() % 12;
      switch (random() % 3) {
      case 0:
        changed.replace(at, length, pieces[random() % pieces.size()]);
        break;
      case 1:
        changed.erase(at, length);
        break;
      default:
        changed.insert(at, changed.substr(random() % changed.size(), length));
      }
      if (changed.empty()) changed = " ";
    }
    try {
      (void)parseShape(changed, "s.json");
      ++read;
    } catch (const Error& error) {
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with("s.json:")) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      EXPECT_TRUE(error.kind() == ErrorKind::Input || error.kind() == ErrorKind::File) << what;
    }
  }
  EXPECT_GT(read, 20) << "some changes do no harm";
}

} // namespace
} // namespace volcaustic
