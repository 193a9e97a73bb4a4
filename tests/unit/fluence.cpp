// Light in sixteen bytes a voxel: how near it is to what was put in, how it is read between voxels, who may write it.

#include "backends/lanes.h"
#include "volcaustic/error.h"
#include "volume/fluence_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace volcaustic::test {
namespace {

using kernels::Double3;
using kernels::Float3;
using kernels::FluenceVoxel;
using kernels::Int3;
using kernels::pack;
using kernels::unpack;
using PackedLight = kernels::Light;
using Random = std::mt19937_64;

/// What is stored is off by so much of the largest channel: half a unit of 20 bits, or a whole one just below a power
/// of two; a direction's unit is twice that.
constexpr double kFluenceError = 0x1p-20, kTowardsError = 0x1p-19;
/// The smallest largest channel that is not flushed to zero.
constexpr float kLeast = 0x1p-107f;

bool isDark(const FluenceVoxel& v) {
  return std::all_of(v.words, v.words + 4, [](std::uint32_t w) { return w == 0; });
}
bool sameWords(const FluenceVoxel& a, const FluenceVoxel& b) { return std::equal(a.words, a.words + 4, b.words); }

Float3 unitVector(Random& random) {
  std::normal_distribution<double> n;
  return Float3(kernels::normalize(Double3(n(random), n(random), n(random))));
}

/// Light of any colour and spread; every third is a beam, whose direction sum is as long as its luminance.
PackedLight randomLight(Random& random, double magnitude) {
  std::uniform_real_distribution<double> u(0, 1);
  const auto channel = [&] { return u(random) < .2 ? 0.0f : static_cast<float>(u(random) * magnitude); };
  PackedLight light{{channel(), channel(), channel()}, {}};
  const auto spread = static_cast<float>(random() % 3 == 0 ? 1 : u(random));
  light.towards = unitVector(random) * (kernels::luminance(light.fluence) * spread);
  return light;
}

void expectNear(const PackedLight& stored, const PackedLight& light, double fluenceError, double towardsError) {
  const double largest = kernels::maxComponent(light.fluence);
  for (int c = 0; c < 3; ++c) {
    ASSERT_NEAR(stored.fluence[c], light.fluence[c], fluenceError * largest) << "channel " << c << " of " << largest;
    ASSERT_NEAR(stored.towards[c], light.towards[c], towardsError * largest) << "direction " << c << " of " << largest;
  }
}

TEST(FluenceVoxel, IsAMillionthOfTheLargestChannelOffAtMost) {
  Random random(1);
  for (double exponent = -30; exponent <= 30; exponent += .01)
    for (int i = 0; i < 40; ++i) {
      const PackedLight light = randomLight(random, std::pow(10, exponent));
      const FluenceVoxel voxel = pack(light);
      if (kernels::maxComponent(light.fluence) == 0) continue;
      const PackedLight stored = unpack(voxel);
      // The last term: the direction's own rounding.
      expectNear(stored, light, kFluenceError, kTowardsError + 1e-7);
      ASSERT_TRUE(sameWords(pack(stored), voxel)) << "what is stored is stored again as it is";
      ASSERT_LE(kernels::length(stored.meanDirection()), 1.000001f);
    }
}

TEST(FluenceVoxel, KeepsBeamsBeams) {
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const Float3 d = unitVector(random);
    const Float3 fluence(1 + static_cast<float>(random() % 1000), 700, 300);
    const Float3 mean = unpack(pack({fluence, d * kernels::luminance(fluence)})).meanDirection();
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(mean[c], d[c], 8e-6);
    ASSERT_GT(kernels::length(mean), 1 - 8e-6f);
  }
}

TEST(FluenceVoxel, HoldsOneChannelAlone) {
  for (int c = 0; c < 3; ++c)
    for (float v = 1e-30f; v < 1e30f; v *= 1.7f) {
      const Float3 fluence(c == 0 ? v : 0, c == 1 ? v : 0, c == 2 ? v : 0);
      const PackedLight stored = unpack(pack({fluence, {0, 0, 0}}));
      ASSERT_NEAR(stored.fluence[c], v, kFluenceError * v);
      ASSERT_EQ(stored.fluence[(c + 1) % 3] + stored.fluence[(c + 2) % 3], 0);
      ASSERT_EQ(kernels::dot(stored.towards, stored.towards), 0);
    }
}

