// Any sequence of edits leaves a session with what a fresh one would make, bit by bit.

#include "support/moving_scene.h"
#include "volcaustic/error.h"
#include "volcaustic/live.h"

#include <chrono>
#include <random>
#include <thread>

namespace volcaustic::test {

namespace {

using Random = std::mt19937;

double between(Random& random, double low, double high) {
  return low + (high - low) * std::uniform_real_distribution<>()(random);
}
std::size_t below(Random& random, std::size_t n) { return random() % n; }

Scene tinyScene() {
  Scene s = movingScene();
  s.volume.resolution = 16;
  s.photons.grid = {16, 16};
  s.camera.resolution = {16, 12};
  s.receivers[0].resolution = 16;
  return s;
}

void editObject(Scene& s, Random& random) {
  SceneObject& o = s.objects[below(random, s.objects.size())];
  switch (below(random, 6)) {
  case 0:
    o.placement.translate[below(random, 3)] = between(random, -.2, .2);
    break;
  case 1:
    o.placement.rotate[below(random, 3)] = between(random, -180, 180);
    break;
  case 2:
    o.visible = &o == &s.objects[0] || !o.visible;
    break;
  case 3:
    o.triangulate = !o.triangulate;
    break;
  case 4: {
    Deformer d;
    d.type = static_cast<DeformerType>(below(random, 6));
    d.center = {between(random, -.7, .5), between(random, -.3, .3), between(random, -.3, .3)};
    d.radius = 1;
    d.direction = {0, 0, 1};
    d.strength = d.type == DeformerType::Twist ? 30 : .05;
    d.placement.translate[below(random, 3)] = between(random, -.1, .1);
    o.deform.assign(1 + below(random, 2), d);
    break;
  }
  default:
    o.deform.clear();
  }
}

void edit(Scene& s, Random& random) {
  switch (below(random, 8)) {
  case 0:
    s.camera.position = {between(random, -2, 2), -4, between(random, 0, 2)};
    break;
  case 1:
    s.lights[0].direction = {between(random, -1, 1), between(random, -1, 1), -1};
    break;
  case 2:
    s.lights[1].intensity = {between(random, 0, 2), 1, 1};
    break;
  case 3:
    s.materials[0].index = between(random, 1.1, 1.8);
    break;
  case 4:
    s.materials[0].attenuation[below(random, 3)] = between(random, 0, 1);
    break;
  case 5:
    s.receivers[0].placement.translate[2] = between(random, -1, -.5);
    break;
  default:
    editObject(s, random);
  }
}

} // namespace

TEST(SessionEdits, AnySequenceOfEditsGivesTheBitsOfAFreshSession) {
  Random random(20260);
  SceneHistory history(tinyScene());
  Session few(tinyScene()), many(tinyScene(), {}, {.results = 6});
  for (int i = 1; i <= 1000; ++i) {
    const std::size_t what = below(random, 10);
    if (what < 2) {
      history.undo();
    } else if (what == 2) {
      history.redo();
    } else {
      Scene next = history.current();
      edit(next, random);
      history.push(std::move(next));
    }
    few.setScene(history.current());
    many.setScene(history.current());
    const ViewResult& view = few.view();
    expectSamePicture(many.view(), view);
    if (i % 25 == 0) {
      Session fresh(history.current());
      expectSameLight(few.photons(), fresh.photons());
      expectSamePicture(view, fresh.view());
    }
    if (testing::Test::HasFailure()) FAIL() << "after " << i << " edits";
  }
}

// Seeds and lattices do not change from frame to frame, so neither does anything that stands still.
TEST(SessionEdits, AStaticSceneHasNoNoiseFromFrameToFrame) {
  Scene scene = movingScene();
  scene.photons.jitter = true;
  Session session(scene);
  const ViewResult first = session.view();
  Scene moved = scene;
  moved.lights[0].direction = {0, 0, -1};
  session.setScene(moved);
  session.view();
  session.setScene(scene);
  expectSamePicture(session.view(), first);
  expectSamePicture(Session(scene).view(), first);
}

// A slow movement changes a picture in proportion: the difference of two frames goes down with the step, instead of
// staying at the level of the photons' noise.
TEST(SessionEdits, ASlowMovementDoesNotFlicker) {
  const auto pictureAt = [](double x) {
    Scene s = movingScene();
    s.volume.resolution = 48;
    s.photons.grid = {256, 256};
    s.photons.jitter = true;
    s.objects.resize(1);
    s.objects[0].deform.clear();
    s.objects[0].placement.translate[0] = x;
    return Session(s).view().image;
  };
  const Image at0 = pictureAt(.2);
  const auto change = [&](double x) {
    const Image other = pictureAt(.2 + x);
    double sum = 0, light = 0;
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < at0.planes[c].size(); ++i) {
        sum += std::abs(other.planes[c][i] - at0.planes[c][i]);
        light += at0.planes[c][i];
      }
    return sum / light;
  };
  const double voxel = 2.0 / 48;
  const double whole = change(voxel), tenth = change(voxel / 10), hundredth = change(voxel / 100);
  EXPECT_LT(tenth, .3 * whole);
  EXPECT_LT(hundredth, .3 * tenth);
  EXPECT_LT(tenth, .01);
}

