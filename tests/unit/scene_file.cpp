// The scene file: reading, its errors, and the canonical form.
#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/scene.h"

#include <fstream>
#include <gtest/gtest.h>

namespace volcaustic {
namespace {

/// A scene that is whole but for `sections`.
std::string sceneWith(const std::string& sections) {
  return R"({"volcaustic": 1, "objects": [{"mesh": "ball.obj"}])" + (sections.empty() ? "" : ", " + sections) + "}";
}

Scene parse(const std::string& sections, const SceneReadOptions& options = {}) {
  return parseScene(sceneWith(sections), "scene.json", options);
}

/// The message of the error that `text` ends in, and its kind.
std::pair<std::string, ErrorKind> errorOf(const std::string& text, const SceneReadOptions& options = {}) {
  try {
    parseScene(text, "scene.json", options);
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "an error is one line";
    return {error.what(), error.kind()};
  }
  ADD_FAILURE() << "no error for: " << text;
  return {"", ErrorKind::Internal};
}

void expectError(const std::string& sections, const std::string& start, const std::string& part = "") {
  const auto [message, kind] = errorOf(sceneWith(sections));
  EXPECT_EQ(kind, ErrorKind::Input) << message;
  EXPECT_TRUE(message.starts_with("scene.json:" + start)) << message;
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(SceneFile, KeysNotGivenKeepTheDefaults) {
  const Scene scene = parse("");
  EXPECT_EQ(scene.photons.grid, (std::array<int, 2>{1024, 1024}));
  EXPECT_EQ(scene.voxelise.blur, 9);
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "glass");
}

TEST(SceneFile, ReadsEverySection) {
  const Scene scene = parseScene(R"(// comments are welcome
    {
      "$schema": "scene.schema.json", "volcaustic": 1,
      "volume": {"bounds": {"min": [-1, -2, -3], "max": [1, 2, 3]}, "voxelSize": 0.1, "index": 1.33,
                 "attenuation": [0.3, 0.2, 0.1], "scattering": [0.1, 0.1, 0.1], "asymmetry": -0.5},
      "materials": {"water": {"index": 1.33}, "amber": {"index": 1.55, "attenuation": [0, 1, 2]}},
      "objects": [{"name": "drop", "mesh": "meshes/drop.ply", "translate": [1, 2, 3], "rotate": [0, 90, 0],
                   "scale": [2, 2, 2], "material": "amber", "priority": 3, "visible": false}],
      "lights": [{"type": "point", "position": [0, 0, 5], "intensity": [100, 90, 80]},
                 {"direction": [1, 0, -1], "irradiance": [3, 2, 1]}], /* the sun */
      "voxelise": {"supersample": 2, "blur": 5, "fill": "winding"},
      "stepField": {"cap": 4}, "photons": {"scheme": "euler", "grid": [64, 32], "jitter": true},
      "camera": {"resolution": [320, 240]}, "background": {"top": [1, 1, 1]}, "view": {"samples": 2}
    })",
                                 "/far/away/scene.json");
  EXPECT_FALSE(scene.volume.automatic);
  EXPECT_EQ(scene.volume.bounds.min, (Vec3d{-1, -2, -3}));
  EXPECT_EQ(scene.volume.ambient.attenuation, (Rgb{0.3, 0.2, 0.1}));
  EXPECT_EQ(scene.volume.ambient.asymmetry, -0.5);
  ASSERT_EQ(scene.materials.size(), 2u) << "materials in a file replace the default ones";
  EXPECT_EQ(scene.materials[1].name, "amber");
  EXPECT_EQ(scene.objects[0].meshFile, "/far/away/meshes/drop.ply");
  EXPECT_EQ(scene.objects[0].priority, 3);
  EXPECT_FALSE(scene.objects[0].visible);
  EXPECT_EQ(scene.lights[0].type, LightType::Point);
  EXPECT_EQ(scene.lights[1].irradiance, (Rgb{3, 2, 1}));
  EXPECT_EQ(scene.voxelise.fill, FillRule::Winding);
  EXPECT_EQ(scene.photons.scheme, Scheme::Euler);
  EXPECT_TRUE(scene.photons.jitter);
}

TEST(SceneFile, RelativePathsStartAtTheFile) {
  EXPECT_EQ(parseScene(sceneWith(""), "a/b/../scene.json").objects[0].meshFile, "a/ball.obj");
  EXPECT_EQ(parseScene(R"({"volcaustic": 1, "volume": {"file": "/x/fog.vdb"}})", "a/scene.json").volume.file,
            "/x/fog.vdb");
}

TEST(SceneFile, SyntaxErrorsCarryLineAndColumn) {
  EXPECT_TRUE(errorOf("{\n  \"volcaustic\": 1,\n  \"lights\" [\n}").first.starts_with("scene.json:3:12: "))
      << errorOf("{\n  \"volcaustic\": 1,\n  \"lights\" [\n}").first;
  EXPECT_TRUE(errorOf("").first.starts_with("scene.json:1:1: "));
  EXPECT_TRUE(errorOf("{\"volcaustic\": 1e999}").first.starts_with("scene.json:1:"));
  EXPECT_TRUE(errorOf("{\"volcaustic\": \"\xff\"}").first.starts_with("scene.json:1:"));
}

TEST(SceneFile, HostileDocumentsEndInOneLine) {
  EXPECT_TRUE(errorOf(std::string(1000000, '[')).first.starts_with("scene.json:"));
  EXPECT_EQ(errorOf("[1, 2]").second, ErrorKind::Input);
  EXPECT_EQ(errorOf("null").second, ErrorKind::Input);
  expectError(R"("lights": [{"name": 3}])", "/lights/0/name: ", "string");
  expectError(R"("photons": [])", "/photons: ", "object");
  expectError(R"("lights": {})", "/lights: ", "array");
  expectError(R"("materials": {"glass": 1.5})", "/materials/glass: ", "object");
}

TEST(SceneFile, DuplicateKeysAreErrorsAtTheirPointer) {
  expectError(R"("lights": [{}, {"name": "a", "name": "b"}])", "/lights/1/name: ", "twice");
  expectError(R"("objects": [])", "/objects: ", "twice");
}

TEST(SceneFile, UnknownKeysNameTheNearestOne) {
  expectError(R"("lights": [{"irradance": [1, 1, 1]}])", "/lights/0/irradance: ", "\"irradiance\"");
  expectError(R"("photon": {})", "/photon: ", "\"photons\"");
  expectError(R"("volume": {"bounds": {"min": [0, 0, 0], "max": [1, 1, 1], "mid": 0}})", "/volume/bounds/mid: ");
  expectError(R"("photons": {"scheme": "eulr"})", "/photons/scheme: ", "\"euler\"");
  expectError(R"("objects2": 1, "a/b": 1)", "/objects2: ");
  expectError(R"("a/b": 1)", "/a~1b: ");
}

TEST(SceneFile, ChecksTypeRangeChoicesAndLength) {
  expectError(R"("lights": [{"irradiance": [1, -1, 1]}])", "/lights/0/irradiance/1: ", "-1");
  expectError(R"("lights": [{"irradiance": [1, 1]}])", "/lights/0/irradiance: ", "array of 3");
  expectError(R"("lights": [{"irradiance": 1}])", "/lights/0/irradiance: ", "array of 3");
  expectError(R"("voxelise": {"supersample": 3})", "/voxelise/supersample: ", "1, 2, 4, 8");
  expectError(R"("photons": {"grid": [1.5, 2]})", "/photons/grid/0: ", "whole");
  expectError(R"("photons": {"grid": [0, 2]})", "/photons/grid/0: ", "range");
  expectError(R"("photons": {"maxSteps": 1e30})", "/photons/maxSteps: ", "range");
  expectError(R"("photons": {"jitter": 1})", "/photons/jitter: ", "true or false");
  expectError(R"("volume": {"asymmetry": 1})", "/volume/asymmetry: ");
  expectError(R"("volume": {"index": "1.5"})", "/volume/index: ", "number");
  EXPECT_EQ(parse(R"("photons": {"grid": [512.0, 2e2]})").photons.grid, (std::array<int, 2>{512, 200}));
}

TEST(SceneFile, ChecksFieldsAgainstEachOther) {
  expectError(R"("volume": {"scattering": [0, 0.1, 0]})", "/volume/scattering/1: ", "attenuation");
  expectError(R"("materials": {"glass": {"attenuation": [1, 1, 1], "scattering": [1, 1, 1.5]}})",
              "/materials/glass/scattering/2: ");
  expectError(R"("materials": {"glas": {}, "water": {}})", "/objects/0/material: ", "\"glas\"");
  expectError(R"("volume": {"bounds": {"min": [0, 0, 0], "max": [1, 0, 1]}})", "/volume/bounds/max/1: ");
  expectError(R"("volume": {"bounds": {"min": [0, 0, 0]}})", "/volume/bounds/max: ", "missing");
  expectError(R"("volume": {"bounds": "automatic"})", "/volume/bounds: ");
  expectError(R"("volume": {"file": "fog.vdb"})", "/volume/file: ", "objects");
  expectError(R"("lights": [{"direction": [0, 0, 0]}])", "/lights/0/direction: ");
  expectError(R"("camera": {"position": [1, 1, 1], "target": [1, 1, 1]})", "/camera/target: ");
  expectError(R"("camera": {"position": [0, 0, 3], "target": [0, 0, 0], "up": [0, 0, -2]})", "/camera/up: ");
  expectError(R"("photons": {"minStep": 8, "maxStep": 4})", "/photons/maxStep: ");
  expectError(R"("stepField": {"indexTolerance": 0.5})", "/stepField/indexTolerance2: ");
  EXPECT_TRUE(
      errorOf(R"({"volcaustic": 1, "objects": [{}]})").first.starts_with("scene.json:/objects/0/mesh: is missing"));
  EXPECT_TRUE(errorOf(R"({"volcaustic": 1})").first.starts_with("scene.json:/volume/bounds: "));
}

/// A scene whose object has these groups.
std::string sceneWithGroups(const std::string& groups) {
  return R"({"volcaustic": 1, "materials": {"glass": {}, "wine": {"index": 1.34}},
             "objects": [{"mesh": "goblet.obj", "groups": )" +
         groups + "}]}";
}

TEST(SceneFile, GroupsOfAnObjectHaveMaterials) {
  const Scene scene =
      parseScene(sceneWithGroups(
                     R"([{"name": "red wine", "material": "wine", "priority": 2}, {"name": "", "material": "glass"}])"),
                 "scene.json", {{"objects.0.groups.1.material=wine"}, 1});
  const std::vector<SceneGroup>& groups = scene.objects.at(0).groups;
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].name, "red wine");
  EXPECT_EQ(groups[0].priority, 2);
  EXPECT_EQ(groups[1].material, "wine") << "set from outside";
  const std::string text = sceneToJson(scene);
  EXPECT_EQ(sceneToJson(parseScene(text, "scene.json")), text);
  EXPECT_NE(sceneHash(scene), sceneHash(parseScene(sceneWithGroups("[]"), "scene.json")));
}

