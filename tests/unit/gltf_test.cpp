// glTF files as scenes: meshes, placements, materials, lights, cameras, animation, and what bad files end in.
#include "scene/gltf_nodes.h"
#include "scene/scene_meshes.h"
#include "support/gltf_builder.h"
#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/scene.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace volcaustic {
namespace {

using test::GltfBuilder;

/// A tetrahedron that faces outwards, of volume 1/6.
const std::vector<float> kCorners{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::vector<std::uint16_t> kFaces{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
constexpr const char* kGlass =
    R"("materials": [{"name": "glass", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}])";

double volumeOf(const Mesh& mesh) { return checkMesh(mesh).signedVolume; }

class Gltf : public testing::Test {
protected:
  std::string path(const std::string& name = "x.glb") const { return (mFolder / name).string(); }

  std::string write(const std::string& content, const std::string& name = "x.glb") const {
    test::writeFile(path(name), content);
    return path(name);
  }

  /// Sections of a document whose only node (with `nodeMore`) holds the tetrahedron of glass.
  std::string tetrahedron(const std::string& nodeMore = "", const std::string& more = "") {
    const int positions = mBuilder.accessor(kCorners, "VEC3"), indices = mBuilder.accessor(kFaces, "SCALAR");
    std::ostringstream text;
    text << R"("nodes": [{"name": "body", "mesh": 0)" << (nodeMore.empty() ? "" : ", ") << nodeMore
         << R"(}], "meshes": [{"primitives": [{"attributes": {"POSITION": )" << positions << R"(}, "indices": )"
         << indices << R"(, "material": 0}]}], )" << kGlass << (more.empty() ? "" : ", ") << more;
    return text.str();
  }

  Scene read(const std::string& content, const SceneReadOptions& options = {}, const std::string& name = "x.glb") {
    RunContext ctx;
    ctx.onLog = [this](LogLevel level, std::string_view line) {
      if (level == LogLevel::Warning) mWarnings.emplace_back(line);
    };
    return readScene(write(content, name), options, ctx);
  }

  Mesh meshOf(const SceneObject& object) {
    const RunContext ctx;
    return transformed(SceneMeshReader(ctx).read(object.meshFile), affine(object.placement));
  }

  void expectError(const std::string& content, const std::string& start, ErrorKind kind = ErrorKind::Input,
                   const std::string& name = "x.glb") {
    try {
      const Scene scene = read(content, {}, name);
      for (const SceneObject& object : scene.objects) meshOf(object);
      ADD_FAILURE() << "no error; expected " << start;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind) << error.what();
      EXPECT_TRUE(std::string(error.what()).starts_with(path(name) + start)) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }

  [[nodiscard]] bool warned(const std::string& part) const {
    return std::count_if(mWarnings.begin(), mWarnings.end(),
                         [&](const std::string& w) { return w.find(part) != std::string::npos; }) == 1;
  }

  test::TemporaryFolder mFolder;
  GltfBuilder mBuilder;
  std::vector<std::string> mWarnings;
};

TEST_F(Gltf, AMeshIsTheSameInEveryContainer) {
  const std::string sections = tetrahedron();
  test::writeFile(mFolder / "a b.bin", mBuilder.bytes());
  const std::string base64 = "AAAA"; // three zero bytes, to be too short
  for (const auto& [content, name] :
       {std::pair{mBuilder.glb(sections), "x.glb"}, std::pair{mBuilder.json(sections, "a%20b.bin"), "x.gltf"}}) {
    const Scene scene = read(content, {}, name);
    ASSERT_EQ(scene.objects.size(), 1u) << name;
    EXPECT_EQ(scene.objects[0].name, "body");
    EXPECT_NEAR(volumeOf(meshOf(scene.objects[0])), 1.0 / 6, 1e-12) << name;
  }
  expectError(mBuilder.json(sections, "data:application/octet-stream;base64," + base64),
              ":/buffers/0: ", ErrorKind::Input, "x.gltf");
}

TEST_F(Gltf, EmbeddedBuffersAreDecoded) {
  // Nine floats of a triangle: 0 0 0, 1 0 0, 0 1 0.
  const std::string content = R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri":
    "data:application/gltf-buffer;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}], )" +
                              std::string(kGlass) + "}";
  const Mesh mesh = meshOf(read(content, {}, "x.gltf").objects.at(0));
  EXPECT_EQ(mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST_F(Gltf, EveryComponentTypeOfPositionsAndIndices) {
  const std::vector<std::uint8_t> bytes(kFaces.begin(), kFaces.end());
  const std::vector<std::uint32_t> words(kFaces.begin(), kFaces.end());
  const auto scaled = [](auto one) {
    std::vector<decltype(one)> numbers;
    for (const float x : kCorners) numbers.push_back(static_cast<decltype(one)>(x * static_cast<float>(one)));
    return numbers;
  };
  const std::string normalized = R"(, "normalized": true)";
  const std::vector<int> positions{mBuilder.accessor(kCorners, "VEC3"),
                                   mBuilder.accessor(scaled(std::int8_t{127}), "VEC3", normalized),
                                   mBuilder.accessor(scaled(std::uint8_t{255}), "VEC3", normalized),
                                   mBuilder.accessor(scaled(std::int16_t{32767}), "VEC3", normalized),
                                   mBuilder.accessor(scaled(std::uint16_t{65535}), "VEC3", normalized),
                                   mBuilder.accessor(scaled(std::int8_t{1}), "VEC3")};
  const std::vector<int> indices{mBuilder.accessor(bytes, "SCALAR"), mBuilder.accessor(kFaces, "SCALAR"),
                                 mBuilder.accessor(words, "SCALAR")};
  std::string nodes, meshes;
  int count = 0;
  for (const int p : positions)
    for (const int i : indices) {
      nodes += (count ? ", " : "") + std::string(R"({"mesh": )") + std::to_string(count) + "}";
      meshes += (count ? ", " : "") + std::string(R"({"primitives": [{"material": 0, "attributes": {"POSITION": )") +
                std::to_string(p) + R"(}, "indices": )" + std::to_string(i) + "}]}";
      ++count;
    }
  const Scene scene = read(mBuilder.glb(R"("nodes": [)" + nodes + R"(], "meshes": [)" + meshes + "], " + kGlass));
  ASSERT_EQ(scene.objects.size(), 18u);
  for (const SceneObject& object : scene.objects)
    EXPECT_NEAR(volumeOf(meshOf(object)), 1.0 / 6, 1e-9) << object.meshFile;
}

TEST_F(Gltf, StripsFansAndPlainCornersFaceOutwards) {
  std::vector<float> corners; // of each face of the tetrahedron, not indexed
  for (const std::uint16_t i : kFaces)
    corners.insert(corners.end(), kCorners.begin() + 3 * i, kCorners.begin() + 3 * i + 3);
  const int plain = mBuilder.accessor(corners, "VEC3"), shared = mBuilder.accessor(kCorners, "VEC3");
  // Four faces in a strip, and as a fan of three with the fourth face on its own.
  const int strip = mBuilder.accessor(std::vector<std::uint8_t>{0, 2, 1, 3, 0, 2}, "SCALAR");
  const int fan = mBuilder.accessor(std::vector<std::uint8_t>{0, 2, 1, 3, 2}, "SCALAR");
  const int last = mBuilder.accessor(std::vector<std::uint8_t>{1, 2, 3}, "SCALAR");
  const auto primitive = [](int positions, int indices, int mode) {
    return R"({"material": 0, "mode": )" + std::to_string(mode) + R"(, "attributes": {"POSITION": )" +
           std::to_string(positions) + "}" + (indices < 0 ? "" : R"(, "indices": )" + std::to_string(indices)) + "}";
  };
  const Scene scene = read(mBuilder.glb(
      R"("nodes": [{"mesh": 0}, {"mesh": 1}, {"mesh": 2}], "meshes": [{"primitives": [)" + primitive(plain, -1, 4) +
      R"(]}, {"primitives": [)" + primitive(shared, strip, 5) + R"(]}, {"primitives": [)" + primitive(shared, fan, 6) +
      ", " + primitive(shared, last, 4) + ", " + primitive(shared, -1, 1) + "]}], " + kGlass));
  ASSERT_EQ(scene.objects.size(), 3u);
  for (const SceneObject& object : scene.objects) {
    const MeshReport report = checkMesh(meshOf(object));
    EXPECT_NEAR(report.signedVolume, 1.0 / 6, 1e-12) << object.meshFile;
    EXPECT_TRUE(report.closedAndConsistent()) << object.meshFile;
  }
  EXPECT_TRUE(warned("points and lines"));
}

TEST_F(Gltf, SparseAccessorsReplaceWhatTheyName) {
  const int indices = mBuilder.accessor(kFaces, "SCALAR");
  const int at = mBuilder.view(std::vector<std::uint8_t>{1, 3}),
            to = mBuilder.view(std::vector<float>{2, 0, 0, 0, 0, 2});
  const std::string sparse = R"("componentType": 5126, "count": 4, "type": "VEC3", "sparse": {"count": 2,
    "indices": {"bufferView": )" +
                             std::to_string(at) + R"(, "componentType": 5121}, "values": {"bufferView": )" +
                             std::to_string(to) + "}}}";
  const int base = mBuilder.view(kCorners);
  const int dense = mBuilder.rawAccessor(R"({"bufferView": )" + std::to_string(base) + ", " + sparse);
  const int zeros = mBuilder.rawAccessor("{" + sparse);
  const auto mesh = [&](int positions) {
    return R"({"primitives": [{"material": 0, "attributes": {"POSITION": )" + std::to_string(positions) +
           R"(}, "indices": )" + std::to_string(indices) + "}]}";
  };
  const Scene scene = read(mBuilder.glb(R"("nodes": [{"mesh": 0}, {"mesh": 1}], "meshes": [)" + mesh(dense) + ", " +
                                        mesh(zeros) + "], " + kGlass));
  EXPECT_NEAR(volumeOf(meshOf(scene.objects.at(0))), 4.0 / 6, 1e-12);
  EXPECT_EQ(meshOf(scene.objects.at(1)).positions, (std::vector<Vec3d>{{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {0, 0, 2}}));
}

TEST_F(Gltf, PlacementsGoDownTheTreeAndMirrorsKeepFacesOutwards) {
  // A turned child under a parent that is scaled unevenly: sheared; and a mirror.
  const std::string sections =
      tetrahedron(R"("rotation": [0.1, 0.2, 0.3, 0.9], "scale": [1, -2, 3], "translation": [1, 2, 3])");
  std::string content = sections;
  content.replace(content.find(R"("nodes": [)"), 10,
                  R"("scene": 1, "scenes": [{"nodes": []}, {"nodes": [1]}], "nodes": [)");
  content.replace(content.find(R"(}], "meshes")"), 2,
                  R"(}, {"children": [0], "matrix": [2,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}])");
  const Scene scene = read(mBuilder.glb(content));
  ASSERT_EQ(scene.objects.size(), 1u);
  const Mesh mesh = meshOf(scene.objects[0]);
  EXPECT_NEAR(volumeOf(mesh), 2 * 6 / 6.0, 1e-9) << "outwards in spite of the mirror";
  // The first corner goes where both translations put the origin, the second along the turned x axis.
  const double length = std::sqrt(0.1 * 0.1 + 0.2 * 0.2 + 0.3 * 0.3 + 0.9 * 0.9);
  const double x = 0.1 / length, y = 0.2 / length, z = 0.3 / length, w = 0.9 / length;
  const Vec3d origin{5 + 2 * 1, 6 + 2, 7 + 3};
  const Vec3d tip{origin[0] + 2 * (1 - 2 * (y * y + z * z)), origin[1] + 2 * (x * y + w * z),
                  origin[2] + 2 * (x * z - w * y)};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(mesh.positions[0][i], origin[i], 1e-12);
    EXPECT_NEAR(mesh.positions[1][i], tip[i], 1e-12);
  }
}

TEST(GltfPlacement, AnyAffineMapComesBack) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-2, 2);
  for (int trial = 0; trial < 200; ++trial) {
    Affine world;
    for (auto& row : world)
      for (double& x : row) x = trial % 4 == 0 ? std::round(number(random)) : number(random);
    const auto placement = placementOf(world);
    const double determinant = world[0][0] * (world[1][1] * world[2][2] - world[1][2] * world[2][1]) -
                               world[0][1] * (world[1][0] * world[2][2] - world[1][2] * world[2][0]) +
                               world[0][2] * (world[1][0] * world[2][1] - world[1][1] * world[2][0]);
    ASSERT_EQ(placement.has_value(), std::abs(determinant) > 1e-6) << determinant;
    if (!placement) continue;
    const Affine again = affine(*placement);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(again[i][j], world[i][j], 1e-9) << trial;
  }
}

TEST_F(Gltf, MaterialsBecomeIndexAndAttenuation) {
  std::string sections = tetrahedron();
  sections.replace(sections.find(kGlass), std::string(kGlass).size(),
                   R"("extensionsUsed": ["KHR_materials_sheen"], "materials": [{"name": "wine",
    "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}, "KHR_materials_ior": {"ior": 1.33},
    "KHR_materials_dispersion": {"dispersion": 0.3},
    "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [1, 0.5, 0], "attenuationDistance": 0.25}}}])");
  const Scene scene = read(mBuilder.glb(sections));
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "wine");
  EXPECT_EQ(scene.materials[0].index, 1.33);
  EXPECT_EQ(scene.materials[0].attenuation[0], 0);
  EXPECT_NEAR(std::exp(-0.25 * scene.materials[0].attenuation[1]), 0.5, 1e-12);
  EXPECT_NEAR(std::exp(-0.25 * scene.materials[0].attenuation[2]), 1e-6, 1e-12);
  EXPECT_TRUE(warned("dispersion"));
  EXPECT_TRUE(warned("KHR_materials_sheen"));
}

TEST_F(Gltf, PrimitivesOfOtherMaterialsAreObjectsOrReceiversOfTheirOwn) {
  const int positions = mBuilder.accessor(kCorners, "VEC3"), indices = mBuilder.accessor(kFaces, "SCALAR");
  const auto primitive = [&](const std::string& material) {
    return R"({"attributes": {"POSITION": )" + std::to_string(positions) + R"(}, "indices": )" +
           std::to_string(indices) + material + "}";
  };
  const std::string glass =
      R"({"name": "same", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}})";
  const Scene scene = read(mBuilder.glb(
      R"("nodes": [{"mesh": 0, "name": "a"}], "materials": [)" + glass + ", " + glass +
      R"(, {"name": "clay", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1]}}], "meshes": [{"primitives": [)" +
      primitive(R"(, "material": 1)") + ", " + primitive(R"(, "material": 0)") + ", " +
      primitive(R"(, "material": 1)") + ", " + primitive(R"(, "material": 2)") + ", " + primitive("") + "]}]"));
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_TRUE(scene.objects[0].meshFile.string().ends_with("x.glb#/meshes/0/primitives/0,2"));
  EXPECT_EQ(meshOf(scene.objects[0]).triangles.size(), 8u);
  EXPECT_TRUE(scene.objects[1].meshFile.string().ends_with("x.glb#/meshes/0/primitives/1"));
  EXPECT_NE(scene.objects[0].material, scene.objects[1].material) << "equal names stay apart";
  EXPECT_TRUE(scene.objects[0].visible && scene.objects[1].visible);
  ASSERT_EQ(scene.receivers.size(), 2u);
  EXPECT_EQ(scene.receivers[0].albedo, (Rgb{.5, .25, .125}));
  EXPECT_EQ(scene.receivers[1].albedo, (Rgb{.8, .8, .8})) << "of no material";
  EXPECT_TRUE(scene.receivers[0].meshFile.string().ends_with("x.glb#/meshes/0/primitives/3"));
  EXPECT_EQ(scene.receivers[0].name, "a");
  EXPECT_EQ(scene.receivers[1].name, "a.1");
  EXPECT_EQ(scene.materials.size(), 2u);
}

TEST_F(Gltf, LightsAreWatts) {
  std::string sections = tetrahedron("", R"("extensions": {"KHR_lights_punctual": {"lights": [
    {"type": "directional", "intensity": 2049, "color": [1, 0.5, 0]}, {"type": "point", "intensity": 683}, {"type": "spot", "spot": {"outerConeAngle": 0.5}}]}})");
  sections.replace(sections.find(R"("nodes": [)"), 10, R"("nodes": [
    {"extensions": {"KHR_lights_punctual": {"light": 0}}, "rotation": [-0.70710678118654752, 0, 0, 0.70710678118654752]},
    {"extensions": {"KHR_lights_punctual": {"light": 1}}, "translation": [1, 2, 3]},
    {"extensions": {"KHR_lights_punctual": {"light": 2}}}, )");
  const Scene scene = read(mBuilder.glb(sections));
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_NEAR(scene.lights[0].irradiance[0], 3, 1e-12);
  EXPECT_NEAR(scene.lights[0].irradiance[1], 1.5, 1e-12);
  EXPECT_NEAR(scene.lights[0].direction[1], -1, 1e-12) << "a quarter turn about x points -z down";
  EXPECT_EQ(scene.lights[1].position, (Vec3d{1, 2, 3}));
  EXPECT_NEAR(scene.lights[1].intensity[2], 1, 1e-12);
  EXPECT_EQ(scene.lights[2].type, LightType::Spot);
  EXPECT_EQ(scene.lights[2].direction, (Vec3d{0, 0, -1}));
  EXPECT_NEAR(scene.lights[2].outerAngle, 90 / std::numbers::pi, 1e-9);
  EXPECT_EQ(scene.lights[2].innerAngle, 0);
  EXPECT_FALSE(warned("no light"));
}

