// What a session reads may change behind its back: files, meshes in memory, light from elsewhere. No result is stale.

#include "support/moving_scene.h"
#include "volcaustic/error.h"
#include "volcaustic/slice.h"
#include "volcaustic/vdb.h"

#include <filesystem>
#include <fstream>
#include <functional>

namespace volcaustic::test {

namespace {

using Words = std::vector<std::string>;

class SessionInputs : public testing::Test {
protected:
  void SetUp() override {
    mFolder = std::filesystem::path(testing::TempDir()) /
              (std::string("inputs_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(mFolder);
    std::filesystem::create_directories(mFolder);
  }
  void TearDown() override { std::filesystem::remove_all(mFolder); }
  [[nodiscard]] std::filesystem::path file(const char* name) const { return mFolder / name; }

  /// Replaces a file and leaves its time as it was.
  static void replaceKeepingTime(const std::filesystem::path& path, const std::function<void()>& write) {
    const auto time = std::filesystem::last_write_time(path);
    write();
    std::filesystem::last_write_time(path, time);
  }
  std::filesystem::path mFolder;
};

/// One triangle at z = height, in a .gltf file beside its buffer.
void writeGltf(const std::filesystem::path& folder, float height) {
  const float corners[] = {0, 0, height, 1, 0, height, 0, 1, height};
  std::ofstream(folder / "side.bin", std::ios::binary).write(reinterpret_cast<const char*>(corners), sizeof corners);
  std::ofstream(folder / "side.gltf")
      << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"side.bin"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":36}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,9]}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})";
}

Scene withoutObjects() {
  Scene s = movingScene();
  s.objects.clear();
  return s;
}

} // namespace

TEST_F(SessionInputs, LightOfAnotherDomainIsRefused) {
  Scene scene = movingScene();
  Session finer(scene);
  scene.volume.resolution += 8;
  Session session(scene);
  session.setRadiance(finer.photons().radiance);
  try {
    session.view();
    FAIL() << "rendered light of another domain";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
  }
  session.setRadiance({}); // no light at all
  EXPECT_THROW(session.view(), Error);
}

TEST_F(SessionInputs, AMeshInMemoryMayChangeBehindItsPointer) {
  Scene scene = movingScene();
  const auto mesh = std::make_shared<Mesh>(*scene.objects[0].mesh);
  scene.objects[0].mesh = mesh;
  Session session(scene);
  session.view();
  for (Vec3d& p : mesh->positions) p[1] *= 1.2;
  expectSamePicture(session.view(), Session(scene).view());
  *mesh = ellipsoid({-.4, 0, 0}, {.3, .2, .3}, 17); // with more vertices than were factorised
  const std::size_t before = session.runs().size();
  expectSamePicture(session.view(), Session(scene).view());
  EXPECT_EQ(stagesSince(session, before), (Words{"surface", "medium", "stepField", "photons", "view"}));
}

TEST_F(SessionInputs, AMeshFileThatWasWrittenAnewIsRead) {
  const auto write = [&](double radius) { writeMesh(file("ball.ply"), ellipsoid({0, 0, 0}, {radius, .3, .3}, 12)); };
  write(.3);
  Scene scene = withoutObjects();
  scene.objects.emplace_back().meshFile = file("ball.ply");
  Session session(scene);
  session.medium();
  session.medium();
  EXPECT_EQ(session.runs().size(), 1u);
  write(.35);
  std::filesystem::last_write_time(file("ball.ply"), std::filesystem::file_time_type::clock::now());
  expectSamePicture(session.view(), Session(scene).view());
  EXPECT_EQ(session.runs()[1].because, Words{"objects/0/mesh"});
}

TEST_F(SessionInputs, TheBufferBesideAGltfFileIsPartOfIt) {
  writeGltf(mFolder, .5f);
  Scene scene = withoutObjects();
  scene.objects.emplace_back().meshFile = file("side.gltf").string() + "#/meshes/0";
  Session session(scene);
  EXPECT_FLOAT_EQ(static_cast<float>(session.surface(0)->positions[0][2]), .5f);
  replaceKeepingTime(file("side.gltf"), [&] { writeGltf(mFolder, 1); });
  std::filesystem::last_write_time(file("side.bin"),
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(2));
  EXPECT_FLOAT_EQ(static_cast<float>(session.surface(0)->positions[0][2]), 1.f);
}

TEST_F(SessionInputs, KeysOnTheDiskAreThoseOfContents) {
  const auto write = [&](double attenuation) {
    Scene s = withoutObjects();
    s.volume.ambient.attenuation = {attenuation, .1, .1};
    writeVdb(file("medium.vdb"), Session(s).medium());
  };
  write(.1);
  Scene scene = withoutObjects();
  scene.volume = {};
  scene.volume.file = file("medium.vdb");
  const SessionOptions options{.cache = file("cache")};
  const ViewResult first = Session(scene, {}, options).view();
  Session again(scene, {}, options);
  expectSamePicture(again.view(), first);
  EXPECT_TRUE(again.runs().back().fromDisk);
  replaceKeepingTime(file("medium.vdb"), [&] { write(.5); });
  Session changed(scene, {}, options);
  const ViewResult& second = changed.view();
  expectSamePicture(second, Session(scene).view());
  EXPECT_FALSE(sameBits(second.image.planes[0], first.image.planes[0]));
}

TEST_F(SessionInputs, LightFromElsewhereIsNotTakenForOtherLight) {
  const SessionOptions options{.cache = file("cache")};
  Scene dim = movingScene();
  for (Light& light : dim.lights) light.intensity = {.1, .1, .1};
  const RadianceVolume bright = Session(movingScene()).photons().radiance, dark = Session(dim).photons().radiance;
  const auto viewOf = [&](const RadianceVolume& light) {
    Session session(movingScene(), {}, options);
    session.setRadiance(light);
    return session.view();
  };
  const ViewResult a = viewOf(bright), b = viewOf(dark), again = viewOf(bright);
  EXPECT_FALSE(sameBits(a.image.planes[0], b.image.planes[0]));
  expectSamePicture(a, again);
}

TEST_F(SessionInputs, AnotherDeviceOrSeedMakesLightAndPictureAnew) {
  Session session(movingScene());
  session.view();
  RunContext ctx;
  ctx.device = "cpu:scalar";
  session.setContext(ctx);
  session.view();
  EXPECT_EQ(stagesSince(session, 6), (Words{"photons", "view"}));
  ctx.seed = 7;
  session.setContext(ctx);
  session.view();
  EXPECT_EQ(stagesSince(session, 8), (Words{"photons", "view"}));
}

TEST_F(SessionInputs, AnImageOfOtherSidesIsAnotherBackground) {
  const auto image = std::make_shared<Image>();
  image->width = 8;
  image->height = 4;
  image->channels = {"R", "G", "B"};
  image->planes.assign(3, std::vector<float>(32));
  for (std::size_t i = 0; i < 32; ++i) image->planes[0][i] = static_cast<float>(i);
  Scene scene = movingScene();
  scene.background.image = image;
  Session session(scene);
  session.view();
  auto turned = std::make_shared<Image>(*image);
  std::swap(turned->width, turned->height);
  scene.background.image = turned;
  session.setScene(scene);
  const std::size_t before = session.runs().size();
  expectSamePicture(session.view(), Session(scene).view());
  EXPECT_EQ(stagesSince(session, before), Words{"view"});
}

TEST_F(SessionInputs, WhatIsThereSparesTheStagesBeforeItAlsoInThePlan) {
  const SessionOptions options{.cache = file("cache")};
  Session(movingScene(), {}, options).view();
  Session session(movingScene(), {}, options);
  for (const StagePlan& stage : session.plan()) EXPECT_FALSE(stage.runs) << stage.stage;
  // In memory, too: the medium in between is not needed to go back to the picture.
  Session plain(movingScene());
  plain.view();
  Scene other = movingScene();
  other.materials[0].index = 1.3;
  plain.setScene(other);
  plain.medium();
  plain.setScene(movingScene());
  for (const StagePlan& stage : plain.plan()) EXPECT_FALSE(stage.runs) << stage.stage;
  const std::size_t before = plain.runs().size();
  plain.view();
  EXPECT_EQ(plain.runs().size(), before);
}

TEST_F(SessionInputs, SlicesAreOfOneLattice) {
  Session coarse(movingScene());
  Scene scene = movingScene();
  scene.volume.resolution = 40;
  Session fine(scene);
  EXPECT_THROW(sliceVolume(*coarse.sharedFlat(), fine.photons(), {}), Error);
  const VolumeSlice slice =
      sliceVolume(*fine.sharedFlat(), fine.photons(), {.layer = VolumeLayer::Radiance, .axis = 2, .position = .5});
  ASSERT_EQ(slice.columns, 40);
  ASSERT_EQ(slice.values.size(), 1600u);
  // The first row is the farthest along y: voxel (0, 39) of the plane, of what arrives in all directions over 4 pi.
  const Vec3f fluence = fine.photons().radiance.fluence({0, 39, 20});
  EXPECT_NEAR(slice.values[0][1], fluence[1] / (4 * 3.14159265), 1e-5 * fluence[1]);
  EXPECT_GT(slice.greatest, slice.least);
}

} // namespace volcaustic::test
