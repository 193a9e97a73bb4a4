#include "core/parallel.h"
#include "deform/box_tree.h"
#include "deform/triangle_pair.h"
#include "mesh/validate.h"
#include "mesh/weld.h"
#include "volcaustic/deform.h"

#include <algorithm>
#include <limits>

namespace volcaustic {

namespace {

constexpr std::int64_t kGrain = 256;
constexpr std::uint64_t kBytesForTriangle = 400; // bound of boxes, tree and welded corners

/// Triangles that have an area; numbers are those of the mesh.
struct Faces {
  std::vector<Vec3d> points;
  std::vector<TriangleCorners> corners;
  std::vector<std::uint32_t> number;
  std::vector<Box> boxes;
};

Box boxOf(const TriangleCorners& t, const std::vector<Vec3d>& points) {
  Box box{points[t[0]], points[t[0]]};
  for (const std::uint32_t p : {t[1], t[2]})
    for (std::size_t k = 0; k < 3; ++k) {
      box.min[k] = std::min(box.min[k], points[p][k]);
      box.max[k] = std::max(box.max[k], points[p][k]);
    }
  return box;
}

Faces facesOf(const Mesh& mesh) {
  Faces faces;
  PositionWelder welder(mesh.positions.size());
  std::vector<std::uint32_t> pointOf;
  pointOf.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) pointOf.push_back(welder.add(p));
  faces.points = welder.takePositions();
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const TriangleCorners corners{pointOf[t[0]], pointOf[t[1]], pointOf[t[2]]};
    if (isFlat(corners, faces.points)) continue;
    faces.corners.push_back(corners);
    faces.number.push_back(i);
    faces.boxes.push_back(boxOf(corners, faces.points));
  }
  return faces;
}

/// What one piece of the triangles found.
struct Found {
  std::uint64_t pairs = 0;
  std::vector<std::array<std::uint32_t, 2>> first;
  Vec3d min{kFar, kFar, kFar}, max{-kFar, -kFar, -kFar};

  static constexpr double kFar = std::numeric_limits<double>::infinity();

  void include(const Box& box) {
    for (std::size_t k = 0; k < 3; ++k) {
      min[k] = std::min(min[k], box.min[k]);
      max[k] = std::max(max[k], box.max[k]);
    }
  }
};

/// Pairs of which face `i` is the first. `partners` is storage.
void findPartners(const Faces& faces, const BoxTree& tree, std::uint32_t i, std::vector<std::uint32_t>& partners,
                  Found& found) {
  partners.clear();
  tree.forTouching(faces.boxes[i], i, [&](std::uint32_t j) {
    if (crossEachOther(faces.corners[i], faces.corners[j], faces.points)) partners.push_back(j);
  });
  if (partners.empty()) return;
  found.pairs += partners.size();
  found.include(faces.boxes[i]);
  for (const std::uint32_t j : partners) found.include(faces.boxes[j]);
  if (found.first.size() == SelfIntersections::kListed) return;
  std::sort(partners.begin(), partners.end());
  for (const std::uint32_t j : partners)
    if (found.first.size() < SelfIntersections::kListed) found.first.push_back({faces.number[i], faces.number[j]});
}

} // namespace

SelfIntersections findSelfIntersections(const Mesh& mesh, const RunContext& ctx) {
  requireValid(mesh);
  ctx.requireMemory((mesh.triangles.size() + mesh.positions.size()) * kBytesForTriangle,
                    "looking for self-intersections");
  const Faces faces = facesOf(mesh);
  const BoxTree tree(faces.boxes);
  const auto count = static_cast<std::int64_t>(faces.corners.size());
  std::vector<Found> pieces(static_cast<std::size_t>((count + kGrain - 1) / kGrain));
  parallelFor(
      count, kGrain, ctx,
      [&](std::int64_t begin, std::int64_t end, int) {
        std::vector<std::uint32_t> partners;
        for (std::int64_t i = begin; i < end; ++i) {
          ctx.throwIfCancelled();
          findPartners(faces, tree, static_cast<std::uint32_t>(i), partners,
                       pieces[static_cast<std::size_t>(begin / kGrain)]);
        }
      },
      "self-intersections");

  SelfIntersections result;
  Found all;
  for (const Found& piece : pieces) {
    result.pairs += piece.pairs;
    if (piece.pairs > 0) all.include({piece.min, piece.max});
    for (const auto& pair : piece.first)
      if (result.examples.size() < SelfIntersections::kListed) result.examples.push_back(pair);
  }
  if (result.any()) result.bounds = {all.min, all.max};
  return result;
}

} // namespace volcaustic