TEST_F(Gltf, CamerasAreTheFirstOrTheNamedOne) {
  std::string sections = tetrahedron("", R"("cameras": [
    {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 2, "znear": 1}},
    {"type": "perspective", "name": "wide", "perspective": {"yfov": 1, "znear": 0.1, "aspectRatio": 2}},
    {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}])");
  sections.replace(sections.find(R"("nodes": [)"), 10,
                   R"("nodes": [{"camera": 0}, {"camera": 1, "translation": [0, 1, 5]},
    {"camera": 2, "name": "far", "translation": [0, 0, 50]}, )");
  const std::string content = mBuilder.glb(sections);
  const Camera first = read(content).camera;
  EXPECT_EQ(first.position, (Vec3d{0, 1, 5}));
  EXPECT_EQ(first.target, (Vec3d{0, 1, 4}));
  EXPECT_EQ(first.up, (Vec3d{0, 1, 0}));
  EXPECT_NEAR(first.fieldOfView, 180 / std::numbers::pi, 1e-9);
  EXPECT_EQ(first.resolution, (std::array<int, 2>{1024, 512}));
  EXPECT_TRUE(warned("orthographic"));
  SceneReadOptions named;
  named.camera = "far";
  EXPECT_EQ(read(content, named).camera.position[2], 50);
  named.camera = "fat";
  try {
    read(content, named);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("\"far\""), std::string::npos) << error.what();
  }
}

