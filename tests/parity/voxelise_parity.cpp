// Media built on the CUDA device against the CPU: coverage, index, optics and flat arrays the same to the bit.

#include "parity/gpu_required.h"
#include "support/shared_data.h"
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"
#include "volume/flatten.h"
#include "volume/medium_store.h"

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

/// A medium of one body, and what is asked of it.
struct Built {
  Medium medium;
  std::shared_ptr<const OpticsBricks> bricks;

  Built(std::vector<Body> bodies, const Domain& domain, const VoxeliseOptions& options, const RunContext& ctx)
      : medium(buildMedium(bodies, {}, domain, options, ctx)), bricks(bricksOf(medium, ctx)) {}
  Built(const Mesh& mesh, const Domain& domain, int supersample, const RunContext& ctx)
      : Built({bodyOf(mesh)}, domain, sharp(supersample), ctx) {}

  static VoxeliseOptions sharp(int supersample) {
    VoxeliseOptions options;
    options.supersample = supersample;
    options.blur = 1;
    return options;
  }
};

/// Whether two grids have the same bits in every voxel.
template <class T>
testing::AssertionResult sameGrid(const BrickGrid<T>& x, const BrickGrid<T>& y) {
  if (x.dims() != y.dims()) return testing::AssertionFailure() << "other bricks";
  for (std::int64_t i = 0; i < x.brickCount(); ++i) {
    const bool same = x.isConstant(i) != y.isConstant(i) ? false
                      : x.isConstant(i)
                          ? x.constant(i) == y.constant(i)
                          : std::memcmp(x.voxels(i).data(), y.voxels(i).data(), kBrickVoxels * sizeof(T)) == 0;
    if (!same) return testing::AssertionFailure() << "brick " << i << " of " << x.brickCount() << " differs";
  }
  return testing::AssertionSuccess();
}
testing::AssertionResult sameBits(const Built& a, const Built& b) {
  if (auto same = sameGrid(a.bricks->coverage, b.bricks->coverage); !same) return same << " in its coverage";
  if (auto same = sameGrid(a.bricks->index, b.bricks->index); !same) return same << " in its index";
  const auto sameOptional = [](const auto& x, const auto& y) {
    if (!x || !y) return x.has_value() == y.has_value() ? testing::AssertionSuccess() : testing::AssertionFailure();
    return sameGrid(*x, *y);
  };
  if (auto same = sameOptional(a.bricks->attenuation, b.bricks->attenuation); !same) return same << " (attenuation)";
  if (auto same = sameOptional(a.bricks->scattering, b.bricks->scattering); !same) return same << " (scattering)";
  return sameOptional(a.bricks->asymmetry, b.bricks->asymmetry);
}

/// Of what does not depend on the order of the palette.
void expectSameArrays(const FlatMediumStorage& a, const FlatMediumStorage& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(*x.data())) == 0;
  };
  EXPECT_TRUE(same(a.indexOffsets, b.indexOffsets));
  EXPECT_TRUE(same(a.stepSlots, b.stepSlots));
  EXPECT_TRUE(same(a.steps, b.steps));
  EXPECT_TRUE(same(a.bends, b.bends));
  EXPECT_EQ(a.ambientStep, b.ambientStep);
  EXPECT_EQ(a.optics.size(), b.optics.size());
  for (std::size_t i = 0; i < a.fieldSlots.size(); ++i) {
    ASSERT_EQ(a.fieldSlots[i] > 0, b.fieldSlots[i] > 0) << i;
    const auto at = [i](const FlatMediumStorage& f) {
      return f.fields.data() + std::ptrdiff_t{f.fieldSlots[i]} * kernels::kFieldVoxels;
    };
    ASSERT_EQ(std::memcmp(at(a), at(b), kernels::kFieldVoxels * sizeof(kernels::FieldVoxel)), 0) << i;
  }
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
  for (const int supersample : {1, 2, 4, 8})
    EXPECT_TRUE(sameBits(Built(mesh, cubeDomain(kVoxels), supersample, on("cpu")),
                         Built(mesh, cubeDomain(kVoxels), supersample, on("cuda"))))
        << supersample << " sub-voxels";
}

// What both machines had wrong in the same way would be seen here.
TEST_F(VoxeliseParity, ABallHasItsVolume) {
  const Mesh mesh = ballAt(kMiddle, 20);
  const Built gpu(mesh, cubeDomain(kVoxels), 4, on("cuda"));
  EXPECT_NEAR(volume({{0, 0, 0}, gpu.bricks->coverage}, cubeDomain(kVoxels)), signedVolume(mesh),
              5e-4 * signedVolume(mesh));
}

