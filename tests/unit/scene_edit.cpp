// Values set from outside, and animation tracks.
#include "volcaustic/error.h"
#include "volcaustic/scene.h"

#include <gtest/gtest.h>

namespace volcaustic {
namespace {

constexpr const char* kScene = R"({"volcaustic": 1, "objects": [{"mesh": "ball.obj"}, {"mesh": "b.obj"}],
  "lights": [{"irradiance": [1, 2, 3]}],
  "animation": {"/lights/0/direction": [[1, [1, 0, 0]], [3, [0, 1, 0]], [5, [0, 1, -4]]],
                "/camera/fieldOfView": [[10, 20], [20, 40]]}})";

Scene parse(const std::vector<std::string>& sets, double frame = 1) {
  return parseScene(kScene, "s.json", {sets, frame});
}

void expectError(const std::string& text, const SceneReadOptions& options, ErrorKind kind, const std::string& start,
                 const std::string& part = "") {
  try {
    parseScene(text, "s.json", options);
    ADD_FAILURE() << "no error; expected " << start;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    EXPECT_TRUE(std::string(error.what()).starts_with(start)) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}
void expectSetError(const std::string& set, const std::string& part) {
  expectError(kScene, {{set}, 1}, ErrorKind::Usage, "set " + set + ": ", part);
}
void expectTrackError(const std::string& tracks, const std::string& start, const std::string& part = "") {
  expectError(R"({"volcaustic": 1, "objects": [{"mesh": "a.obj"}], "animation": {)" + tracks + "}}", {},
              ErrorKind::Input, "s.json:/animation/" + start, part);
}

TEST(SceneSet, ReplacesAndMakesValues) {
  EXPECT_EQ(parse({"photons.grid=[512,256]"}).photons.grid, (std::array<int, 2>{512, 256}));
  EXPECT_EQ(parse({"photons.grid.1=7"}).photons.grid, (std::array<int, 2>{1024, 7})) << "the rest keeps its default";
  EXPECT_EQ(parse({"lights.0.irradiance.2=9"}).lights[0].irradiance, (Rgb{1, 2, 9}));
  EXPECT_EQ(parse({"objects.0.scale.1=2"}).objects[0].placement.scale, (Vec3d{1, 2, 1})) << "in lists, too";
  EXPECT_EQ(parse({"materials.glass.index=1.7"}).materials[0].index, 1.7);
  EXPECT_EQ(parse({"photons.scheme=euler"}).photons.scheme, Scheme::Euler) << "a bare word is a string";
  EXPECT_EQ(parse({"objects.1.mesh=c d.obj"}).objects[1].meshFile, "c d.obj");
  EXPECT_EQ(parse({"objects.1.visible=false"}).objects[1].visible, false);
  EXPECT_FALSE(parse({"volume.bounds={\"min\":[0,0,0],\"max\":[1,1,1]}"}).volume.automatic);
  EXPECT_EQ(parse({"view.samples=2", "view.samples=3"}).view.samples, 3) << "in order";
}

TEST(SceneSet, AddsAnElementOrANameWhenWhole) {
  EXPECT_EQ(parse({"lights.1={\"type\":\"point\"}"}).lights.size(), 2u);
  EXPECT_EQ(parse({"materials.water={\"index\":1.33}", "objects.0.material=water"}).materials.size(), 2u);
}

TEST(SceneSet, UnknownPathsNameTheNearest) {
  expectSetError("photns.grid=1", "\"photons\"");
  expectSetError("photons.gird=1", "\"photons.grid\"");
  expectSetError("materials.glas.index=1", "\"materials.glass\"");
  expectSetError("lights.3.name=x", "\"lights.0\"");
  expectSetError("lights.one.name=x", "\"lights.0\"");
  expectSetError("view.samples.x=1", "no parts");
  expectSetError("view.samples", "no value");
  expectSetError("=3", "no value");
}

TEST(SceneSet, BadValuesAreTheCallersFault) {
  expectSetError("photons.grid=[512,-1]", "range");
  expectSetError("photons.grid=[512,512", "array");
  expectSetError("photons={\"gird\":[1,1]}", "\"grid\"");
  expectSetError("objects.0.material=water", "\"glass\"");
  // The file's own faults stay the file's.
  expectError(R"({"volcaustic": 1, "view": {"samples": 0}})", {{"photons.jitter=true"}, 1}, ErrorKind::Input,
              "s.json:/view/samples");
}

TEST(SceneAnimation, InterpolatesLinearlyAndHoldsTheEnds) {
  EXPECT_EQ(parse({}, 1).lights[0].direction, (Vec3d{1, 0, 0}));
  EXPECT_EQ(parse({}, 2).lights[0].direction, (Vec3d{0.5, 0.5, 0}));
  EXPECT_EQ(parse({}, 3).lights[0].direction, (Vec3d{0, 1, 0}));
  EXPECT_EQ(parse({}, 4.5).lights[0].direction, (Vec3d{0, 1, -3}));
  EXPECT_EQ(parse({}, -7).lights[0].direction, (Vec3d{1, 0, 0}));
  EXPECT_EQ(parse({}, 99).lights[0].direction, (Vec3d{0, 1, -4}));
  EXPECT_EQ(parse({}, 15).camera.fieldOfView, 30) << "a track makes the section it needs";
  EXPECT_EQ(parse({}, 15).camera.resolution, Camera{}.resolution);
}

TEST(SceneAnimation, ValuesSetFromOutsideWin) {
  EXPECT_EQ(parse({"lights.0.direction=[0,0,-1]"}, 3).lights[0].direction, (Vec3d{0, 0, -1}));
  EXPECT_EQ(parse({"animation./camera/fieldOfView=[[1,50],[2,60]]"}, 1.5).camera.fieldOfView, 55);
}

TEST(SceneAnimation, CanonicalFormIsOfOneFrame) {
  EXPECT_EQ(sceneToJson(parseScene(sceneToJson(parse({}, 2)), "s.json", {{}, 5})), sceneToJson(parse({}, 2)));
}

TEST(SceneAnimation, BadTracksAreErrorsAtTheirPointer) {
  expectTrackError(R"("/camera/fieldOfVeiw": [[1, 20]])", "~1camera~1fieldOfVeiw: ", "fieldOfView");
  expectTrackError(R"("camera": [[1, 20]])", "camera: ", "JSON pointer");
  expectTrackError(R"("/camera/fieldOfView": [])", "~1camera~1fieldOfView: ");
  expectTrackError(R"("/camera/fieldOfView": [[1, 20], [1, 30]])", "~1camera~1fieldOfView/1/0: ", "order");
  expectTrackError(R"("/camera/position": [[1, [1, 2, 3]], [2, [1, 2]]])", "~1camera~1position/1/1: ", "shape");
  expectTrackError(R"("/camera/position": [[1, ["x", 2, 3]]])", "~1camera~1position/0/1: ");
  expectTrackError(R"("/camera/resolution": [[1, [8, 8]]])", "~1camera~1resolution: ", "whole");
  expectTrackError(R"("/photons/jitter": [[1, 0]])", "~1photons~1jitter: ");
  // A value out of range is reported where it lands.
  expectError(R"({"volcaustic": 1, "animation": {"/camera/fieldOfView": [[1, 500]]}})", {}, ErrorKind::Input,
              "s.json:/camera/fieldOfView: ");
}

} // namespace
} // namespace volcaustic