TEST(SceneFile, ErrorsInGroupsCarryTheirPointer) {
  const auto expect = [](const std::string& groups, const std::string& start, const std::string& part) {
    const std::string message = errorOf(sceneWithGroups(groups)).first;
    EXPECT_TRUE(message.starts_with("scene.json:/objects/0/groups" + start)) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(R"({})", ": ", "array");
  expect(R"(["wine"])", "/0: ", "object");
  expect(R"([{"material": "wine"}])", "/0/name: ", "missing");
  expect(R"([{"name": "a"}])", "/0/material: ", "missing");
  expect(R"([{"name": "a", "material": "wnie"}])", "/0/material: ", "\"wine\"");
  expect(R"([{"name": "a", "material": "wine"}, {"name": "a", "material": "glass"}])", "/1/name: ", "twice");
  expect(R"([{"name": "a", "material": "wine", "prority": 1}])", "/0/prority: ", "\"priority\"");
}

TEST(SceneFile, VersionIsRequired) {
  EXPECT_TRUE(errorOf("{}").first.starts_with("scene.json:/volcaustic: is missing"));
  EXPECT_TRUE(errorOf(R"({"volcaustic": 2})").first.starts_with("scene.json:/volcaustic: version 2"));
  EXPECT_TRUE(errorOf(R"({"volcaustic": "1"})").first.starts_with("scene.json:/volcaustic: version"));
}

TEST(SceneFile, MissingFilesAndFoldersAreFileErrors) {
  for (const char* path : {"/nowhere/scene.json", "/"}) try {
      readScene(path);
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::File) << error.what();
      EXPECT_TRUE(std::string(error.what()).starts_with(path)) << error.what();
    }
}

