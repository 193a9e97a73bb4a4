#include "polygonise/faces.h"

#include "core/parallel.h"
#include "polygonise/points.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <limits>

namespace volcaustic {

namespace {

/// In cells: how much nearer to the surface a diagonal must be before angles no longer matter.
constexpr double kMuchNearer = .04;
/// Cosine of an angle under which triangles are not made where they can be avoided.
constexpr double kThinnest = .9997;

std::array<int, 3> orderOf(const Vec3i& c) { return {c[2], c[1], c[0]}; }

/// The greater of the two cosines that matter at a triangle's smallest angle: that of the least angle.
double leastAngleCosine(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = difference(b, a), bc = difference(c, b), ca = difference(a, c);
  const double lab = length(ab), lbc = length(bc), lca = length(ca);
  if (!(lab * lbc * lca > 0)) return 1;
  return std::max({-dot(ab, ca) / (lab * lca), -dot(ab, bc) / (lab * lbc), -dot(bc, ca) / (lbc * lca)});
}

} // namespace

QuadMesh::QuadMesh(std::span<const SurfaceBlock> blocks, std::span<const std::shared_ptr<const BlockSurface>> surfaces,
                   double cellSize, const RunContext& ctx)
    : mBlocks(blocks), mSurfaces(surfaces), mCellSize(cellSize), mFirstVertex{0}, mFirstQuad{0} {
  for (const auto& surface : surfaces) {
    mFirstVertex.push_back(mFirstVertex.back() + surface->positions.size());
    mFirstQuad.push_back(mFirstQuad.back() + surface->crossings.size());
  }
  if (mFirstVertex.back() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorKind::Input, "polygonise: more than 4 billion vertices; take larger cells");
  ctx.requireMemory(mFirstVertex.back() * sizeof(Vec3d) + mFirstQuad.back() * (sizeof(Quad) + 2 * sizeof(Quad)),
                    "triangles of a polygonised shape");
  positions.resize(mFirstVertex.back());
  mQuads.resize(mFirstQuad.back());
  parallelFor(static_cast<std::int64_t>(blocks.size()), 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) connectBlock(static_cast<std::size_t>(b));
  });
}

std::size_t QuadMesh::blockOfQuad(std::size_t q) const {
  return static_cast<std::size_t>(std::upper_bound(mFirstQuad.begin(), mFirstQuad.end(), q) - mFirstQuad.begin() - 1);
}

std::size_t QuadMesh::find(const Vec3i& coord) const {
  const auto found = std::lower_bound(mBlocks.begin(), mBlocks.end(), coord, [](const SurfaceBlock& b, const Vec3i& c) {
    return orderOf(b.coord) < orderOf(c);
  });
  return found != mBlocks.end() && found->coord == coord ? static_cast<std::size_t>(found - mBlocks.begin())
                                                         : mBlocks.size();
}

void QuadMesh::connectBlock(std::size_t b) {
  const BlockSurface& surface = *mSurfaces[b];
  std::copy(surface.positions.begin(), surface.positions.end(),
            positions.begin() + static_cast<std::ptrdiff_t>(mFirstVertex[b]));
  std::array<std::size_t, 8> neighbours{}; // towards lower coordinates, a bit for each axis
  for (int i = 0; i < 8 && !surface.crossings.empty(); ++i) {
    Vec3i coord = mBlocks[b].coord;
    for (int a = 0; a < 3; ++a) coord[a] -= i >> a & 1;
    neighbours[i] = i == 0 ? b : find(coord);
  }
  Quad* out = mQuads.data() + mFirstQuad[b];
  for (const Crossing& crossing : surface.crossings) {
    const Vec3i cell{crossing.cell % kBlockCells, crossing.cell / kBlockCells % kBlockCells,
                     crossing.cell / (kBlockCells * kBlockCells)};
    const int axisU = (crossing.axis + 1) % 3, axisV = (crossing.axis + 2) % 3;
    Quad quad;
    for (int k = 0; k < 4; ++k) {
      const int u = k == 0 || k == 3, v = k == 0 || k == 1; // where the edge is in the cell
      Vec3i at = cell;
      at[axisU] -= u;
      at[axisV] -= v;
      int neighbour = 0;
      for (int a = 0; a < 3; ++a)
        if (at[a] < 0) {
          at[a] += kBlockCells;
          neighbour |= 1 << a;
        }
      const std::size_t home = neighbours[neighbour];
      const std::uint16_t vertex = home == mBlocks.size() ? BlockSurface::kNone
                                                          : mSurfaces[home]->vertexAt(cellOfBlock(at[0], at[1], at[2]),
                                                                                      cellEdge(crossing.axis, u, v));
      if (vertex == BlockSurface::kNone)
        throw Error(ErrorKind::Internal, "polygonise: bounds of the shape do not hold its values");
      quad[crossing.outwards ? k : 3 - k] = static_cast<std::uint32_t>(mFirstVertex[home] + vertex);
    }
    *out++ = quad;
  }
}

std::array<std::array<std::uint32_t, 3>, 2> QuadMesh::triangles(const Quad& quad, const Crossing& crossing) const {
  const Vec3d &a = positions[quad[0]], &b = positions[quad[1]], &c = positions[quad[2]], &d = positions[quad[3]];
  const Vec3d normal{crossing.normal[0], crossing.normal[1], crossing.normal[2]};
  const double ac = std::abs(dot(normal, difference(between(a, c), crossing.position)));
  const double bd = std::abs(dot(normal, difference(between(b, d), crossing.position)));
  const double thinnestAc = std::max(leastAngleCosine(a, b, c), leastAngleCosine(a, c, d));
  const double thinnestBd = std::max(leastAngleCosine(a, b, d), leastAngleCosine(b, c, d));
  // Three corners on one edge of the shape would make a triangle of no area.
  const bool byDistance = std::abs(ac - bd) > kMuchNearer * mCellSize && std::max(thinnestAc, thinnestBd) < kThinnest;
  const bool alongAc = byDistance ? ac < bd : thinnestAc <= thinnestBd;
  if (alongAc) return {{{quad[0], quad[1], quad[2]}, {quad[0], quad[2], quad[3]}}};
  return {{{quad[0], quad[1], quad[3]}, {quad[1], quad[2], quad[3]}}};
}

} // namespace volcaustic
