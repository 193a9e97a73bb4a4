// Real meshes: the volume of their coverage is the volume that they enclose.
#include "support/shared_data.h"
#include "unit/voxelise_support.h"

#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

class RealMesh : public testing::TestWithParam<const char*> {};

TEST_P(RealMesh, CoverageHasTheMeshVolume) {
  const auto path = sharedPath(std::string("data/meshes_clean/") + GetParam());
  VOLCAUSTIC_NEED_SHARED(path);
  const Mesh mesh = readMesh(path);
  const Domain domain = domainAround(bounds(mesh), 256, 0, 2);
  const CoveragePatch patch = voxelise(mesh, domain, 4, FillRule::Exact);
  EXPECT_NEAR(volume(patch, domain) / std::abs(signedVolume(mesh)), 1, 0.002);
}

INSTANTIATE_TEST_SUITE_P(Clean, RealMesh,
                         testing::Values("icosphere_1k.obj", "bunny_hr_59k.obj", "dragon_100k.obj",
                                         "igea_268k_tristrips.ply", "armadillo_29k.obj", "lucy_15k.ply",
                                         "nefertiti_100k.obj", "skull_100k.obj", "wine-glass_15k.obj",
                                         "fuze_bottle.obj", "gyroid_28k_binary.ply", "torus_4k.obj", "emerald_gem.obj",
                                         "unit_cube.stl", "hammer_60k.obj", "sphere_32k.off"));

TEST(DamagedMesh, TheOpenBunnyIsFilled) {
  const auto open = sharedPath("data/meshes_messy/bunny_original_69k.ply");
  VOLCAUSTIC_NEED_SHARED(open);
  const Mesh mesh = readMesh(open);
  const Domain domain = domainAround(bounds(mesh), 128, 0, 2);
  int warnings = 0;
  RunContext ctx;
  ctx.onLog = [&](LogLevel, std::string_view) { ++warnings; };
  const CoveragePatch patch = voxelise(mesh, domain, 4, FillRule::Auto, ctx);
  EXPECT_EQ(warnings, 1);
  EXPECT_NEAR(volume(patch, domain) / signedVolume(mesh), 1, 0.03);
}

} // namespace
} // namespace volcaustic::test
