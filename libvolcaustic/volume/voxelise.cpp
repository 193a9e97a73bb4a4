#include "volume/voxelise.h"

#include "core/simd_clones.h"
#include "volcaustic/error.h"
#include "volume/brick_range.h"
#include "volume/columns.h"
#include "volume/voxelise_shape.h"
#include "volume/winding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <vector>

namespace volcaustic {

namespace {

/// Larger coordinates are the mark of a broken file: 1e15 metres is a tenth of a light year.
constexpr double kAbsurdCoordinate = 1e15;

std::string placeOf(const Body& body) { return body.name.empty() ? "mesh" : body.name; }

/// Of all vertices, used or not; not finite where one of them is not.
VOLCAUSTIC_SIMD_CLONES Box boundsOfVertices(const double* p, std::size_t count) {
  // Twelve numbers at a time: whole points, and whole registers of any width.
  std::array<double, 12> low, high, odd{};
  for (int i = 0; i < 12; ++i) low[i] = high[i] = p[i % 3];
  const auto add = [&](double x, int i) {
    low[i] = x < low[i] ? x : low[i];
    high[i] = x > high[i] ? x : high[i];
    odd[i] += x - x; // of what is not finite, not a number
  };
  std::size_t at = 0;
  for (; at + 12 <= 3 * count; at += 12)
    for (int i = 0; i < 12; ++i) add(p[at + i], i);
  for (int i = 0; at + i < 3 * count; ++i) add(p[at + i], i);
  Box box;
  for (int a = 0; a < 3; ++a) {
    box.min[a] = std::min({low[a], low[a + 3], low[a + 6], low[a + 9]});
    box.max[a] = std::max({high[a], high[a + 3], high[a + 6], high[a + 9]});
    for (int i = a; i < 12; i += 3) box.max[a] += odd[i];
  }
  return box;
}

VOLCAUSTIC_SIMD_CLONES std::uint32_t highestIndex(const std::uint32_t* indices, std::size_t count) {
  std::uint32_t highest = 0;
  for (std::size_t i = 0; i < count; ++i) highest = std::max(highest, indices[i]);
  return highest;
}

/// Vertex by vertex of the triangles. \throws Error(Input) naming the one that is wrong.
Box boundsOfCorners(const Body& body) {
  const Mesh& mesh = *body.mesh;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v >= mesh.positions.size())
        throw Error(ErrorKind::Input, placeOf(body) + ": triangle " + std::to_string(t) + " names vertex " +
                                          std::to_string(v) + " of " + std::to_string(mesh.positions.size()));
      for (int a = 0; a < 3; ++a) {
        const double c = mesh.positions[v][a];
        if (!(std::abs(c) <= kAbsurdCoordinate)) {
          std::ostringstream text;
          text << placeOf(body) << ": vertex " << v << " has coordinate " << c
               << ", not finite or beyond 1e15; check the file and its units";
          throw Error(ErrorKind::Input, text.str());
        }
        box.min[a] = std::min(box.min[a], c);
        box.max[a] = std::max(box.max[a], c);
      }
    }
  return box;
}

void reportOpenMesh(const Body& body, FillRule fill, const RunContext& ctx) {
  if (fill == FillRule::Winding) return;
  const std::string defects = describeDefects(checkMesh(*body.mesh, ctx));
  if (fill == FillRule::Exact)
    throw Error(ErrorKind::Input, placeOf(body) + ": the mesh is not closed (" + defects +
                                      "), which the exact fill needs; repair it or use the fill 'winding' or 'auto'");
  ctx.warn(placeOf(body) + ": the mesh is not closed (" + defects +
           "); inside is told from outside by the generalised winding number");
}