TEST_F(Gltf, WithoutACameraTheWholeBodyIsInSight) {
  const Scene scene = read(mBuilder.glb(tetrahedron(R"("translation": [10, 20, 30], "scale": [5, 5, 5])")));
  const Camera& c = scene.camera;
  const double half = std::tan(c.fieldOfView * std::numbers::pi / 360);
  Vec3d ahead;
  double distance = 0;
  for (std::size_t i = 0; i < 3; ++i) distance = std::hypot(distance, ahead[i] = c.target[i] - c.position[i]);
  for (const Vec3d& p : meshOf(scene.objects[0]).positions) {
    double along = 0, square = 0;
    for (std::size_t i = 0; i < 3; ++i) along += (p[i] - c.position[i]) * ahead[i] / distance;
    for (std::size_t i = 0; i < 3; ++i) square += std::pow(p[i] - c.position[i] - along * ahead[i] / distance, 2);
    EXPECT_LT(std::sqrt(square), half * along);
  }
  EXPECT_EQ(scene.lights.size(), 1u) << "a sun where the file has no light";
  EXPECT_TRUE(warned("no light"));
}

TEST_F(Gltf, AnimationsAreSampledAtTheFrame) {
  const auto animated = [&](const std::string& interpolation, int times, int values, const std::string& path) {
    return tetrahedron("", R"("animations": [{"samplers": [{"input": )" + std::to_string(times) + R"(, "output": )" +
                               std::to_string(values) + R"(, "interpolation": ")" + interpolation +
                               R"("}], "channels": [{"sampler": 0, "target": {"node": 0, "path": ")" + path +
                               R"("}}]}])");
  };
  const int times = mBuilder.accessor(std::vector<float>{1, 2}, "SCALAR");
  const int moves = mBuilder.accessor(std::vector<float>{0, 0, 0, 4, 0, 0}, "VEC3");
  const int splines =
      mBuilder.accessor(std::vector<float>{9, 9, 9, 0, 0, 0, 8, 0, 0, 0, 0, 0, 4, 0, 0, 7, 7, 7}, "VEC3");
  const float h = std::sqrt(0.5f);
  const int turns = mBuilder.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, -h, -h}, "VEC4"); // the long way round
  const auto xAt = [&](const std::string& interpolation, int values, double frame) {
    SceneReadOptions options;
    options.frame = frame;
    options.framesPerSecond = 10;
    return read(mBuilder.glb(animated(interpolation, times, values, "translation")), options)
        .objects.at(0)
        .placement.translate[0];
  };
  EXPECT_EQ(xAt("LINEAR", moves, 0), 0);
  EXPECT_NEAR(xAt("LINEAR", moves, 12.5), 1, 1e-12);
  EXPECT_EQ(xAt("LINEAR", moves, 99), 4);
  EXPECT_EQ(xAt("STEP", moves, 19.9), 0);
  EXPECT_EQ(xAt("STEP", moves, 20), 4);
  EXPECT_NEAR(xAt("CUBICSPLINE", splines, 15), 0.5 * 4 + 0.125 * 8, 1e-12)
      << "Hermite: half the way and an eighth of the tangent";
  SceneReadOptions options;
  options.frame = 36; // 1.5 s at 24 frames a second
  const Scene scene = read(mBuilder.glb(animated("LINEAR", times, turns, "rotation")), options);
  EXPECT_NEAR(scene.objects.at(0).placement.rotate[2], 45, 1e-5) << "the short way, half of it";
}

