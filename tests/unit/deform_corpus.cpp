// The real files of the shared folder, whole and messy: whatever hangs together follows its handles, nothing else
// moves, and no number is lost.
#include "support/shared_data.h"
#include "unit/deform_support.h"

#include <algorithm>
#include <filesystem>

namespace volcaustic::test {
namespace {

constexpr std::uintmax_t kLargestFile = 1200000; // more of them take more than a test should

/// Meshes of one folder that can be read and are not large.
std::vector<std::pair<std::string, Mesh>> meshesOf(const std::string& folder) {
  std::vector<std::pair<std::string, Mesh>> meshes;
  for (const auto& entry : std::filesystem::directory_iterator(sharedPath("data/" + folder))) {
    if (!entry.is_regular_file() || entry.file_size() > kLargestFile) continue;
    try {
      meshes.emplace_back(entry.path().filename().string(), readMesh(entry.path()));
    } catch (const Error&) {
      continue; // the tests of the readers say which
    }
  }
  return meshes;
}

/// A handle that holds the lowest point of the mesh and one that turns the highest.
std::vector<Deformer> heldTopAndBottom(const Mesh& mesh) {
  const Box box = bounds(mesh);
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) size = std::max(size, box.max[k] - box.min[k]);
  const auto byHeight = [](const Vec3d& a, const Vec3d& b) { return a[2] < b[2]; };
  const auto [low, high] = std::minmax_element(mesh.positions.begin(), mesh.positions.end(), byHeight);
  return {handle(*low, size / 8), handle(*high, size / 16, {.translate = {size / 4, 0, 0}, .rotate = {0, 50, 20}})};
}

class DeformCorpus : public testing::TestWithParam<const char*> {};

TEST_P(DeformCorpus, FollowsHandlesAndBrushesInFiniteNumbers) {
  VOLCAUSTIC_NEED_SHARED(sharedPath(std::string("data/") + GetParam()));
  for (const auto& [name, mesh] : meshesOf(GetParam())) {
    SCOPED_TRACE(name);
    std::vector<Deformer> steps = heldTopAndBottom(mesh);
    const Mesh turned = deformed(mesh, steps, {.iterations = 3});
    EXPECT_TRUE(allFinite(turned));
    EXPECT_NE(turned.positions, mesh.positions);
    EXPECT_EQ(turned.triangles, mesh.triangles);
    EXPECT_EQ(turned.triangleGroup, mesh.triangleGroup);
    for (const DeformerType type : {DeformerType::Inflate, DeformerType::Twist, DeformerType::Smooth}) {
      const double strength = type == DeformerType::Inflate ? steps[0].radius / 8 : 1;
      steps.push_back(brush(type, steps[1].center, steps[0].radius, strength, {0, 0, 1}));
    }
    EXPECT_TRUE(allFinite(deformed(mesh, steps, {DeformMethod::Laplacian, 1})));
  }
}

TEST_P(DeformCorpus, IsSearchedForSelfIntersections) {
  VOLCAUSTIC_NEED_SHARED(sharedPath(std::string("data/") + GetParam()));
  for (const auto& [name, mesh] : meshesOf(GetParam())) {
    SCOPED_TRACE(name);
    const SelfIntersections found = findSelfIntersections(mesh);
    EXPECT_EQ(found.examples.size(), std::min<std::uint64_t>(found.pairs, SelfIntersections::kListed));
    EXPECT_TRUE(std::ranges::is_sorted(found.examples));
    const MeshReport report = checkMesh(mesh);
    if (report.duplicateFaces > report.degenerateFaces) {
      EXPECT_TRUE(found.any()); // a face on another is one
    }
    for (std::size_t k = 0; k < 3 && found.any(); ++k) {
      EXPECT_GE(found.bounds.min[k], report.bounds.min[k]);
      EXPECT_LE(found.bounds.max[k], report.bounds.max[k]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, DeformCorpus, testing::Values("meshes_clean", "meshes_messy", "meshes_quirky"),
                         [](const auto& one) { return std::string(one.param); });

TEST(SelfIntersectionCorpus, KnowsTheFilesByName) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/meshes_messy"));
  EXPECT_TRUE(findSelfIntersections(readMesh(sharedPath("data/meshes_messy/self_intersectA.obj"))).any());
  for (const char* sound : {"unit_cube.stl", "diamond_octa.obj", "unit_sphere.stl", "icosphere_1k.obj", "torus_4k.obj"})
    EXPECT_EQ(findSelfIntersections(readMesh(sharedPath(std::string("data/meshes_clean/") + sound))).pairs, 0u)
        << sound;
}

} // namespace
} // namespace volcaustic::test
