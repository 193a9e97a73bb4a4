#include "volume/topology_region.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// Pieces of large triangles are looked at each by itself, down to this many voxels.
constexpr double kPiece = 3;

Box roomOf(const SurfaceParts& parts, double pad) {
  Box room = parts.front()->tree().bounds();
  for (const auto& part : parts)
    for (int k = 0; k < 3; ++k) {
      room.min[k] = std::min(room.min[k], part->tree().bounds().min[k]);
      room.max[k] = std::max(room.max[k], part->tree().bounds().max[k]);
    }
  for (int k = 0; k < 3; ++k) {
    room.min[k] -= pad;
    room.max[k] += pad;
  }
  return room;
}

double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }
Vec3d middle(const Vec3d& a, const Vec3d& b) { return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2}; }

/// Calls visit(a, b, c) for the pieces of a triangle, but not below a piece that near(centre, radius) does not hold
/// for.
template <class Near, class Visit>
void forPieces(const Vec3d& a, const Vec3d& b, const Vec3d& c, double size, const Near& near, const Visit& visit) {
  const Vec3d centre{(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3, (a[2] + b[2] + c[2]) / 3};
  const double radius =
      std::max({length(difference(a, centre)), length(difference(b, centre)), length(difference(c, centre))});
  if (!near(centre, radius)) return;
  if (radius <= size) {
    visit(a, b, c);
    return;
  }
  const double ab = length(difference(a, b)), bc = length(difference(b, c)), ca = length(difference(c, a));
  const bool first = ab >= bc && ab >= ca, second = !first && bc >= ca;
  const Vec3d &p = first ? a : second ? b : c, &q = first ? b : second ? c : a, &r = first ? c : second ? a : b;
  const Vec3d m = middle(p, q);
  forPieces(p, m, r, size, near, visit);
  forPieces(m, q, r, size, near, visit);
}

} // namespace

bool areNear(const Box& a, const Box& b, double reach) {
  for (int k = 0; k < 3; ++k)
    if (a.min[k] - b.max[k] > reach || b.min[k] - a.max[k] > reach) return false;
  return true;
}

RegionMarker::RegionMarker(const SurfaceParts& parts, double voxelSize, double pad, const RunContext& ctx)
    : mParts(parts), mVoxelSize(voxelSize), mPad(pad), mCtx(ctx), mGrid(roomOf(parts, pad), voxelSize, ctx) {}

void RegionMarker::markBox(const Vec3d& low, const Vec3d& high) {
  Box box{low, high};
  for (int k = 0; k < 3; ++k) {
    box.min[k] -= mPad;
    box.max[k] += mPad;
  }
  mGrid.mark(box);
}

template <class Wanted>
void RegionMarker::markTriangles(std::size_t part, Wanted wanted) {
  const TriangleTree& tree = mParts[part]->tree();
  for (std::uint32_t t = 0; t < tree.triangles().size(); ++t) {
    if (t % 4096 == 0) mCtx.throwIfCancelled();
    const auto near = [&](const Vec3d& centre, double radius) { return wanted(t, centre, radius); };
    forPieces(tree.corner(t, 0), tree.corner(t, 1), tree.corner(t, 2), kPiece * mVoxelSize, near,
              [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
                Vec3d low, high;
                for (int k = 0; k < 3; ++k) {
                  low[k] = std::min({a[k], b[k], c[k]});
                  high[k] = std::max({a[k], b[k], c[k]});
                }
                markBox(low, high);
              });
  }
}

void RegionMarker::markNear(std::size_t part, std::size_t other, double reach) {
  const TriangleTree& tree = mParts[other]->tree();
  markTriangles(part, [&](std::uint32_t, const Vec3d& centre, double radius) {
    return areNear({centre, centre}, tree.bounds(), reach + radius) && tree.closest(centre, reach + radius).found();
  });
}

void RegionMarker::markSurface(std::size_t part) {
  markTriangles(part, [](std::uint32_t, const Vec3d&, double) { return true; });
}

void RegionMarker::markThin(std::size_t part, double radius) {
  const TriangleTree& tree = mParts[part]->tree();
  markTriangles(part, [&](std::uint32_t t, const Vec3d& centre, double size) {
    if (size > kPiece * mVoxelSize) return true;
    const Vec3d n = tree.normal(t);
    const double scale = length(n) > 0 ? -radius / length(n) : 0;
    const Vec3d deep{centre[0] + scale * n[0], centre[1] + scale * n[1], centre[2] + scale * n[2]};
    constexpr double kFits = 0.95; // of the radius, which facets of a curved surface take away from
    return tree.closest(deep, kFits * radius).found();
  });
}

void RegionMarker::markOverlap(std::size_t part, std::size_t other) {
  const WindingColumns &a = mParts[part]->columns(), &b = mParts[other]->columns();
  for (int j = a.first()[1]; j < a.first()[1] + a.size()[1]; ++j)
    for (int i = a.first()[0]; i < a.first()[0] + a.size()[0]; ++i) {
      const auto first = a.column(i, j), second = b.column(i, j);
      if (first.empty() || second.empty()) continue;
      int inFirst = 0, inSecond = 0;
      double from = 0;
      for (std::size_t n = 0, m = 0; n < first.size() && m < second.size();) {
        const bool wasInBoth = inFirst > 0 && inSecond > 0;
        const double z = std::min(first[n].z, second[m].z);
        if (first[n].z <= second[m].z)
          inFirst += first[n++].turn;
        else
          inSecond += second[m++].turn;
        const bool isInBoth = inFirst > 0 && inSecond > 0;
        if (isInBoth && !wasInBoth) from = z;
        if (wasInBoth && !isInBoth)
          markBox({mVoxelSize * i, mVoxelSize * j, mVoxelSize * from},
                  {mVoxelSize * i, mVoxelSize * j, mVoxelSize * z});
      }
    }
}

void RegionMarker::markSelfOverlap(std::size_t part) {
  if (!mParts[part]->runsThroughItself()) return;
  const WindingColumns& columns = mParts[part]->columns();
  for (int j = columns.first()[1]; j < columns.first()[1] + columns.size()[1]; ++j)
    for (int i = columns.first()[0]; i < columns.first()[0] + columns.size()[0]; ++i) {
      int winding = 0;
      for (const WindingColumns::Crossing& c : columns.column(i, j)) {
        const int before = winding;
        winding += c.turn;
        if ((before > 1) == (winding > 1)) continue;
        const Vec3d p{mVoxelSize * i, mVoxelSize * j, mVoxelSize * c.z};
        markBox(p, p);
      }
    }
}

BlockGrid RegionMarker::take() {
  mGrid.number();
  return std::move(mGrid);
}

} // namespace volcaustic