// More light is never stored as less, across the ends of exponents too.
TEST(FluenceVoxel, IsMonotone) {
  for (const float start : {1e-20f, .125f, .99999f, 1.99999f, 3.9f, 65535.9f}) {
    float v = start, last = 0;
    for (int i = 0; i < 200000; ++i, v = std::nextafter(v, std::numeric_limits<float>::max())) {
      const float stored = unpack(pack({{v, v / 3, v / 5}, {0, 0, 0}})).fluence.x;
      ASSERT_GE(stored, last) << v;
      last = stored;
    }
    float beside = 0; // of a channel under a larger one
    for (float w = 0; w < 1; w += 1e-5f) {
      const float stored = unpack(pack({{start, start * w, 0}, {0, 0, 0}})).fluence.y;
      ASSERT_GE(stored, beside) << w;
      beside = stored;
    }
  }
}

TEST(FluenceVoxel, IsZeroWordsWhereItIsDarkOrNearlySo) {
  EXPECT_TRUE(isDark(pack({})));
  const PackedLight dark = unpack({});
  EXPECT_EQ(kernels::maxComponent(dark.fluence), 0);
  EXPECT_EQ(kernels::dot(dark.towards, dark.towards), 0);
  const float below = std::nextafter(kLeast, 0.0f);
  for (const float v : {below, 1e-35f, std::numeric_limits<float>::min(), std::numeric_limits<float>::denorm_min()})
    EXPECT_TRUE(isDark(pack({{v, 0, v}, {0, v, 0}}))) << v;
  EXPECT_NEAR(unpack(pack({{0, kLeast, 0}, {0, 0, 0}})).fluence.y, kLeast, kFluenceError * kLeast);
}

TEST(FluenceVoxel, HoldsTheLargestNumbersThereAre) {
  const float most = std::numeric_limits<float>::max();
  const PackedLight stored = unpack(pack({{most, most / 2, 1}, {-most / 2, 0, most / 2}}));
  EXPECT_NEAR(stored.fluence.x / most, 1, kFluenceError);
  EXPECT_NEAR(stored.fluence.y / most, .5, kFluenceError);
  EXPECT_NEAR(stored.towards.x / most, -.5, kTowardsError);
  EXPECT_NEAR(stored.towards.z / most, .5, kTowardsError);
}

// Every instruction set stores the same words as kernels::pack of the Gaussian written down plainly, in the same order
// of sums: z, y, x.
TEST(FluenceVoxel, IsPackedByLanesAsByOne) {
  constexpr int kEdge = 10;
  const auto at = [](int x, int y, int z) { return (std::size_t(x) * kEdge + y) * kEdge + z; };
  Random random(3);
  for (int round = 0; round < 60; ++round) {
    std::vector<float> sums(1000 * 8);
    for (int v = 0; v < 1000; ++v) {
      const double magnitude = round % 2 ? 1 : std::pow(10, static_cast<double>(random() % 76) - 38);
      const PackedLight light = random() % 3 ? randomLight(random, magnitude) : PackedLight{};
      for (int c = 0; c < 3; ++c) sums[8 * v + c] = light.fluence[c], sums[8 * v + 4 + c] = light.towards[c];
    }
    kernels::LightSums<float> in{sums.data(), nullptr, 0, {}, {}, 1, round % 3 != 0};
    for (int a = 0; a < 3; ++a) {
      in.from[a] = static_cast<std::int32_t>(random() % 2);
      in.to[a] = static_cast<std::int32_t>(random() % 2 ? kEdge : 2 + random() % 8);
    }
    std::array<std::vector<float>, 4> pass;
    pass[0] = sums;
    for (int p = 0; p < 3; ++p) {
      const int axis = 2 - p;
      pass[p + 1].resize(sums.size());
      for (int x = in.from[0]; x < in.to[0]; ++x)
        for (int y = in.from[1]; y < in.to[1]; ++y)
          for (int z = in.from[2]; z < in.to[2]; ++z) {
            int low[3] = {x, y, z}, high[3] = {x, y, z};
            low[axis] = std::max(low[axis] - 1, in.from[axis]);
            high[axis] = std::min(high[axis] + 1, in.to[axis] - 1);
            for (int i = 0; i < 8; ++i) {
              const float a = pass[p][8 * at(low[0], low[1], low[2]) + i], b = pass[p][8 * at(x, y, z) + i],
                          c = pass[p][8 * at(high[0], high[1], high[2]) + i];
              pass[p + 1][8 * at(x, y, z) + i] = in.smooth ? (a + c) + 2 * b : b;
            }
          }
    }
    for (const LaneSet& set : laneSets()) {
      SCOPED_TRACE(testing::Message() << set.name << " round " << round);
      std::vector<FluenceVoxel> out(512, FluenceVoxel{{7, 7, 7, 7}});
      set.finishBrick(in, out.data());
      for (int k = 0; k < 512; ++k) {
        const int x = (k >> 6) + 1, y = (k >> 3 & 7) + 1, z = (k & 7) + 1;
        if (x >= in.to[0] || y >= in.to[1]) {
          ASSERT_TRUE(sameWords(out[k], {{7, 7, 7, 7}})) << "outside the domain";
        } else if (z >= in.to[2]) {
          ASSERT_TRUE(isDark(out[k])) << "beside the domain";
        } else {
          const float scale = in.smooth ? 1.0f / 64 : 1;
          float v[8];
          for (int i = 0; i < 8; ++i) v[i] = pass[3][8 * at(x, y, z) + i] * scale;
          ASSERT_TRUE(sameWords(out[k], pack({{v[0], v[1], v[2]}, {v[4], v[5], v[6]}}))) << x << ' ' << y << ' ' << z;
        }
      }
    }
  }
}