TEST_F(Gltf, TheCanonicalSceneHasTheSameHash) {
  const Scene scene = read(mBuilder.glb(tetrahedron(R"("rotation": [0.1, 0.2, 0.3, 0.9], "scale": [-1, 2, 3])")));
  const std::string json = sceneToJson(scene);
  EXPECT_NE(json.find("x.glb#/meshes/0"), std::string::npos);
  const Scene again = parseScene(json, "scene.json");
  EXPECT_EQ(sceneHash(again), sceneHash(scene));
  EXPECT_EQ(meshOf(again.objects.at(0)).positions, meshOf(scene.objects.at(0)).positions);
  EXPECT_EQ(sceneMeshFile(scene.objects[0].meshFile), path());
  EXPECT_EQ(sceneMeshFile("a#/b.obj"), "a#/b.obj");
}

TEST_F(Gltf, AnyOptionOfTheSceneCanBeSet) {
  SceneReadOptions options;
  options.sets = {"volume.resolution=64", "objects.0.priority=3"};
  const Scene scene = read(mBuilder.glb(tetrahedron()), options);
  EXPECT_EQ(scene.volume.resolution, 64);
  EXPECT_EQ(scene.objects[0].priority, 3);
}

TEST_F(Gltf, ScaleZeroHidesAnObject) {
  const Scene scene = read(mBuilder.glb(tetrahedron(R"("scale": [0, 0, 0])")), {{"objects.0.visible=true"}});
  EXPECT_EQ(scene.objects.size(), 1u);
}

