#include "core/guarded_process.h"
#include "core/parallel.h"
#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/mesh.h"
#include "volcaustic/vdb.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <ostream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace volcaustic::test {
namespace {

int openDescriptors() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

[[noreturn]] void spin() {
  const volatile bool forever = true;
  while (forever) {
  }
  std::abort();
}

std::string errorOf(const std::function<void(std::ostream&)>& parse, GuardLimits limits = {64 << 20, 2}) {
  try {
    (void)runGuarded("file", limits, {}, parse);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Input);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return {};
}

TEST(Guard, PassesBytesAndErrorsOn) {
  const GuardedBytes bytes = runGuarded("file", {64 << 20, 2}, {}, [](std::ostream& out) {
    for (int i = 0; i < 3000000; ++i) out.put(static_cast<char>(i));
  });
  ASSERT_EQ(bytes.bytes().size(), 3000000u);
  for (int i = 0; i < 3000000; i += 9999) ASSERT_EQ(bytes.bytes()[i], static_cast<char>(i));
  EXPECT_EQ(errorOf([](std::ostream&) { throw Error(ErrorKind::Input, "x.vdb: is wrong"); }), "x.vdb: is wrong");
  EXPECT_NE(errorOf([](std::ostream&) { throw std::runtime_error("first\nsecond"); }).find("first second"),
            std::string::npos);
}

TEST(Guard, TurnsEveryDisasterIntoOneError) {
  EXPECT_NE(errorOf([](std::ostream&) { std::raise(SIGSEGV); }).find("crash"), std::string::npos);
  EXPECT_NE(errorOf([](std::ostream&) { std::abort(); }).find("crash"), std::string::npos);
  EXPECT_NE(errorOf([](std::ostream&) { _exit(0); }), "");
#ifndef __SANITIZE_ADDRESS__ // whose allocator ends the process where others throw
  EXPECT_NE(errorOf([](std::ostream& out) { out << std::vector<char>(std::size_t{1} << 40).size(); }).find("memory"),
            std::string::npos);
#endif
  EXPECT_NE(errorOf([](std::ostream& out) { // more output than allowed
              const std::string block(1 << 20, 'x');
              for (int i = 0; i < 200 && out; ++i) out << block;
            })
                .find("memory"),
            std::string::npos);
  EXPECT_NE(errorOf([](std::ostream&) { spin(); }, {64 << 20, 1}).find("more than 1 s"), std::string::npos);
}

TEST(Guard, LeavesNoProcessAndNoDescriptorBehind) {
  const int before = openDescriptors();
  for (int i = 0; i < 20; ++i) (void)errorOf([](std::ostream&) { std::raise(SIGSEGV); });
  EXPECT_EQ(openDescriptors(), before);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a zombie is left";
}

TEST(Guard, StopsWhenTheCallerCancels) {
  std::atomic<bool> cancel{false};
  RunContext ctx;
  ctx.cancel = &cancel;
  std::thread user([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    cancel = true;
  });
  try {
    (void)runGuarded("file", {64 << 20, 100}, ctx, [](std::ostream&) { spin(); });
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Cancelled);
  }
  user.join();
}

TEST(Guard, WorksBesideBusyThreads) {
  const auto file = sharedPath("data/vdb/densityAndHeat.vdb");
  VOLCAUSTIC_NEED_SHARED(file);
  RunContext two;
  two.threads = 2;
  std::atomic<int> read{0};
  parallelFor(16, 1, two,
              [&](std::int64_t, std::int64_t, int) { read += static_cast<int>(inspectVdb(file).grids.size()); });
  EXPECT_EQ(read, 32);
}

TEST(VdbFiles, EveryGoodOneIsListed) {
  const auto folder = sharedPath("data/vdb");
  VOLCAUSTIC_NEED_SHARED(folder);
  std::map<std::string, std::uint64_t> voxels;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    const VdbInfo info = inspectVdb(file.path());
    ASSERT_FALSE(info.grids.empty()) << file.path();
    voxels[file.path().filename()] = info.grids.front().activeVoxels;
    for (const GridInfo& grid : info.grids)
      if (grid.type == "Tree_float_5_4_3") {
        EXPECT_LE(grid.minimum, grid.mean) << file.path();
        EXPECT_LE(grid.mean, grid.maximum) << file.path();
      }
  }
  // Counts that vdb_print gives.
  EXPECT_EQ(voxels.at("smoke_v222_half.vdb"), 1049275u);
  EXPECT_EQ(voxels.at("sphere_v222.vdb"), 270638u);
  EXPECT_EQ(voxels.at("densityAndHeat.vdb"), 6124u);
}

TEST(VdbFiles, EveryBadOneIsAnErrorOrSane) {
  const auto folder = sharedPath("data/vdb_bad");
  VOLCAUSTIC_NEED_SHARED(folder);
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    for (const auto& use : {std::function<void()>([&] { (void)inspectVdb(file.path()); }),
                            std::function<void()>([&] { (void)readMedium(file.path()); }),
                            std::function<void()>([&] { (void)surfaceFromVdb(file.path()); })})
      try {
        use();
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Input) << error.what();
        EXPECT_EQ(std::string(error.what()).rfind(file.path().string() + ": ", 0), 0u) << error.what();
      }
  }
}

TEST(VdbFiles, PointsAreListedButNotConverted) {
  const auto file = sharedPath("data/vdb/pointgrid.vdb");
  VOLCAUSTIC_NEED_SHARED(file);
  const TemporaryFolder folder;
  const std::string name = inspectVdb(file).grids.at(0).name;
  try {
    convertVdb(file, folder / "points.nvdb");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(error.what()).find("'" + name + "'"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "points.nvdb"));
}

/// Deterministic damage: bytes replaced at positions of a simple generator, and truncations.
void damage(const std::filesystem::path& original, const std::string& name, int rounds) {
  VOLCAUSTIC_NEED_SHARED(original);
  const TemporaryFolder folder;
  std::ifstream in(original, std::ios::binary);
  const std::string good((std::istreambuf_iterator<char>(in)), {});
  std::uint64_t state = 12345;
  const auto next = [&] { return (state = state * 6364136223846793005ull + 1442695040888963407ull) >> 33; };
  const auto start = std::chrono::steady_clock::now();
  for (int round = 0; round < rounds; ++round) {
    std::string bad = good;
    if (round % 4 == 3)
      bad.resize(next() % good.size());
    else // near the front, where counts and offsets are, or anywhere
      for (std::uint64_t flips = 1 + next() % 8; flips > 0; --flips)
        bad[next() % (round % 2 ? std::min<std::size_t>(2000, good.size()) : good.size())] = static_cast<char>(next());
    std::ofstream(folder / name, std::ios::binary) << bad;
    try {
      const VdbInfo info = inspectVdb(folder / name);
      for (const GridInfo& grid : info.grids) EXPECT_FALSE(grid.type.empty());
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind() == ErrorKind::Input) << error.what();
    }
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(120));
}

TEST(VdbFiles, DamagedOpenVdbNeverEscapes) { damage(sharedPath("data/vdb/densityAndHeat.vdb"), "damaged.vdb", 120); }
TEST(VdbFiles, DamagedNanoVdbNeverEscapes) { damage(sharedPath("data/vdb/batch_sdf_blosc.nvdb"), "damaged.nvdb", 80); }

} // namespace
} // namespace volcaustic::test
