#include "volume/topology_parts.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <string>

namespace volcaustic {

namespace {

struct Shell {
  std::vector<std::uint32_t> triangles;
  double signedVolume = 0;
  Box bounds;
};

std::vector<Shell> shellsOf(const WeldedSurface& s, const FaceShells& faces) {
  std::vector<Shell> shells(faces.count);
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t) {
    Shell& shell = shells[faces.shellOf[s.meshFace[t]]];
    const Vec3d &a = s.positions[s.triangles[t][0]], &b = s.positions[s.triangles[t][1]],
                &c = s.positions[s.triangles[t][2]];
    if (shell.triangles.empty()) shell.bounds = {a, a};
    shell.triangles.push_back(t);
    const Vec3d& origin = s.positions[s.triangles[shell.triangles[0]][0]];
    shell.signedVolume += dot(difference(a, origin), cross(difference(b, a), difference(c, a))) / 6;
    for (const Vec3d* p : {&a, &b, &c})
      for (int k = 0; k < 3; ++k) {
        shell.bounds.min[k] = std::min(shell.bounds.min[k], (*p)[k]);
        shell.bounds.max[k] = std::max(shell.bounds.max[k], (*p)[k]);
      }
  }
  return shells;
}

bool contains(const Box& box, const Vec3d& p) {
  for (int k = 0; k < 3; ++k)
    if (p[k] < box.min[k] || p[k] > box.max[k]) return false;
  return true;
}

/// The smallest shell facing outwards around a shell that faces inwards.
std::size_t bodyAround(const WeldedSurface& s, const std::vector<Shell>& shells, std::size_t cavity) {
  const Vec3d& p = s.positions[s.triangles[shells[cavity].triangles[0]][0]];
  std::size_t body = shells.size();
  for (std::size_t i = 0; i < shells.size(); ++i)
    if (shells[i].signedVolume >= 0 && contains(shells[i].bounds, p) &&
        (body == shells.size() || shells[i].signedVolume < shells[body].signedVolume) &&
        windingNumber(s, shells[i].triangles, p) > 0)
      body = i;
  if (body == shells.size())
    throw Error(ErrorKind::Input, "mesh: part " + std::to_string(cavity) +
                                      " faces inwards, so its topology cannot be controlled; reverse its triangles");
  return body;
}

} // namespace

WeldedSurface weldedSurface(const Mesh& mesh, const RunContext& ctx) {
  const WeldedMesh welded = weld(mesh);
  MeshReport report;
  const FaceShells faces = analyseEdges(welded, report);
  if (!report.closedAndConsistent())
    throw Error(ErrorKind::Input, "mesh: has " + describeDefects(report) +
                                      ", so its topology cannot be controlled; close it, or choose topology free");
  ctx.throwIfCancelled();
  WeldedSurface s;
  s.positions.resize(welded.vertexCount);
  s.meshVertex.resize(welded.vertexCount);
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    if (hasRepeatedCorner(welded.triangles[f])) continue;
    for (int k = 0; k < 3; ++k) {
      s.positions[welded.triangles[f][k]] = mesh.positions[mesh.triangles[f][k]];
      s.meshVertex[welded.triangles[f][k]] = mesh.triangles[f][k];
    }
    s.triangles.push_back(welded.triangles[f]);
    s.meshFace.push_back(f);
  }
  const std::vector<Shell> shells = shellsOf(s, faces);
  s.shellCount = faces.count;
  std::vector<std::uint32_t> partOf(shells.size());
  for (std::size_t i = 0; i < shells.size(); ++i)
    if (shells[i].signedVolume >= 0) partOf[i] = s.partCount++;
  for (std::size_t i = 0; i < shells.size(); ++i)
    if (shells[i].signedVolume < 0) partOf[i] = partOf[bodyAround(s, shells, i)];
  for (const std::uint32_t f : s.meshFace) s.partOf.push_back(partOf[faces.shellOf[f]]);
  return s;
}