TEST_F(Gltf, BadFilesEndInOneLineThatNamesThePlace) {
  const std::string good = tetrahedron();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return mBuilder.glb(text.replace(at, from.size(), to));
  };
  expectError(with(R"("mesh": 0)", R"("mesh": 7)"), ":/nodes/0/mesh: ");
  expectError(with(R"("mesh": 0)", R"("mesh": -1)"), ":/nodes/0/mesh: ");
  expectError(with(R"("mesh": 0)", R"("mesh": "0")"), ":/nodes/0/mesh: ");
  expectError(with(R"("mesh": 0)", R"("mesh": 0, "children": [0])"), ":");
  expectError(with(R"("mesh": 0)", R"("mesh": 0, "matrix": [1, 2])"), ":/nodes/0/matrix: ");
  expectError(with(R"("mesh": 0)", R"("mesh": 0, "rotation": [0, 0, 0, 0])"), ":/nodes/0/rotation: ");
  expectError(with(R"("mesh": 0)", R"("mesh": 0, "translation": [1e200, 0, 0])"), ":/nodes/0");
  expectError(with(R"("POSITION": 0)", R"("POSITION": 1)"), ":/accessors/1/type: ");
  expectError(with(R"("POSITION": 0)", R"("NORMAL": 0)"), ":/meshes/0/primitives/0/attributes: ");
  expectError(with(R"("indices": 1)", R"("indices": 1, "mode": 9)"), ":/meshes/0/primitives/0/mode: ");
  expectError(with(R"("transmissionFactor": 1)", R"("transmissionFactor": 2)"), ":/materials/0/extensions/");
  expectError(with(R"("materials")", R"("extensionsRequired": ["KHR_draco_mesh_compression"], "materials")"),
              ":/extensionsRequired/0: ");
}

