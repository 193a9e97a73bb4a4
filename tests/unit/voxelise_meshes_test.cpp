// Real meshes, good and bad: the volume of their coverage is the volume that they enclose, and what is inside is what
// the definition says, summed triangle by triangle.
#include "support/shared_data.h"
#include "unit/voxelise_support.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

std::vector<std::string> meshesIn(const std::vector<std::string>& folders) {
  std::vector<std::string> files;
  for (const std::string& folder : folders) {
    std::error_code absent;
    for (const auto& entry : std::filesystem::directory_iterator(sharedPath("data/" + folder), absent))
      files.push_back(folder + "/" + entry.path().filename().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string testName(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
}

class CleanMesh : public testing::TestWithParam<std::string> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CleanMesh);

TEST_P(CleanMesh, CoverageHasTheSignedVolume) {
  const Mesh mesh = readMesh(sharedPath("data/" + GetParam()));
  const Domain domain = domainAround(bounds(mesh), 256, 0, 2);
  const CoveragePatch patch = voxelise(mesh, domain, 4, FillRule::Exact);
  EXPECT_NEAR(volume(patch, domain) / std::abs(signedVolume(mesh)), 1, 5e-4);
}

INSTANTIATE_TEST_SUITE_P(Shared, CleanMesh, testing::ValuesIn(meshesIn({"meshes_clean"})), testName);

/// Samples of a lattice of one sample a voxel that are not what |w| >= 1/2 says, of `count` random ones.
int wrongSamples(const Mesh& mesh, const Domain& domain, int count) {
  const CoveragePatch patch = voxelise(mesh, domain, 1, FillRule::Winding);
  const std::vector<float> inside = dense(patch, domain);
  std::mt19937 random(11);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  int wrong = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3i v{below(domain.dims[0]), below(domain.dims[1]), below(domain.dims[2])};
    Vec3d p = SubLattice{}.sample(v[0], v[1], v[2]);
    // A sample on a face is taken to be a little further; the sum of solid angles jumps there.
    const Vec3d nudge{0x1p-24, 0x1p-32, 0x1p-18};
    for (int a = 0; a < 3; ++a) p[a] = domain.minCorner[a] + domain.voxelSize * (p[a] + nudge[a]);
    const std::size_t at = (static_cast<std::size_t>(v[0]) * domain.dims[1] + v[1]) * domain.dims[2] + v[2];
    wrong += (inside[at] != 0) != (std::abs(windingNumber(mesh, p)) >= 0.5);
  }
  return wrong;
}

class AnyMesh : public testing::TestWithParam<std::string> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(AnyMesh);

TEST_P(AnyMesh, InsideIsWhatTheWindingNumberSays) {
  Mesh mesh;
  Domain domain;
  try {
    mesh = readMesh(sharedPath("data/" + GetParam()));
    domain = domainAround(bounds(mesh), 96, 0, 2);
  } catch (const Error& e) { // files without faces or with absurd coordinates are among them
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    return;
  }
  const int samples = std::clamp(static_cast<int>(5e6 / static_cast<double>(mesh.triangles.size())), 1000, 20000);
  const int wrong = wrongSamples(mesh, domain, samples);
  RecordProperty("samples", samples);
  RecordProperty("wrong", wrong);
  EXPECT_LE(wrong, samples / 1000) << "of " << samples;
}

INSTANTIATE_TEST_SUITE_P(Shared, AnyMesh, testing::ValuesIn(meshesIn({"meshes_messy", "meshes_quirky"})), testName);

TEST(RealMesh, RotationAndTranslationKeepTheVolume) {
  for (const char* file : {"bunny_hr_59k.obj", "wine-glass_15k.obj"}) {
    const auto path = sharedPath(std::string("data/meshes_clean/") + file);
    VOLCAUSTIC_NEED_SHARED(path);
    const Mesh mesh = readMesh(path);
    const double h = domainAround(bounds(mesh), 128, 0, 2).voxelSize;
    const auto coverageVolume = [&](const Mesh& m) {
      const Domain domain = domainAround(bounds(m), 0, h, 2);
      return volume(voxelise(m, domain, 4, FillRule::Exact), domain);
    };
    const double expected = coverageVolume(mesh);
    for (const auto& [aboutZ, aboutX] : {std::pair(0.3, 0.0), {1.1, 0.7}, {2.5, 4.0}})
      EXPECT_NEAR(coverageVolume(rotated(mesh, aboutZ, aboutX)) / expected, 1, 1e-3) << file;
    for (const Vec3d& by : {Vec3d{0.37, 0.11, -0.83}, {1e5, -1e5, 1e5}, {1e5 + 0.3, 0.7, -1e5}})
      EXPECT_NEAR(coverageVolume(translated(mesh, {by[0] * h, by[1] * h, by[2] * h})) / expected, 1, 1e-3) << file;
  }
}

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