TEST(SceneFile, CanonicalFormIsAFixedPoint) {
  const Scene scene = parse(R"("lights": [{"direction": [0.1, 0.2, -0.3]}, {"type": "point", "name": "\u00e9\"/~"}],
    "materials": {"glass": {}, "a": {"index": 1.1}}, "volume": {"bounds": {"min": [-1, -1, -1], "max": [1, 1, 1.5]}},
    "voxelise": {"fill": "exact"}, "photons": {"cutoff": 1e-7})");
  const std::string text = sceneToJson(scene);
  const Scene again = parseScene(text, "scene.json");
  EXPECT_EQ(sceneToJson(again), text);
  EXPECT_EQ(sceneHash(again), sceneHash(scene));
  EXPECT_EQ(again.lights[0].direction[0], 0.1) << "numbers survive bit by bit";
  EXPECT_EQ(sceneHash(scene).size(), 16u);
  EXPECT_NE(sceneHash(parse(R"("photons": {"cutoff": 2e-4})")), sceneHash(parse("")));
  EXPECT_EQ(sceneHash(parse(R"("photons": {"cutoff": 1e-4})")), sceneHash(parse("")))
      << "a default said aloud is the default";
}

TEST(SceneFile, TemplateParsesAndIsComplete) {
  const std::string text = sceneTemplate();
  const Scene scene = parseScene(text, "scene.json");
  EXPECT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.lights.size(), 1u);
  // Every key of the canonical form is in the template, in the same order, under a comment.
  std::size_t at = 0;
  const std::string canonical = sceneToJson(scene);
  for (std::size_t quote = canonical.find("\": "); quote != std::string::npos;
       quote = canonical.find("\": ", quote + 1)) {
    const std::string key =
        canonical.substr(canonical.rfind('"', quote - 1), quote + 3 - canonical.rfind('"', quote - 1));
    at = text.find(key, at);
    ASSERT_NE(at, std::string::npos) << key;
  }
  EXPECT_NE(text.find("// refractive index"), std::string::npos);
  EXPECT_NE(text.find("[1/world]"), std::string::npos);
}

