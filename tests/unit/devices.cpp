// From the word of --device to the machines that take part, for machines that this one need not be.

#include "backends/devices.h"
#include "backends/lanes.h"
#include "volcaustic/error.h"

#include <gtest/gtest.h>

namespace volcaustic::test {

namespace {

CudaDevices oneGpu(bool usable, int memoryGiB = 8) {
  DeviceInfo gpu;
  gpu.id = "cuda:0";
  gpu.name = "Some GPU (compute capability 9.0)";
  gpu.usable = usable;
  gpu.memoryBytes = std::uint64_t(memoryGiB) << 30;
  if (!usable) gpu.reason = "this build is for compute capability 7.5 and newer";
  return {{gpu}, "", true};
}
CudaDevices noGpu() { return {{}, "no NVIDIA driver is installed", false}; }

/// The choice and what was said about it.
struct Chosen {
  DeviceChoice choice;
  std::vector<std::pair<LogLevel, std::string>> log;
};
Chosen choose(const std::string& text, const CudaDevices& cuda) {
  Chosen chosen;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view line) { chosen.log.emplace_back(level, line); };
  chosen.choice = chooseDevice(parseDevice(text), cuda, ctx);
  return chosen;
}

/// Kind and text of the error that `call` throws.
template <class Call>
std::pair<ErrorKind, std::string> errorOf(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return {e.kind(), e.what()};
  }
  ADD_FAILURE() << "no error";
  return {};
}

} // namespace

TEST(Devices, WordsThatNameNoDeviceAreWrongUsage) {
  for (const char* text :
       {"", "gpu", "auto:1", "cpu:", "cpu:sse2", "cuda:", "cuda:-1", "cuda:x", "cuda:1x", "cuda:99999999999",
        "hybrid:", "hybrid:2", "hybrid:-0.1", "hybrid:nan", "hybrid:0.5x", "CPU", "cpu "}) {
    SCOPED_TRACE(text);
    const auto [kind, line] = errorOf([&] { (void)parseDevice(text); });
    EXPECT_EQ(kind, ErrorKind::Usage);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_TRUE(line.starts_with("--device " + std::string(text) + ": "));
  }
}

TEST(Devices, DetailsAreRead) {
  EXPECT_EQ(parseDevice("cpu:avx2").lanes, "avx2");
  EXPECT_EQ(parseDevice("cuda").ordinal, -1);
  EXPECT_EQ(parseDevice("cuda:3").ordinal, 3);
  EXPECT_FALSE(parseDevice("hybrid").cpuShare.has_value());
  EXPECT_EQ(parseDevice("hybrid:0.25").cpuShare, 0.25);
}

TEST(Devices, AutoTakesAUsableGpuAndSaysSo) {
  const Chosen chosen = choose("auto", oneGpu(true));
  EXPECT_EQ(chosen.choice.id(), "cuda:0");
  EXPECT_FALSE(chosen.choice.cpu);
  EXPECT_TRUE(chosen.choice.mayFallBack);
  ASSERT_EQ(chosen.log.size(), 1u);
  EXPECT_EQ(chosen.log[0].first, LogLevel::Info);
  EXPECT_NE(chosen.log[0].second.find("Some GPU"), std::string::npos);
}

TEST(Devices, AutoSaysWhyAGpuIsNotTaken) {
  const Chosen chosen = choose("auto", oneGpu(false));
  EXPECT_EQ(chosen.choice.id(), "cpu");
  ASSERT_EQ(chosen.log.size(), 1u);
  EXPECT_EQ(chosen.log[0].first, LogLevel::Info);
  EXPECT_NE(chosen.log[0].second.find("7.5"), std::string::npos);
}

TEST(Devices, AutoIsQuietWhereNobodyExpectsAGpu) {
  const Chosen chosen = choose("auto", noGpu());
  EXPECT_EQ(chosen.choice.id(), "cpu");
  EXPECT_FALSE(chosen.choice.mayFallBack);
  for (const auto& [level, line] : chosen.log) EXPECT_EQ(level, LogLevel::Detail) << line;
}

TEST(Devices, AskedForByNameItIsThatOrAnError) {
  EXPECT_EQ(choose("cuda", oneGpu(true)).choice.id(), "cuda:0");
  EXPECT_EQ(choose("hybrid", oneGpu(true)).choice.id(), "hybrid (cpu + cuda:0)");
  EXPECT_EQ(choose("hybrid:0.1", oneGpu(true)).choice.cpuShare, 0.1);
  EXPECT_FALSE(choose("cuda", oneGpu(true)).choice.mayFallBack);
  for (const char* text : {"cuda", "cuda:0", "hybrid"})
    for (const CudaDevices& cuda : {oneGpu(false), noGpu()}) {
      const auto [kind, line] = errorOf([&] { (void)choose(text, cuda); });
      EXPECT_EQ(kind, ErrorKind::Device);
      EXPECT_TRUE(line.starts_with("--device " + std::string(text) + ": ")) << line;
      EXPECT_NE(line.find("use cpu"), std::string::npos) << line;
    }
  EXPECT_EQ(errorOf([] { (void)choose("cuda:1", oneGpu(true)); }).first, ErrorKind::Device);
}

TEST(Devices, TheFirstUsableGpuIsTaken) {
  CudaDevices two = oneGpu(false);
  two.devices.push_back(oneGpu(true).devices[0]);
  two.devices[1].id = "cuda:1";
  EXPECT_EQ(choose("auto", two).choice.cudaOrdinal, 1);
  EXPECT_EQ(choose("cuda", two).choice.cudaOrdinal, 1);
  EXPECT_EQ(errorOf([&] { (void)choose("cuda:0", two); }).first, ErrorKind::Device);
}

TEST(Devices, InstructionSetsOfThisProcessorCanBeAskedFor) {
  EXPECT_EQ(laneSets().back().name, "scalar");
  for (const LaneSet& set : laneSets()) {
    const std::string text = "cpu:" + std::string(set.name);
    EXPECT_EQ(choose(text, noGpu()).choice.id(), text);
  }
  EXPECT_EQ(choose("cpu", noGpu()).choice.id(), "cpu");
}

TEST(Devices, TheListBeginsWithTheCpuAndItsInstructionSet) {
  const std::vector<DeviceInfo> devices = listDevices();
  ASSERT_GE(devices.size(), 2u);
  EXPECT_EQ(devices[0].id, "cpu");
  EXPECT_TRUE(devices[0].usable);
  EXPECT_NE(devices[0].name.find("(" + std::string(laneSets().front().name) + ")"), std::string::npos);
  for (const DeviceInfo& d : devices) EXPECT_TRUE(d.usable || !d.reason.empty()) << d.id;
}

} // namespace volcaustic::test