double areaInVoxels(const LoopCaps& caps, const Domain& domain) {
  double area = 0;
  for (const auto& t : caps.triangles) {
    const Vec3d &a = caps.positions[t[0]], &b = caps.positions[t[1]], &c = caps.positions[t[2]];
    const Vec3d u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    area += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return area / (domain.voxelSize * domain.voxelSize);
}

/// Whether the box is so near to the domain that its points snap exactly.
bool inReach(const Box& box, const Domain& domain, int supersample) {
  const double limit = kMaxSubVoxels * domain.voxelSize / supersample;
  for (int a = 0; a < 3; ++a) {
    const double far = std::max(std::abs(box.min[a] - domain.minCorner[a]), std::abs(box.max[a] - domain.minCorner[a]));
    if (!std::isfinite(box.min[a]) || !std::isfinite(box.max[a])) return false;
    if (!(far < limit) || std::abs(box.min[a]) > kAbsurdCoordinate || std::abs(box.max[a]) > kAbsurdCoordinate)
      return false;
  }
  return true;
}

/// A box that the mesh is in. \throws Error(Input) for what voxeliseBody() does not take.
Box checkedBounds(const Body& body, const Domain& domain, int supersample) {
  if (!body.mesh || body.mesh->empty())
    throw Error(ErrorKind::Input, placeOf(body) + ": the mesh holds no triangle; check the file");
  const Mesh& mesh = *body.mesh;
  if (highestIndex(mesh.triangles[0].data(), 3 * mesh.triangles.size()) < mesh.positions.size())
    if (const Box box = boundsOfVertices(mesh.positions[0].data(), mesh.positions.size());
        inReach(box, domain, supersample))
      return box;
  const Box box = boundsOfCorners(body); // which leaves out vertices of no triangle
  if (!inReach(box, domain, supersample))
    throw Error(ErrorKind::Input, placeOf(body) + ": the mesh reaches 2^40 sub-voxels and more from the domain; check "
                                                  "its units, or take larger voxels");
  return box;
}

} // namespace

SampledBody::SampledBody(const Body& body, const Domain& domain, int supersample, FillRule fill, const RunContext& ctx)
    : mPlace(placeOf(body)) {
  const Box box = checkedBounds(body, domain, supersample);
  const Mesh& mesh = *body.mesh;
  const std::vector<BoundaryEdge> chain = boundaryChain(mesh, ctx);
  mClosed = chain.empty();
  if (!mClosed) reportOpenMesh(body, fill, ctx);
  mCaps = capLoops(mesh, chain);

  // Outside its box a closed mesh winds around nothing; at a distance d caps of area A do by less than A / (4 pi d^2).
  const double margin = mClosed ? 0 : std::sqrt(areaInVoxels(mCaps, domain) / 6.28) + 1;
  const BrickRange range = bricksMet(box, margin, domain);
  if (range.empty()) return;
  mFirstBrick = range.first;
  mLattice = latticeOf(range, domain, supersample);
  mPoints = 3 * mesh.positions.size();
  mTriangles = std::make_unique<const LatticeTriangles>(mesh, mCaps, mLattice, ctx);
}
SampledBody::~SampledBody() = default;

CountTask SampledBody::task() const {
  Vec3i bricks;
  for (int a = 0; a < 3; ++a) bricks[a] = mLattice.size[a] / mLattice.brickSamples();
  return {{mTriangles->points(), mPoints}, mTriangles->corners(), bricks, mLattice.log2};
}

CoveragePatch SampledBody::cover(const RunContext& ctx) const {
  CoveragePatch patch;
  patch.firstBrick = mFirstBrick;
  if (!reachesDomain()) return patch;
  Vec3i dims;
  for (int a = 0; a < 3; ++a) dims[a] = mLattice.size[a] >> mLattice.log2;
  const std::string what = mPlace + ": voxelising at this resolution";
  ctx.requireMemory(std::uint64_t(dims[0]) * dims[1] * dims[2] / kBrickVoxels * 10, what);
  patch.coverage = BrickGrid<float>(dims, 0.0f);
  std::unique_ptr<const CapOffsets> offsets;
  if (!mClosed) offsets = std::make_unique<CapOffsets>(mCaps, mLattice, ctx);
  coverColumns(*mTriangles, offsets.get(), mLattice, what, patch.coverage, ctx);
  if (patch.coverage.occupied().empty()) warnOfNothing(ctx);
  return patch;
}

void SampledBody::warnOfNothing(const RunContext& ctx) const {
  // Faces that come twice, once for each side, enclose nothing; nor does a body between the samples show.
  ctx.warn(mPlace + ": no sample of the domain is inside the mesh; it is thinner than a sub-voxel, lies outside, or "
                    "its faces cancel (each present once for each side)");
}

CoveragePatch voxeliseBody(const Body& body, const Domain& domain, int supersample, FillRule fill,
                           const RunContext& ctx) {
  if (!body.shape.empty()) return voxeliseShape(body, domain, supersample, ctx);
  return SampledBody(body, domain, supersample, fill, ctx).cover(ctx);
}

} // namespace volcaustic