/// A grid of dark bricks, constants and voxels, and what each voxel holds.
struct RandomGrid {
  Vec3i dims{20, 17, 35};
  FluenceGrid grid{dims};
  std::vector<PackedLight> voxels;

  [[nodiscard]] PackedLight& at(int x, int y, int z) {
    return voxels[(std::size_t(std::clamp(x, 0, dims[0] - 1)) * dims[1] + std::clamp(y, 0, dims[1] - 1)) * dims[2] +
                  std::clamp(z, 0, dims[2] - 1)];
  }
  RandomGrid() : voxels(std::size_t(dims[0]) * dims[1] * dims[2]) {
    Random random(4);
    grid.reserve(grid.brickCount(), {});
    for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
      const Vec3i c = grid.brickCoord(b);
      EXPECT_EQ(grid.brickIndex(c), b);
      std::array<PackedLight, kBrickVoxels> lights{};
      if (b % 3 == 1) {
        lights.fill(unpack(pack(randomLight(random, 5))));
        grid.setConstant(b, lights[0]);
      } else if (b % 3 == 2) {
        const std::int32_t slot = grid.claim(1);
        for (PackedLight& l : lights) l = unpack(pack(randomLight(random, 5)));
        for (int k = 0; k < kBrickVoxels; ++k) grid.slot(slot)[k] = pack(lights[k]);
        grid.assign(b, slot);
      }
      for (int k = 0; k < kBrickVoxels; ++k) {
        const int x = 8 * c[0] + (k >> 6), y = 8 * c[1] + (k >> 3 & 7), z = 8 * c[2] + (k & 7);
        if (x < dims[0] && y < dims[1] && z < dims[2]) at(x, y, z) = lights[k];
      }
    }
  }
};

TEST(FluenceField, GivesEachVoxelItsLight) {
  RandomGrid random;
  const kernels::FluenceField field = random.grid.view();
  for (int x = 0; x < random.dims[0]; ++x)
    for (int y = 0; y < random.dims[1]; ++y)
      for (int z = 0; z < random.dims[2]; ++z) expectNear(field.at({x, y, z}), random.at(x, y, z), 0, 0);
  for (std::int64_t b = 0; b < random.grid.brickCount(); ++b) {
    EXPECT_EQ(random.grid.isDark(b), b % 3 == 0);
    EXPECT_EQ(random.grid.isConstant(b), b % 3 != 2);
  }
}

