#include "mesh/validate.h"
#include "mesh/weld.h"
#include "volcaustic/error.h"
#include "volcaustic/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace volcaustic {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Triangles over welded vertices.
struct Welded {
  std::vector<Triangle> triangles;
  std::uint32_t vertexCount = 0;
};

Welded weld(const Mesh& mesh) {
  PositionWelder welder(mesh.positions.size());
  std::vector<std::uint32_t> number;
  number.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) number.push_back(welder.add(p));
  Welded welded;
  welded.vertexCount = static_cast<std::uint32_t>(welder.size());
  welded.triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) welded.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return welded;
}

bool hasRepeatedCorner(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Keys gathered in one bucket for each vertex, each bucket sorted: a sort of all in time linear in practice, because a
/// vertex has few edges. `emit(triangle, put)` calls put(vertex, key) as often as it likes.
class VertexBuckets {
public:
  template <class Emit>
  VertexBuckets(const Welded& welded, Emit emit) : mBegin(std::size_t{welded.vertexCount} + 1, 0) {
    for (const Triangle& t : welded.triangles) emit(t, [&](std::uint32_t v, std::uint64_t) { ++mBegin[v + 1]; });
    std::partial_sum(mBegin.begin(), mBegin.end(), mBegin.begin());
    mKeys.resize(mBegin.back());
    std::vector<std::uint64_t> end(mBegin.begin(), mBegin.end() - 1);
    for (const Triangle& t : welded.triangles)
      emit(t, [&](std::uint32_t v, std::uint64_t key) { mKeys[end[v]++] = key; });
    for (std::size_t v = 0; v + 1 < mBegin.size(); ++v)
      std::sort(mKeys.begin() + static_cast<std::ptrdiff_t>(mBegin[v]),
                mKeys.begin() + static_cast<std::ptrdiff_t>(mBegin[v + 1]));
  }

  /// Calls visit(first, last) for every run of keys of one vertex that `same` holds for.
  template <class Same, class Visit>
  void forRuns(Same same, Visit visit) const {
    for (std::size_t v = 0; v + 1 < mBegin.size(); ++v) {
      const std::uint64_t* const end = mKeys.data() + mBegin[v + 1];
      for (const std::uint64_t* first = mKeys.data() + mBegin[v]; first != end;) {
        const std::uint64_t* last = first;
        while (last != end && same(*first, *last)) ++last;
        visit(first, last);
        first = last;
      }
    }
  }

private:
  std::vector<std::uint64_t> mBegin, mKeys;
};

void countEdges(const Welded& welded, MeshReport& report) {
  // An edge lies in the bucket of its lower vertex; the key is the higher vertex and, in the lowest bit, the direction.
  const VertexBuckets edges(welded, [](const Triangle& t, auto put) {
    if (hasRepeatedCorner(t)) return; // its directed edges cancel
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      put(std::min(a, b), std::uint64_t{std::max(a, b)} << 1 | (a < b ? 1 : 0));
    }
  });
  edges.forRuns([](std::uint64_t a, std::uint64_t b) { return a >> 1 == b >> 1; },
                [&](const std::uint64_t* first, const std::uint64_t* last) {
                  const std::ptrdiff_t faces = last - first;
                  const auto forward = std::count_if(first, last, [](std::uint64_t key) { return key & 1; });
                  if (faces == 1) ++report.openEdges;
                  if (faces > 2) ++report.nonManifoldEdges;
                  if (faces > 1 && 2 * forward != faces) ++report.inconsistentEdges;
                });
}

void countDuplicates(const Welded& welded, MeshReport& report) {
  const VertexBuckets faces(welded, [](Triangle t, auto put) {
    if (hasRepeatedCorner(t)) return;
    std::sort(t.begin(), t.end());
    put(t[0], std::uint64_t{t[1]} << 32 | t[2]);
  });
  faces.forRuns([](std::uint64_t a, std::uint64_t b) { return a == b; },
                [&](const std::uint64_t* first, const std::uint64_t* last) {
                  report.duplicateFaces += static_cast<std::uint64_t>(last - first - 1);
                });
}