// The solid angle of each triangle by van Oosterom and Strackee, 1983.
int windingNumber(const WeldedSurface& s, std::span<const std::uint32_t> triangles, const Vec3d& p) {
  double sum = 0;
  for (const std::uint32_t t : triangles) {
    const Vec3d a = difference(s.positions[s.triangles[t][0]], p), b = difference(s.positions[s.triangles[t][1]], p),
                c = difference(s.positions[s.triangles[t][2]], p);
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return static_cast<int>(std::lround(sum / (2 * std::numbers::pi)));
}

namespace {

std::vector<TriangleCorners> cornersOf(const WeldedSurface& surface, const std::vector<std::uint32_t>& faces) {
  std::vector<TriangleCorners> corners;
  corners.reserve(faces.size());
  for (const std::uint32_t f : faces) corners.push_back(surface.triangles[f]);
  return corners;
}

} // namespace

SurfacePart::SurfacePart(const WeldedSurface& surface, std::vector<std::uint32_t> faces, double voxelSize,
                         const RunContext& ctx)
    : mVoxelSize(voxelSize)
    , mFaces(std::move(faces))
    , mTree(std::make_unique<TriangleTree>(surface.positions, cornersOf(surface, mFaces)))
    , mColumns(surface.positions, mTree->triangles(), voxelSize, ctx) {
  const auto& [first, size] = std::pair(mColumns.first(), mColumns.size());
  for (int j = first[1]; j < first[1] + size[1] && !mRunsThroughItself; ++j)
    for (int i = first[0]; i < first[0] + size[0]; ++i) {
      int winding = 0;
      for (const WindingColumns::Crossing& c : mColumns.column(i, j)) mRunsThroughItself |= (winding += c.turn) > 1;
    }
}

bool SurfacePart::isBuried(std::uint32_t triangle, const Vec3d& point) const {
  constexpr double kOutwards = 1.2; // voxels: clear of the triangle itself whatever the rounding to a node
  const Vec3d n = mTree->normal(triangle);
  const double length = std::sqrt(dot(n, n));
  if (length == 0) return false;
  Vec3i node;
  for (int k = 0; k < 3; ++k)
    node[k] = static_cast<int>(std::lround(point[k] / mVoxelSize + kOutwards * n[k] / length));
  return mColumns.at(node[0], node[1], node[2]) > 0;
}

ClosestPoint SurfacePart::closest(const Vec3d& p, double within, std::uint32_t hint) const {
  if (!mRunsThroughItself) return mTree->closest(p, within, hint);
  return mTree->closestIf(p, within, hint, [&](std::uint32_t t, const Vec3d& c) { return !isBuried(t, c); });
}

NodeDistance SurfacePart::distance(const Vec3d& p, const Vec3i& n, double limit, std::uint32_t& hint) const {
  constexpr double kCrease = 1.8; // voxels: reaches the nodes of every cell that the crease passes through
  const bool inside = mColumns.at(n[0], n[1], n[2]) > 0;
  const ClosestPoint c = closest(p, limit, hint);
  if (c.found()) hint = c.triangle;
  NodeDistance d;
  d.distance = static_cast<float>(inside ? -std::min(c.distance, limit) : std::min(c.distance, limit));
  if (!c.found()) return d;
  Vec3d gradient = difference(p, c.point);
  if (inside) gradient = difference({0, 0, 0}, gradient);
  if (c.distance < 1e-3 * mVoxelSize) gradient = mTree->normal(c.triangle);
  const double length = std::sqrt(dot(gradient, gradient));
  for (int k = 0; k < 3; ++k) d.gradient[k] = length > 0 ? static_cast<float>(gradient[k] / length) : 0;
  if (mRunsThroughItself && c.distance < kCrease * mVoxelSize)
    d.atCrease = mTree
                     ->closestIf(p, kCrease * mVoxelSize, ClosestPoint::kNone,
                                 [&](std::uint32_t t, const Vec3d& q) { return isBuried(t, q); })
                     .found();
  return d;
}

} // namespace volcaustic