TEST(Placement, ScalesThenRotatesAboutXYZThenTranslates) {
  Placement placement;
  placement.scale = {2, 3, 4};
  placement.rotate = {90, 0, 90};
  placement.translate = {10, 20, 30};
  const Affine m = affine(placement);
  // (1, 0, 0) -> scale (2, 0, 0) -> about x: same -> about z by 90: (0, 2, 0).
  EXPECT_EQ((Vec3d{m[0][0], m[1][0], m[2][0]}), (Vec3d{0, 2, 0}));
  // (0, 1, 0) -> (0, 3, 0) -> about x: (0, 0, 3) -> about z: same.
  EXPECT_EQ((Vec3d{m[0][1], m[1][1], m[2][1]}), (Vec3d{0, 0, 3}));
  // (0, 0, 1) -> (0, 0, 4) -> about x: (0, -4, 0) -> about z: (4, 0, 0).
  EXPECT_EQ((Vec3d{m[0][2], m[1][2], m[2][2]}), (Vec3d{4, 0, 0}));
  EXPECT_EQ((Vec3d{m[0][3], m[1][3], m[2][3]}), (Vec3d{10, 20, 30}));
  EXPECT_EQ(affine({}), kIdentity);
  placement = {};
  placement.rotate = {0, 30, 0};
  EXPECT_NEAR(affine(placement)[0][2], 0.5, 1e-15) << "right-handed: z turns towards x about y";
}

} // namespace
} // namespace volcaustic
