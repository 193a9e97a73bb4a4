// The real files of the shared folder, against the figures of its index.tsv (measured by another reader) and
// OpenMesh's.
#include "unit/mesh_support.h"

#include <chrono>
#include <fstream>
#include <map>
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <set>
#include <sstream>
#include <sys/resource.h>

namespace volcaustic::test {
namespace {

struct Expected {
  std::uint64_t triangles = 0, vertices = 0, openEdges = 0, nonManifoldEdges = 0, inconsistentEdges = 0, duplicates = 0,
                degenerate = 0, components = 0;
  std::int64_t euler = 0;
  double volume = 0, area = 0;
};

/// Rows of index.tsv that have figures for a surface, by file.
std::map<std::string, Expected> expectations() {
  std::map<std::string, Expected> result;
  std::ifstream stream(sharedPath("data/index.tsv"));
  std::string line;
  std::getline(stream, line); // titles
  while (std::getline(stream, line)) {
    std::istringstream fields(line);
    std::vector<std::string> field;
    for (std::string f; std::getline(fields, f, '\t');) field.push_back(f);
    if (field.size() < 13 || field[12].empty() || field[10].empty()) continue;
    Expected e;
    std::uint64_t* const counts[] = {&e.triangles,         &e.vertices,   &e.openEdges,  &e.nonManifoldEdges,
                                     &e.inconsistentEdges, &e.duplicates, &e.degenerate, &e.components};
    for (std::size_t k = 0; k < std::size(counts); ++k) *counts[k] = std::stoull(field[3 + k]);
    e.euler = std::stoll(field[11]);
    e.volume = std::stod(field[12]);
    e.area = std::stod(field[13]);
    result[field[0]] = e;
  }
  return result;
}

std::vector<std::filesystem::path> filesOf(const std::string& folder) {
  std::vector<std::filesystem::path> result;
  for (const auto& entry : std::filesystem::directory_iterator(sharedPath("data/" + folder)))
    result.push_back(entry.path());
  std::sort(result.begin(), result.end());
  return result;
}

/// Faces that are not convex, or far from flat: the index splits them as fans, which overlap, so only the number of
/// triangles can agree.
const std::set<std::string> kNotConvex{"concave_66gon.obj", "wallhole.obj",     "issue-319-002.obj",
                                       "box_longline.obj",  "polygonfaces.obj", "suzanne.ply"};

/// Files with a surface in the index that readMesh refuses.
const std::set<std::string> kRefused{"box_UTF16BE.obj"};

void compare(const std::filesystem::path& path, const Expected& expected) {
  SCOPED_TRACE(path);
  const Mesh mesh = readMesh(path);
  ASSERT_EQ(mesh.triangles.size(), expected.triangles);
  if (kNotConvex.contains(path.filename())) return;
  const MeshReport report = checkMesh(mesh);
  if (path.extension() != ".stl") {
    EXPECT_EQ(report.vertices, expected.vertices);
  }
  EXPECT_EQ(report.openEdges, expected.openEdges);
  EXPECT_EQ(report.nonManifoldEdges, expected.nonManifoldEdges);
  if (expected.nonManifoldEdges == 0) {
    EXPECT_EQ(report.inconsistentEdges, expected.inconsistentEdges);
  }
  EXPECT_EQ(report.duplicateFaces, expected.duplicates);
  EXPECT_GE(report.degenerateFaces, expected.degenerate); // the index counts repeated corners only
  EXPECT_EQ(report.components, expected.components);
  // Five digits, of sums whose terms may be far larger than they.
  EXPECT_NEAR(report.area, expected.area, 1e-4 * expected.area);
  const double scale = std::max(std::abs(expected.volume), 1e-9 * std::pow(expected.area, 1.5));
  EXPECT_NEAR(report.signedVolume, expected.volume, 1e-4 * scale);
}

TEST(MeshCorpus, CleanFilesHaveTheirExactShape) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/index.tsv"));
  const auto expected = expectations();
  int files = 0;
  for (const auto& path : filesOf("meshes_clean")) {
    SCOPED_TRACE(path);
    const Expected& e = expected.at("meshes_clean/" + path.filename().string());
    compare(path, e);
    const Mesh mesh = readMesh(path);
    const MeshReport report = checkMesh(mesh);
    EXPECT_TRUE(report.closedAndConsistent());
    // V - E + F with E = 3F/2 says how many vertices a closed mesh has after welding.
    if (path.extension() == ".stl") {
      EXPECT_EQ(static_cast<std::int64_t>(report.vertices), e.euler + static_cast<std::int64_t>(e.triangles / 2));
    }
    ++files;
  }
  EXPECT_EQ(files, 31);
}

TEST(MeshCorpus, MessyAndQuirkyFilesAreReadRightOrRefused) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/index.tsv"));
  const auto expected = expectations();
  for (const std::string folder : {"meshes_messy", "meshes_quirky"})
    for (const auto& path : filesOf(folder)) {
      const auto e = expected.find(folder + "/" + path.filename().string());
      if (path.filename() == "perturb3B_hexfloat.obj") { // beyond the index's reader
        expectClosed(readMesh(path), 60, checkMesh(readMesh(path)).signedVolume);
        EXPECT_EQ(readMesh(path).positions.size(), 32u);
      } else if (e == expected.end() || kRefused.contains(path.filename())) {
        EXPECT_NE(complaint(path), "") << path;
      } else {
        compare(path, e->second);
      }
    }
}