TEST_F(Gltf, BadNumbersEndInOneLineThatNamesThePlace) {
  const auto tetrahedronOf = [](const std::string& position, const std::string& index, const std::string& more) {
    return R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 3, "uri": "data:;base64,AAAA"}],
      "bufferViews": [{"buffer": 0, "byteLength": 3)" +
           more + R"(}], "accessors": [)" + position + ", " + index +
           R"(], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"material": 0, "attributes": {"POSITION": 0}, "indices": 1}]}], )" +
           kGlass + "}";
  };
  const std::string zeros = R"({"componentType": 5126, "count": 4, "type": "VEC3"})";
  const std::string three = R"({"bufferView": 0, "componentType": 5121, "count": 3, "type": "SCALAR"})";
  const auto expect = [&](const std::string& content, const std::string& start) {
    expectError(content, start, ErrorKind::Input, "x.gltf");
  };
  expect(tetrahedronOf(R"({"componentType": 5126, "count": 99999999999, "type": "VEC3"})", three, ""),
         ":/accessors/0/count: ");
  expect(tetrahedronOf(R"({"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3"})", three, ""),
         ":/accessors/0: ");
  expect(tetrahedronOf(zeros,
                       R"({"bufferView": 0, "componentType": 5121, "count": 9007199254740991, "type": "SCALAR"})", ""),
         ":/accessors/1: ");
  expect(tetrahedronOf(
             zeros, R"({"bufferView": 0, "byteOffset": 1, "componentType": 5121, "count": 3, "type": "SCALAR"})", ""),
         ":/accessors/1: ");
  expect(tetrahedronOf(zeros, three, R"(, "byteOffset": 1)"), ":/bufferViews/0: ");
  expect(tetrahedronOf(zeros, three, R"(, "byteStride": 300)"), ":/bufferViews/0/byteStride: ");
  expect(tetrahedronOf(zeros, R"({"bufferView": 0, "componentType": 5121, "count": 2, "type": "SCALAR"})", ""),
         ":/meshes/0/primitives/0: ");
  expect(tetrahedronOf(zeros, R"({"bufferView": 0, "componentType": 5120, "count": 3, "type": "SCALAR"})", ""),
         ":/accessors/1/componentType: ");
  expect(R"({"asset": {"version": "2.0"}, "asset": {}})", ":/asset: ");
  expect(R"({"asset": {"version": "1.0"}})", ":/asset/version: ");
  expect(R"({"asset": )", ":1:");
  expect("[" + std::string(100000, '['), ":");
}