void countComponents(const Welded& welded, MeshReport& report) {
  constexpr std::uint32_t kUnused = 0xffffffffu;
  std::vector<std::uint32_t> parent(welded.vertexCount, kUnused);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : welded.triangles) {
    for (const std::uint32_t v : t)
      if (parent[v] == kUnused) {
        parent[v] = v;
        ++report.components;
      }
    for (const std::uint32_t v : {t[1], t[2]}) {
      const std::uint32_t a = root(t[0]), b = root(v);
      if (a == b) continue;
      parent[std::max(a, b)] = std::min(a, b);
      --report.components;
    }
  }
}

Vec3d difference(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Volume, area and degenerate faces. Everything relative to the centre of the bounds, which keeps the digits of a mesh
/// far from the origin.
void measure(const Mesh& mesh, const Welded& welded, MeshReport& report) {
  constexpr double kFlat = 1e-14; // sine of the angle at which a triangle is a line for a double
  const Box& box = report.bounds;
  const Vec3d centre{box.min[0] / 2 + box.max[0] / 2, box.min[1] / 2 + box.max[1] / 2, box.min[2] / 2 + box.max[2] / 2};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vec3d p = difference(mesh.positions[a], centre), q = difference(mesh.positions[b], centre),
                r = difference(mesh.positions[c], centre);
    const Vec3d u = difference(q, p), v = difference(r, p), w = difference(r, q);
    const Vec3d normal = cross(u, v);
    const double twiceArea = std::sqrt(dot(normal, normal));
    report.area += twiceArea / 2;
    report.signedVolume += dot(p, cross(q, r)) / 6;
    const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)});
    if (hasRepeatedCorner(welded.triangles[i]) || twiceArea <= kFlat * longest) ++report.degenerateFaces;
  }
}

} // namespace

void requireValid(const Mesh& mesh) {
  const auto fail = [](const std::string& what) { throw Error(ErrorKind::Input, "mesh: " + what); };
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    for (const double x : mesh.positions[i])
      if (!std::isfinite(x)) fail("vertex " + std::to_string(i) + " is not finite");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const std::uint32_t v : mesh.triangles[i])
      if (v >= mesh.positions.size())
        fail("triangle " + std::to_string(i) + " refers to vertex " + std::to_string(v) + " of " +
             std::to_string(mesh.positions.size()));
  if (mesh.triangleGroup.empty()) return;
  if (mesh.triangleGroup.size() != mesh.triangles.size()) fail("triangleGroup needs one entry for each triangle");
  for (const std::uint32_t group : mesh.triangleGroup)
    if (group >= mesh.groupNames.size())
      fail("a triangle is in group " + std::to_string(group) + ", which has no name");
}

MeshReport checkMesh(const Mesh& mesh, const RunContext& ctx) {
  requireValid(mesh);
  constexpr std::uint64_t kBytesPerTriangle = 12 + 3 * 8; // welded triangle, three edge keys
  constexpr std::uint64_t kBytesPerVertex = 4 + 2 * 8;    // number, two bucket bounds
  ctx.requireMemory(PositionWelder::bytesFor(mesh.positions.size()) + mesh.positions.size() * kBytesPerVertex +
                        mesh.triangles.size() * kBytesPerTriangle,
                    "checking the mesh");
  MeshReport report;
  report.vertices = mesh.positions.size();
  report.triangles = mesh.triangles.size();
  report.bounds = bounds(mesh);
  const Welded welded = weld(mesh);
  ctx.throwIfCancelled();
  countEdges(welded, report);
  ctx.throwIfCancelled();
  countDuplicates(welded, report);
  countComponents(welded, report);
  measure(mesh, welded, report);
  return report;
}

} // namespace volcaustic
