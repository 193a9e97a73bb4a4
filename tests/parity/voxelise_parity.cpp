// Voxelising on the CUDA device against the CPU: the same coverage to the bit, brick by brick.

#include "parity/gpu_required.h"
#include "support/shared_data.h"
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"

#include <cstring>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace volcaustic::test {

namespace {

constexpr int kVoxels = 48;
constexpr Vec3d kMiddle{24.1, 24.2, 24.3};

Mesh ballAt(const Vec3d& centre, double radius, int subdivisions = 4) {
  return translated(icosphere({0, 0, 0}, radius, subdivisions), centre);
}
/// A box whose corner is in the middle of the domain: three faces of triangles as large as the box go through.
Mesh cornerOfBox(double edge) { return translated(rotated(box({0, 0, 0}, {edge, edge, edge}), 0.3, 0.4), kMiddle); }

struct Solid {
  const char* name;
  Mesh (*make)();
};
constexpr Solid kSolids[] = {
    {"ball", [] { return ballAt(kMiddle, 20); }},
    {"insideOut", [] { return reversed(ballAt(kMiddle, 20)); }},
    {"hollow", [] { return joined(ballAt(kMiddle, 20), reversed(ballAt(kMiddle, 12, 3))); }},
    {"overlapping",
     [] {
       return joined(ballAt(kMiddle, 18), ballAt({30, 24.2, 24.3}, 12));
     }},
    {"againstEachOther",
     [] {
       return joined(ballAt(kMiddle, 18), reversed(ballAt({30, 24.2, 24.3}, 12)));
     }},
    // Each crossing five times at the same sample.
    {"fiveInOne",
     [] {
       return joined(joined(cornerOfBox(15), cornerOfBox(15)),
                     joined(joined(cornerOfBox(15), cornerOfBox(15)), cornerOfBox(15)));
     }},
    {"nothing", [] { return joined(ballAt(kMiddle, 20), reversed(ballAt(kMiddle, 20))); }},
    {"facesOnSamples",
     [] {
       return box({4.125, 4.125, 4.125}, {33.125, 29.125, 41.125});
     }},
    {"facesOnBricks",
     [] {
       return box({8, 8, 8}, {40, 40, 40});
     }},
    {"tallerThanTheDomain",
     [] {
       return box({3, 3, -9}, {12.3, 13.4, 400});
     }},
    {"thinPlate",
     [] {
       return translated(rotated(box({0, 0, 0}, {40, 40, 0.05}), 0.01, 0.02), {3, 3, 20});
     }},
    {"torus", [] { return translated(rotated(torus(15, 5, 80, 40), 0.4, 0.9), kMiddle); }},
    {"sticksOut",
     [] {
       return ballAt({10, 24.2, 40.3}, 30);
     }},
    {"exactInDoubles", [] { return cornerOfBox(50); }},
    {"exactInInt64", [] { return cornerOfBox(3000); }},
    {"exactInInt128", [] { return cornerOfBox(1e8); }},
};

RunContext on(const char* device) {
  RunContext ctx;
  ctx.device = device;
  return ctx;
}

/// Whether two patches are the same bricks with the same bits.
testing::AssertionResult sameBits(const CoveragePatch& a, const CoveragePatch& b) {
  const BrickGrid<float>&x = a.coverage, &y = b.coverage;
  if (a.firstBrick != b.firstBrick || x.dims() != y.dims()) return testing::AssertionFailure() << "other bricks";
  for (std::int64_t i = 0; i < x.brickCount(); ++i) {
    const bool same = x.isConstant(i) != y.isConstant(i) ? false
                      : x.isConstant(i)
                          ? x.constant(i) == y.constant(i)
                          : std::memcmp(x.voxels(i).data(), y.voxels(i).data(), kBrickVoxels * sizeof(float)) == 0;
    if (!same) return testing::AssertionFailure() << "brick " << i << " of " << x.brickCount() << " differs";
  }
  return testing::AssertionSuccess();
}

class VoxeliseParity : public testing::Test {
protected:
  void SetUp() override { VOLCAUSTIC_NEED_GPU(); }
};

class VoxeliseSolids : public testing::TestWithParam<Solid> {
protected:
  void SetUp() override { VOLCAUSTIC_NEED_GPU(); }
};
INSTANTIATE_TEST_SUITE_P(Solids, VoxeliseSolids, testing::ValuesIn(kSolids),
                         [](const auto& solid) { return std::string(solid.param.name); });

} // namespace