TEST_F(Gltf, NumbersThatAreNotFiniteAreFound) {
  std::vector<float> corners = kCorners;
  corners[4] = std::numeric_limits<float>::quiet_NaN();
  mBuilder.accessor(corners, "VEC3");
  std::string sections = tetrahedron();
  sections.replace(sections.find(R"("POSITION": 1)"), 13, R"("POSITION": 0)");
  expectError(mBuilder.glb(sections), ":/accessors/0: ");
}

TEST_F(Gltf, ContainersThatLieAreFound) {
  const std::string good = mBuilder.glb(tetrahedron());
  const auto withWord = [&](std::size_t at, std::size_t value) {
    return std::string(good).replace(at, 4, GltfBuilder::word(value));
  };
  expectError(withWord(4, 1), ": is of version");
  expectError(withWord(8, good.size() + 1), ": says that it is");
  expectError(withWord(8, 0xffffffff), ": says that it is");
  expectError(withWord(12, 0xfffffff0), ": has a chunk");
  expectError(withWord(16, 0), ": does not start with a JSON chunk");
  expectError(good.substr(0, 10), ": ends in its header");
  expectError(good.substr(0, good.size() - 4), ": says that it is");
  expectError("", ":1:1: not JSON");
}

TEST_F(Gltf, MissingFilesAreNamed) {
  const std::string sections = tetrahedron();
  expectError(mBuilder.json(sections, "gone.bin"), ":/buffers/0/uri: no such file", ErrorKind::File, "x.gltf");
  expectError(mBuilder.json(sections, "/etc/passwd"), ":/buffers/0/uri: ", ErrorKind::Input, "x.gltf");
  expectError(mBuilder.json(sections, "https://example.org/a.bin"), ":/buffers/0/uri: ", ErrorKind::Input, "x.gltf");
  EXPECT_THROW(readScene(path("none.glb")), Error);
}