TEST(LiveSession, RefinesToThePictureOfASession) {
  const Scene scene = movingScene();
  LiveSession live(scene, {.frameMs = 5});
  const auto rough = live.wait(1, 8);
  EXPECT_GT(rough->reduction, 1);
  const auto frame = live.wait(1);
  EXPECT_EQ(frame->reduction, 1);
  EXPECT_TRUE(frame->error.empty());
  EXPECT_FALSE(live.busy());
  expectSamePicture(*frame->view, Session(scene).view());
  expectSameLight(*frame->photons, Session(scene).photons());
  EXPECT_EQ(frame->scene.photons.grid, scene.photons.grid);
}

TEST(LiveSession, TheLatestSceneWins) {
  Scene scene = movingScene();
  LiveSession live(scene);
  std::uint64_t revision = 1;
  for (int i = 0; i < 40; ++i) {
    scene.objects[1].placement.translate[0] = .01 * i;
    const std::uint64_t next = live.setScene(scene);
    EXPECT_EQ(next, revision + 1);
    revision = next;
    if (i % 8 == 0) (void)live.wait(revision, 8);
  }
  const auto frame = live.wait(revision);
  EXPECT_EQ(frame->revision, revision);
  expectSamePicture(*frame->view, Session(scene).view());
}

TEST(LiveSession, AnErrorKeepsTheLastPictureAndGoesAway) {
  Scene scene = movingScene();
  LiveSession live(scene);
  const auto good = live.wait(1);
  scene.materials.clear();
  const auto bad = live.wait(live.setScene(scene));
  EXPECT_NE(bad->error.find("no material is called"), std::string::npos) << bad->error;
  EXPECT_EQ(bad->view, good->view);
  EXPECT_FALSE(live.busy());
  EXPECT_TRUE(live.wait(live.setScene(movingScene()))->error.empty());
  EXPECT_NE(live.wait(live.setDevice("gpu"))->error, "");
  EXPECT_TRUE(live.wait(live.setDevice("cpu"))->error.empty());
}

TEST(LiveSession, EndsInTheMidstOfWork) {
  Scene scene = movingScene();
  scene.volume.resolution = 128;
  scene.photons.grid = {2048, 2048};
  for (const int wait : {0, 3, 30}) {
    LiveSession live(scene);
    std::this_thread::sleep_for(std::chrono::milliseconds(wait));
  }
  EXPECT_THROW(LiveSession(scene, {.frameMs = 0}), Error);
  EXPECT_THROW(LiveSession(scene, {.greatestReduction = 3}), Error);
}

} // namespace volcaustic::test
