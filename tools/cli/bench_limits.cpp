#include "bench_limits.h"

#include <algorithm>
#include <array>
#include <barrier>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <thread>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace volcaustic::cli {

namespace {

/// Multiply-adds and gathers of one instruction set. Each returns something of its work, so that it is not left out.
struct InstructionSet {
  const char* name;
  int lanes;
  /// `rounds` times kChains independent multiply-adds of `lanes` floats.
  float (*multiplyAdd)(std::int64_t rounds);
  /// `rounds` gathers of 16 floats at random places of a table of mask + 1 floats.
  float (*gather)(const float* table, std::uint32_t mask, std::int64_t rounds);
};

constexpr int kChains = 12; // hides the latency of four or five cycles at two multiply-adds a cycle

// Numerical Recipes' generator in every lane: the high bits are the random place.
constexpr std::uint32_t kRandomFactor = 1664525, kRandomStep = 1013904223;

float baselineMultiplyAdd(std::int64_t rounds) {
  std::array<float, 4 * kChains> sums{};
  for (std::int64_t i = 0; i < rounds; ++i)
    for (float& sum : sums) sum = sum * 0.999f + 0.001f;
  float total = 0;
  for (const float sum : sums) total += sum;
  return total;
}

float baselineGather(const float* table, std::uint32_t mask, std::int64_t rounds) {
  std::array<std::uint32_t, 16> places{};
  for (std::uint32_t lane = 0; lane < 16; ++lane) places[lane] = 12345 * lane;
  float total = 0;
  for (std::int64_t i = 0; i < rounds; ++i)
    for (std::uint32_t& place : places) {
      place = place * kRandomFactor + kRandomStep;
      total += table[(place >> 8) & mask];
    }
  return total;
}

constexpr InstructionSet kBaseline{"baseline", 4, baselineMultiplyAdd, baselineGather};

#if defined(__x86_64__)

__attribute__((target("avx2,fma"))) float avx2MultiplyAdd(std::int64_t rounds) {
  const __m256 factor = _mm256_set1_ps(0.999f), step = _mm256_set1_ps(0.001f);
  __m256 sums[kChains];
  for (__m256& sum : sums) sum = _mm256_setzero_ps();
  for (std::int64_t i = 0; i < rounds; ++i)
#pragma GCC unroll 12
    for (__m256& sum : sums) sum = _mm256_fmadd_ps(sum, factor, step);
  for (int i = 1; i < kChains; ++i) sums[0] = _mm256_add_ps(sums[0], sums[i]);
  return _mm256_cvtss_f32(sums[0]);
}

__attribute__((target("avx2,fma"))) float avx2Gather(const float* table, std::uint32_t mask, std::int64_t rounds) {
  const __m256i factor = _mm256_set1_epi32(kRandomFactor), step = _mm256_set1_epi32(kRandomStep);
  const __m256i inside = _mm256_set1_epi32(static_cast<int>(mask));
  __m256i low = _mm256_setr_epi32(1, 12346, 24691, 37036, 49381, 61726, 74071, 86416);
  __m256i high = _mm256_add_epi32(low, _mm256_set1_epi32(98760));
  __m256 total = _mm256_setzero_ps();
  for (std::int64_t i = 0; i < rounds; ++i)
    for (__m256i* places : {&low, &high}) {
      *places = _mm256_add_epi32(_mm256_mullo_epi32(*places, factor), step);
      const __m256i at = _mm256_and_si256(_mm256_srli_epi32(*places, 8), inside);
      total = _mm256_add_ps(total, _mm256_i32gather_ps(table, at, 4));
    }
  return _mm256_cvtss_f32(total);
}

__attribute__((target("avx512f"))) float avx512MultiplyAdd(std::int64_t rounds) {
  const __m512 factor = _mm512_set1_ps(0.999f), step = _mm512_set1_ps(0.001f);
  __m512 sums[kChains];
  for (__m512& sum : sums) sum = _mm512_setzero_ps();
  for (std::int64_t i = 0; i < rounds; ++i)
#pragma GCC unroll 12
    for (__m512& sum : sums) sum = _mm512_fmadd_ps(sum, factor, step);
  for (int i = 1; i < kChains; ++i) sums[0] = _mm512_add_ps(sums[0], sums[i]);
  return _mm512_cvtss_f32(sums[0]);
}

__attribute__((target("avx512f"))) float avx512Gather(const float* table, std::uint32_t mask, std::int64_t rounds) {
  const __m512i factor = _mm512_set1_epi32(kRandomFactor), step = _mm512_set1_epi32(kRandomStep);
  const __m512i inside = _mm512_set1_epi32(static_cast<int>(mask));
  __m512i places = _mm512_mullo_epi32(_mm512_setr_epi32(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16),
                                      _mm512_set1_epi32(12345));
  // The masked forms with every lane on: g++ 12 warns of its own unmasked ones (GCC bug 105593).
  constexpr __mmask16 kAll = 0xffff;
  const __m512 none = _mm512_setzero_ps();
  __m512 total = _mm512_setzero_ps();
  for (std::int64_t i = 0; i < rounds; ++i) {
    places = _mm512_add_epi32(_mm512_mullo_epi32(places, factor), step);
    const __m512i at = _mm512_and_si512(_mm512_maskz_srli_epi32(kAll, places, 8), inside);
    total = _mm512_add_ps(total, _mm512_mask_i32gather_ps(none, kAll, at, table, 4));
  }
  return _mm512_cvtss_f32(total);
}

const InstructionSet& widestInstructionSet() {
  static constexpr InstructionSet kAvx2{"avx2", 8, avx2MultiplyAdd, avx2Gather};
  static constexpr InstructionSet kAvx512{"avx512", 16, avx512MultiplyAdd, avx512Gather};
  if (__builtin_cpu_supports("avx512f")) return kAvx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return kAvx2;
  return kBaseline;
}

#else
const InstructionSet& widestInstructionSet() { return kBaseline; }
#endif

/// Seconds that the slowest of `threads` threads takes for body() when all start together: the best of a few times.
/// `prepare` makes each thread's body, and with it the memory that it touches.
double bestSeconds(int threads, const std::function<std::function<void()>()>& prepare) {
  using Clock = std::chrono::steady_clock;
  constexpr int kRepeats = 4;
  std::vector<std::array<double, kRepeats>> seconds(static_cast<std::size_t>(threads));
  std::barrier start(threads);
  std::vector<std::jthread> team;
  for (int t = 0; t < threads; ++t)
    team.emplace_back([&, t] {
      const std::function<void()> body = prepare();
      body();
      for (int i = 0; i < kRepeats; ++i) {
        start.arrive_and_wait();
        const auto begin = Clock::now();
        body();
        seconds[t][i] = std::chrono::duration<double>(Clock::now() - begin).count();
      }
    });
  team.clear();
  double best = 1e300;
  for (int i = 0; i < kRepeats; ++i) {
    double slowest = 0;
    for (const auto& thread : seconds) slowest = std::max(slowest, thread[i]);
    best = std::min(best, slowest);
  }
  return best;
}

volatile float gKept; // keeps results alive

/// 10^9 bytes a second of one thread: copies buffers of `bytes` until about `total` bytes are copied.
double copyRate(int threads, std::size_t bytes, double total) {
  const auto rounds = static_cast<std::int64_t>(std::max(1.0, total / static_cast<double>(bytes)));
  const double seconds = bestSeconds(threads, [&]() -> std::function<void()> {
    return [from = std::vector<char>(bytes, 1), to = std::vector<char>(bytes), rounds]() mutable {
      for (std::int64_t i = 0; i < rounds; ++i) {
        std::memcpy(to.data(), from.data(), from.size());
        from[static_cast<std::size_t>(i) % from.size()] = to[0];
      }
      gKept = to.back();
    };
  });
  return static_cast<double>(bytes) * static_cast<double>(rounds) / seconds / 1e9;
}

/// GFLOP/s of one thread, a multiply-add counting two.
double multiplyAddRate(int threads, const InstructionSet& set) {
  constexpr std::int64_t kRounds = 10'000'000;
  const double seconds = bestSeconds(threads, [&] { return [&set] { gKept = set.multiplyAdd(kRounds); }; });
  return 2.0 * kChains * set.lanes * kRounds / seconds / 1e9;
}

/// Nanoseconds of one thread for 16 loads from random places of a table.
double gatherTime(int threads, const InstructionSet& set, std::size_t bytes) {
  const std::int64_t rounds = bytes > (1u << 22) ? 1'000'000 : 5'000'000;
  const double seconds = bestSeconds(threads, [&]() -> std::function<void()> {
    return [table = std::vector<float>(bytes / sizeof(float), 1.0f), &set, rounds] {
      gKept = set.gather(table.data(), static_cast<std::uint32_t>(table.size() - 1), rounds);
    };
  });
  return seconds / static_cast<double>(rounds) * 1e9;
}

} // namespace