TEST_F(Gltf, DamagedFilesEndInAnErrorOrAScene) {
  const std::string good = mBuilder.glb(tetrahedron(R"("translation": [1, 2, 3])"));
  std::mt19937 random(5);
  int errors = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    std::string bad = good;
    for (unsigned edits = 1 + random() % 4; edits > 0; --edits) {
      const std::size_t at = random() % bad.size();
      switch (random() % 4) {
      case 0:
        bad[at] = static_cast<char>(random());
        break;
      case 1:
        bad[at] = static_cast<char>('0' + random() % 10);
        break;
      case 2:
        bad.erase(at, 1 + random() % 6);
        break;
      default:
        bad.insert(at, bad.substr(random() % bad.size(), random() % 20));
      }
      if (bad.empty()) bad = "x";
    }
    try {
      const Scene scene = read(bad);
      for (const SceneObject& object : scene.objects)
        if (object.visible) meshOf(object);
    } catch (const Error& error) {
      ++errors;
      EXPECT_TRUE(error.kind() == ErrorKind::Input || error.kind() == ErrorKind::File) << error.what();
      EXPECT_TRUE(std::string(error.what()).starts_with(path())) << error.what();
    }
  }
  EXPECT_GT(errors, 500);
}

} // namespace
} // namespace volcaustic