TEST(MeshCorpus, NumberFormatsNamesTheBadLine) {
  const auto path = sharedPath("data/meshes_quirky/number_formats.obj");
  VOLCAUSTIC_NEED_SHARED(path);
  EXPECT_EQ(complaint(path), "number_formats.obj:11: '3.1+e2' is not a number");
}

TEST(MeshCorpus, MalformedFilesAreRefusedSwiftlyAndInLittleMemory) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/malformed"));
  int files = 0;
  for (const auto& path : filesOf("malformed")) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_NE(complaint(path), "") << path;
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)) << path;
    ++files;
  }
  EXPECT_EQ(files, 15);
  rusage usage{};
  ASSERT_EQ(getrusage(RUSAGE_SELF, &usage), 0);
  EXPECT_LT(usage.ru_maxrss, 1 << 20); // KiB
}

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};

TEST(MeshCorpus, AgreesWithOpenMeshWhereItReadsAFileProperly) {
  VOLCAUSTIC_NEED_SHARED(sharedPath("data/meshes_clean"));
  // Its half-edges double the vertex where parts of the cow touch, and it knows no triangle strips.
  const std::set<std::string> misread{"cow_6k.obj", "igea_268k_tristrips.ply"};
  // The importer's notes go to std::cerr and std::clog, whatever is read.
  ::omlog().disable();
  ::omerr().disable();
  for (const auto& path : filesOf("meshes_clean")) {
    SCOPED_TRACE(path);
    OpenMesh::TriMesh_ArrayKernelT<DoubleTraits> theirs;
    ASSERT_TRUE(OpenMesh::IO::read_mesh(theirs, path.string()));
    const bool differs = misread.contains(path.filename());
    const Mesh ours = readMesh(path);
    EXPECT_EQ(ours.triangles.size() == theirs.n_faces() && ours.positions.size() == theirs.n_vertices(), !differs);
    if (differs) continue;
    Mesh copy;
    for (const auto v : theirs.vertices()) {
      const auto& p = theirs.point(v);
      copy.positions.push_back({p[0], p[1], p[2]});
    }
    for (const auto f : theirs.faces()) {
      auto& triangle = copy.triangles.emplace_back();
      std::size_t k = 0;
      for (const auto v : theirs.fv_range(f)) triangle[k++] = static_cast<std::uint32_t>(v.idx());
    }
    const double volume = checkMesh(ours).signedVolume;
    EXPECT_NEAR(checkMesh(copy).signedVolume, volume, 2e-5 * std::abs(volume)); // some of its readers use floats
  }
}

} // namespace
} // namespace volcaustic::test
