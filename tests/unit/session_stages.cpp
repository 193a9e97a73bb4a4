// Which stages a change runs again, and what a session says about it.

#include "support/moving_scene.h"
#include "volcaustic/error.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>

namespace volcaustic::test {

namespace {

using Words = std::vector<std::string>;

struct Change {
  const char* name;
  std::function<void(Scene&)> apply;
  Words stages;
  Words because; ///< of the first stage that ran
};

const Words kAllOfMedium{"medium", "stepField", "photons", "view"};

const std::vector<Change>& changes() {
  static const std::vector<Change> kChanges{
      {"nothing", [](Scene&) {}, {}, {}},
      {"camera",
       [](Scene& s) {
         s.camera.position = {1, -3, 1};
       },
       {"view"},
       {"camera/position"}},
      {"exposure", [](Scene& s) { s.view.exposure = 1; }, {"view"}, {"view/exposure"}},
      {"background",
       [](Scene& s) {
         s.background.top = {.1, .2, .3};
       },
       {"view"},
       {"background/top"}},
      {"light",
       [](Scene& s) {
         s.lights[0].direction = {0, 0, -1};
       },
       {"photons", "view"},
       {"lights/0/direction"}},
      {"new light", [](Scene& s) { s.lights.pop_back(); }, {"photons", "view"}, {}},
      {"photons",
       [](Scene& s) {
         s.photons.grid = {40, 48};
       },
       {"photons", "view"},
       {"photons/grid"}},
      {"receiver",
       [](Scene& s) { s.receivers[0].placement.translate[2] = -.8; },
       {"photons", "view"},
       {"receivers/0/translate"}},
      {"step field", [](Scene& s) { s.stepField.cap = 3; }, {"stepField", "photons", "view"}, {"stepField/cap"}},
      {"material",
       [](Scene& s) { s.materials[0].index = 1.4; },
       kAllOfMedium,
       {"objects/0/material/index", "objects/1/material/index", "objects/2/material/index"}},
      {"object",
       [](Scene& s) {
         s.objects[1].placement.translate = {0, .1, 0};
       },
       kAllOfMedium,
       {"objects/1/translate"}},
      {"deformed object",
       [](Scene& s) {
         s.objects[0].placement.translate = {0, .1, 0};
       },
       kAllOfMedium,
       {"objects/0/translate"}},
      {"deformation",
       [](Scene& s) { s.objects[0].deform[0].strength = -.2; },
       {"surface", "medium", "stepField", "photons", "view"},
       {"deform/0/strength"}},
      {"triangles",
       [](Scene& s) { s.objects[2].polygonise.resolution = 14; },
       {"surface", "medium", "stepField", "photons", "view"},
       {"resolution"}},
      {"place of triangles",
       [](Scene& s) {
         s.objects[2].placement.translate = {0, .1, 0};
       },
       {"surface", "medium", "stepField", "photons", "view"},
       {"translate"}},
      {"hidden", [](Scene& s) { s.objects[2].visible = false; }, kAllOfMedium, {}},
      {"ambient",
       [](Scene& s) {
         s.volume.ambient.attenuation = {.2, .2, .2};
       },
       kAllOfMedium,
       {"volume/attenuation"}},
  };
  return kChanges;
}

class SessionFolder : public testing::Test {
protected:
  void SetUp() override {
    mFolder = std::filesystem::path(testing::TempDir()) /
              (std::string("session_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(mFolder);
  }
  void TearDown() override { std::filesystem::remove_all(mFolder); }
  std::filesystem::path mFolder;
};

} // namespace

TEST(SessionStages, AChangeRunsWhatItTouchesAndNothingElse) {
  Session session(movingScene());
  session.view();
  EXPECT_EQ(stagesSince(session, 0), (Words{"surface", "surface", "medium", "stepField", "photons", "view"}));
  for (const StageRun& run : session.runs()) EXPECT_TRUE(run.because.empty()) << run.stage;
  for (const Change& change : changes()) {
    SCOPED_TRACE(change.name);
    session.setScene(movingScene());
    session.view();
    Scene changed = movingScene();
    change.apply(changed);
    session.setScene(changed);

    const std::vector<StagePlan> plan = session.plan();
    const std::size_t before = session.runs().size();
    session.view();
    const Words ran = stagesSince(session, before);
    EXPECT_EQ(ran, change.stages);
    Words planned;
    for (const StagePlan& stage : plan)
      if (stage.runs) planned.push_back(stage.stage);
    EXPECT_EQ(planned, ran);
    if (!change.because.empty()) {
      EXPECT_EQ(session.runs()[before].because, change.because);
    }
    for (std::size_t i = before + 1; i < session.runs().size(); ++i)
      EXPECT_FALSE(session.runs()[i].because.empty()) << session.runs()[i].stage;
  }
}

TEST(SessionStages, AskingForAnEarlyStageRunsNoLaterOne) {
  Session session(movingScene());
  session.medium();
  EXPECT_EQ(stagesSince(session, 0), (Words{"surface", "surface", "medium"}));
  session.photons();
  session.photons();
  EXPECT_EQ(stagesSince(session, 3), (Words{"stepField", "photons"}));
}

TEST(SessionStages, GoingBackIsFreeWhereResultsAreKept) {
  const auto runsOf = [](int results) {
    Session session(movingScene(), {}, {.results = results});
    SceneHistory history(movingScene());
    session.view();
    for (const auto& change : {changes()[1], changes()[4], changes()[10]}) {
      Scene next = history.current();
      change.apply(next);
      history.push(next);
      session.setScene(history.current());
      session.view();
    }
    const std::size_t before = session.runs().size();
    while (history.canUndo()) {
      session.setScene(history.undo());
      session.view();
    }
    while (history.canRedo()) {
      session.setScene(history.redo());
      session.view();
    }
    return session.runs().size() - before;
  };
  EXPECT_EQ(runsOf(4), 0u);
  EXPECT_GT(runsOf(1), 0u);
}

TEST(SessionStages, HistoryForgetsWhatWasUndoneAndWhatIsTooOld) {
  const auto at = [](int frame) {
    Scene s;
    s.frames.last = frame;
    return s;
  };
  SceneHistory history(at(1), 2);
  for (int i = 2; i <= 4; ++i) history.push(at(i));
  EXPECT_EQ(history.undo().frames.last, 3);
  EXPECT_EQ(history.undo().frames.last, 2);
  EXPECT_FALSE(history.canUndo());
  EXPECT_EQ(history.undo().frames.last, 2);
  history.push(at(9));
  EXPECT_FALSE(history.canRedo());
  history.replace(at(10));
  EXPECT_EQ(history.current().frames.last, 10);
  EXPECT_EQ(history.undo().frames.last, 2);
  EXPECT_EQ(history.redo().frames.last, 10);
}

TEST(SessionStages, ACancelledStageLeavesASessionThatGoesOn) {
  Session fresh(movingScene());
  const ViewResult expected = fresh.view();
  std::atomic<bool> cancel{false};
  int left = 0, cancelled = 0;
  RunContext ctx;
  ctx.cancel = &cancel;
  ctx.onProgress = [&](std::string_view, double) { cancel = --left <= 0; };
  Session session(movingScene(), ctx);
  for (int budget = 1; budget < 4000; budget += 1 + budget / 8) { // later and later, until nothing stops it
    left = budget;
    cancel = false;
    try {
      const ViewResult& view = session.view();
      expectSamePicture(view, expected);
      break;
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::Cancelled) << error.what();
      ++cancelled;
    }
  }
  EXPECT_GT(cancelled, 3);
  cancel = false;
  left = 1 << 30;
  expectSamePicture(session.view(), expected);
}

TEST_F(SessionFolder, ResultsOnTheDiskOutliveASession) {
  const SessionOptions options{.cache = mFolder};
  Session first(movingScene(), {}, options);
  const PhotonResult light = first.photons();
  const ViewResult view = first.view();

  Session second(movingScene(), {}, options);
  expectSamePicture(second.view(), view);
  EXPECT_EQ(stagesSince(second, 0), Words{"view"});
  EXPECT_TRUE(second.runs()[0].fromDisk);
  expectSameLight(second.photons(), light);
  EXPECT_EQ(stagesSince(second, 1), Words{"photons"});

  // The light is there for another camera; the view of it is as without the disk.
  Scene moved = movingScene();
  moved.camera.position = {2, -3, 1};
  second.setScene(moved);
  Session plain(moved);
  expectSamePicture(second.view(), plain.view());
  EXPECT_EQ(stagesSince(second, 2), (Words{"surface", "surface", "medium", "stepField", "view"}));
}

TEST_F(SessionFolder, DamagedFilesAreMadeAnew) {
  const SessionOptions options{.cache = mFolder};
  const ViewResult expected = Session(movingScene(), {}, options).view();
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(mFolder)) {
    ++files;
    const auto size = entry.file_size();
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(size / 2));
    file.put('\x5a').put('\x3c');
    file.close();
    if (files == 2) std::filesystem::resize_file(entry.path(), size / 3);
  }
  EXPECT_EQ(files, 2u);
  Session session(movingScene(), {}, options);
  expectSamePicture(session.view(), expected);
  for (const StageRun& run : session.runs()) EXPECT_FALSE(run.fromDisk) << run.stage;
  EXPECT_TRUE(Session(movingScene(), {}, options).plan().back().runs == false);
}

TEST_F(SessionFolder, AFolderThatCannotBeWrittenIsWarnedOf) {
  std::ofstream(mFolder.string()) << "a file in its place";
  Words warnings;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    if (level == LogLevel::Warning) warnings.emplace_back(line);
  };
  Session session(movingScene(), ctx, {.cache = mFolder / "below"});
  EXPECT_GT(session.view().steps, 0);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("cache: "), std::string::npos);
}

} // namespace volcaustic::test