TEST_P(VoxeliseSolids, CoverageIsTheCpusToTheBit) {
  const Mesh mesh = GetParam().make();
  for (const int supersample : {1, 2, 4, 8}) {
    const CoveragePatch cpu = voxelise(mesh, cubeDomain(kVoxels), supersample, FillRule::Exact, on("cpu"));
    const CoveragePatch gpu = voxelise(mesh, cubeDomain(kVoxels), supersample, FillRule::Exact, on("cuda"));
    EXPECT_TRUE(sameBits(cpu, gpu)) << supersample << " sub-voxels";
  }
}

// What both machines had wrong in the same way would be seen here.
TEST_F(VoxeliseParity, ABallHasItsVolume) {
  const Mesh mesh = ballAt(kMiddle, 20);
  const CoveragePatch gpu = voxelise(mesh, cubeDomain(kVoxels), 4, FillRule::Exact, on("cuda"));
  EXPECT_NEAR(volume(gpu, cubeDomain(kVoxels)), signedVolume(mesh), 5e-4 * signedVolume(mesh));
}

TEST_F(VoxeliseParity, RealMeshesGiveTheCpusBits) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/meshes_clean"));
  for (const char* name : {"dragon_100k.obj", "fandisk_13k.obj", "gyroid_28k_binary.ply", "wine-glass_15k.obj",
                           "thingi10k_99865.stl", "unit_cube.stl"}) {
    const Mesh mesh = readMesh(sharedPath(std::string("data/meshes_clean/") + name));
    const Domain domain = domainAround(bounds(mesh), 128, 0, 3);
    EXPECT_TRUE(sameBits(voxelise(mesh, domain, 4, FillRule::Auto, on("cpu")),
                         voxelise(mesh, domain, 4, FillRule::Auto, on("cuda"))))
        << name;
  }
}

// Where the device does not hold all columns at a time they go in several parts.
TEST_F(VoxeliseParity, PartsGiveTheBitsOfTheWhole) {
  const Mesh mesh = ballAt(kMiddle, 20);
  RunContext tight = on("cuda");
  tight.memoryLimit = 1 << 20;
  int parts = 0;
  tight.onProgress = [&](std::string_view, double) { ++parts; };
  const CoveragePatch inParts = voxelise(mesh, cubeDomain(kVoxels), 8, FillRule::Exact, tight);
  EXPECT_GT(parts, 4);
  EXPECT_TRUE(sameBits(voxelise(mesh, cubeDomain(kVoxels), 8, FillRule::Exact, on("cpu")), inParts));
}

TEST_F(VoxeliseParity, TooLittleMemoryIsOneErrorLineOrTheCpu) {
  const Mesh mesh = ballAt(kMiddle, 20, 5);
  RunContext ctx = on("cuda");
  ctx.memoryLimit = 700 << 10; // the mesh, and no column of bricks
  try {
    (void)voxelise(mesh, cubeDomain(kVoxels), 8, FillRule::Exact, ctx);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Device);
    EXPECT_NE(std::string(e.what()).find("out of memory"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }

  ctx.device = "auto";
  int warnings = 0;
  ctx.onLog = [&](LogLevel level, std::string_view) { warnings += level == LogLevel::Warning; };
  const CoveragePatch fallen = voxelise(mesh, cubeDomain(kVoxels), 8, FillRule::Exact, ctx);
  EXPECT_EQ(warnings, 1);
  EXPECT_TRUE(sameBits(voxelise(mesh, cubeDomain(kVoxels), 8, FillRule::Exact, on("cpu")), fallen));
}

} // namespace volcaustic::test