// Inside bricks, across their faces and edges, and beyond the outermost voxel centres.
TEST(FluenceField, IsTrilinearBetweenVoxelCentres) {
  RandomGrid grid;
  const kernels::FluenceField field = grid.grid.view();
  Random random(5);
  std::uniform_real_distribution<float> u(0, 1);
  for (int i = 0; i < 200000; ++i) {
    float p[3];
    for (int a = 0; a < 3; ++a) {
      p[a] = u(random) * static_cast<float>(grid.dims[a] + 6) - 3;
      if (i % 4 == 1) p[a] = 8 * std::round(p[a] / 8) + u(random) - .5f; // near a face
      if (i % 4 == 2) p[a] = std::round(p[a]) + .5f;                     // at a centre
    }
    PackedLight expected;
    float most = 0;
    for (int corner = 0; corner < 8; ++corner) {
      int c[3];
      float weight = 1;
      for (int a = 0; a < 3; ++a) {
        const float q = p[a] - .5f, low = std::floor(q);
        const bool high = corner >> a & 1;
        c[a] = static_cast<int>(low) + high;
        weight *= high ? q - low : 1 - (q - low);
      }
      const PackedLight& l = grid.at(c[0], c[1], c[2]);
      expected += l * weight;
      most = std::max(most, kernels::maxComponent(l.fluence));
    }
    const PackedLight sample = field.sample({p[0], p[1], p[2]});
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(sample.fluence[c], expected.fluence[c], 1e-5 * most) << p[0] << ' ' << p[1] << ' ' << p[2];
      ASSERT_NEAR(sample.towards[c], expected.towards[c], 1e-5 * most) << p[0] << ' ' << p[1] << ' ' << p[2];
    }
  }
}

TEST(FluenceGrid, IsFilledFromSeveralThreads) {
  FluenceGrid grid({96, 64, 80});
  grid.reserve(grid.brickCount(), {});
  const auto lightOf = [](std::int64_t brick, int k) {
    return PackedLight{{static_cast<float>(brick + 1), static_cast<float>(k), 1}, {0, 0, 0}};
  };
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      std::vector<std::int32_t> slots;
      for (std::int64_t b = t; b < grid.brickCount(); b += 4) {
        if (slots.empty()) {
          const std::int32_t count =
              std::min<std::int32_t>(1 + t, static_cast<std::int32_t>((grid.brickCount() - b + 3) / 4));
          const std::int32_t first = grid.claim(count);
          for (std::int32_t i = 0; i < count; ++i) slots.push_back(first + i);
        }
        for (int k = 0; k < kBrickVoxels; ++k) grid.slot(slots.back())[k] = pack(lightOf(b, k));
        grid.assign(b, slots.back());
        slots.pop_back();
      }
    });
  for (std::thread& t : threads) t.join();
  const kernels::FluenceField field = grid.view();
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    const Vec3i c = grid.brickCoord(b);
    for (int k = 0; k < kBrickVoxels; k += 7) {
      const PackedLight l = field.at({8 * c[0] + (k >> 6), 8 * c[1] + (k >> 3 & 7), 8 * c[2] + (k & 7)});
      expectNear(l, lightOf(b, k), 1e-6, 0);
    }
  }
  EXPECT_EQ(grid.memoryBytes(), static_cast<std::uint64_t>(grid.brickCount()) * kBrickVoxels * 16);
}

TEST(FluenceGrid, StopsAtTheMemoryLimit) {
  FluenceGrid grid({800, 800, 800});
  RunContext ctx;
  ctx.memoryLimit = 10 * kBrickVoxels * sizeof(FluenceVoxel);
  grid.reserve(grid.brickCount(), ctx);
  EXPECT_EQ(grid.claim(4), 0);
  EXPECT_EQ(grid.claim(6), 4);
  try {
    (void)grid.claim(1);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    const std::string line = e.what();
    EXPECT_NE(line.find("--memory-limit"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST(FluenceGrid, ConstantsThatAreDarkAreNothing) {
  FluenceGrid grid({16, 8, 8});
  grid.setConstant(0, {});
  EXPECT_TRUE(grid.isDark(0));
  grid.setConstant(0, {{1, 2, 3}, {0, 0, 1}});
  EXPECT_FALSE(grid.isDark(0));
  EXPECT_TRUE(grid.isConstant(0));
  grid.setConstant(0, {{1e-38f, 0, 0}, {0, 0, 0}});
  EXPECT_TRUE(grid.isDark(0));
}

} // namespace
} // namespace volcaustic::test