TEST_F(VoxeliseParity, RealMeshesGiveTheCpusBits) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/meshes_clean"));
  for (const char* name : {"dragon_100k.obj", "fandisk_13k.obj", "gyroid_28k_binary.ply", "wine-glass_15k.obj",
                           "thingi10k_99865.stl", "unit_cube.stl"}) {
    const Mesh mesh = readMesh(sharedPath(std::string("data/meshes_clean/") + name));
    const Domain domain = domainAround(bounds(mesh), 128, 0, 3);
    const Built cpu({bodyOf(mesh)}, domain, {}, on("cpu")), gpu({bodyOf(mesh)}, domain, {}, on("cuda"));
    EXPECT_TRUE(sameBits(cpu, gpu)) << name;
    expectSameArrays(flattenMedium(cpu.medium, {}, on("cpu")), flattenMedium(gpu.medium, {}, on("cuda")));
  }
}

// Nested bodies of several materials, one of which does not close and is voxelised on the CPU.
TEST_F(VoxeliseParity, SeveralBodiesGiveTheCpusBits) {
  std::vector<Body> bodies{bodyOf(ballAt(kMiddle, 20)), bodyOf(ballAt(kMiddle, 14, 3)),
                           bodyOf(ballAt({30, 30, 30}, 9))};
  bodies[0].material.attenuation = {.1, .2, .3};
  bodies[1].material = {"liquid", 1.33, {.5, 0, 0}, {.4, 0, 0}, .7};
  bodies[1].priority = 1;
  Mesh open = *bodies[2].mesh;
  open.triangles.resize(open.triangles.size() - 40);
  bodies[2].mesh = std::make_shared<const Mesh>(std::move(open));
  bodies[2].priority = 2;
  for (const int blur : {3, 9, 11}) {
    VoxeliseOptions options;
    options.blur = blur;
    const Built cpu(bodies, cubeDomain(kVoxels - 3), options, on("cpu"));
    const Built gpu(bodies, cubeDomain(kVoxels - 3), options, on("cuda"));
    EXPECT_TRUE(sameBits(cpu, gpu)) << blur;
    expectSameArrays(flattenMedium(cpu.medium, {}, on("cpu")), flattenMedium(gpu.medium, {}, on("cuda")));
  }
}

// A medium that was built on the device, looked at by the CPU.
TEST_F(VoxeliseParity, TheCpuFlattensWhatTheDeviceBuilt) {
  const Built cpu({bodyOf(ballAt(kMiddle, 20))}, cubeDomain(kVoxels), {}, on("cpu"));
  const Built gpu({bodyOf(ballAt(kMiddle, 20))}, cubeDomain(kVoxels), {}, on("cuda"));
  const FlatMediumStorage flat = flattenMedium(gpu.medium, {}, on("cpu"));
  EXPECT_EQ(flat.onDevice, nullptr);
  expectSameArrays(flattenMedium(cpu.medium, {}, on("cpu")), flat);
}

// Where the device does not hold all columns at a time they go in several parts.
TEST_F(VoxeliseParity, PartsGiveTheBitsOfTheWhole) {
  const Mesh mesh = ballAt(kMiddle, 20);
  RunContext tight = on("cuda");
  tight.memoryLimit = 6 << 20;
  int parts = 0;
  tight.onProgress = [&](std::string_view stage, double) { parts += stage == "voxelise"; };
  const Built inParts(mesh, cubeDomain(kVoxels), 8, tight);
  EXPECT_GT(parts, 1);
  EXPECT_TRUE(sameBits(Built(mesh, cubeDomain(kVoxels), 8, on("cpu")), inParts));
}

TEST_F(VoxeliseParity, TooLittleMemoryIsOneErrorLineOrTheCpu) {
  const Mesh mesh = ballAt(kMiddle, 20, 6);
  RunContext ctx = on("cuda");
  ctx.memoryLimit = 2700 << 10; // the mesh, and no column of bricks
  try {
    (void)Built(mesh, cubeDomain(kVoxels), 8, ctx);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Device);
    EXPECT_NE(std::string(e.what()).find("memory"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }

  ctx.device = "auto";
  int warnings = 0;
  ctx.onLog = [&](LogLevel level, std::string_view) { warnings += level == LogLevel::Warning; };
  const Built fallen(mesh, cubeDomain(kVoxels), 8, ctx);
  EXPECT_EQ(warnings, 1);
  EXPECT_TRUE(sameBits(Built(mesh, cubeDomain(kVoxels), 8, on("cpu")), fallen));
}

} // namespace volcaustic::test