MachineLimits measureLimits(int threads) {
  const InstructionSet& set = widestInstructionSet();
  MachineLimits result{set.name, {}};
  const auto add = [&](const char* key, const char* text, const char* unit, bool isRate, const auto& measure) {
    result.limits.push_back({key, text, unit, measure(1), measure(threads) * (isRate ? threads : 1)});
  };
  constexpr std::size_t kKiB = 1 << 10, kMiB = 1 << 20;
  // As much in all for any number of threads: beyond the caches, and no burden on a machine with many cores.
  add("copyMemoryGBs", "copy, 128 MiB in all", "GB/s", true,
      [](int t) { return copyRate(t, 128 * kMiB / static_cast<std::size_t>(t), 256e6); });
  add("copyCacheGBs", "copy, 256 KiB a thread", "GB/s", true, [](int t) { return copyRate(t, 256 * kKiB, 4e9); });
  add("multiplyAddGflops", "multiply-add, 32 bits", "GFLOP/s", true, [&](int t) { return multiplyAddRate(t, set); });
  add("gather32KiBNs", "16 random loads from 32 KiB", "ns", false,
      [&](int t) { return gatherTime(t, set, 32 * kKiB); });
  add("gather1MiBNs", "16 random loads from 1 MiB", "ns", false, [&](int t) { return gatherTime(t, set, kMiB); });
  add("gather16MiBNs", "16 random loads from 16 MiB", "ns", false,
      [&](int t) { return gatherTime(t, set, 16 * kMiB); });
  return result;
}

} // namespace volcaustic::cli
