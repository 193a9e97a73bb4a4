#include "volume/voxelise_shape.h"

#include "core/parallel.h"
#include "core/simd_clones.h"
#include "shapes/program.h"
#include "volcaustic/error.h"
#include "volume/brick_collector.h"
#include "volume/brick_range.h"

#include <algorithm>
#include <array>
#include <vector>

namespace volcaustic {

namespace {

/// Bricks, or voxels of a brick, from `first` on.
struct Cells {
  Vec3i first, size;
  [[nodiscard]] std::int64_t count() const { return std::int64_t{size[0]} * size[1] * size[2]; }
};

/// Halves along the longest side.
std::array<Cells, 2> halves(const Cells& cells) {
  const auto axis = std::max_element(cells.size.begin(), cells.size.end()) - cells.size.begin();
  std::array<Cells, 2> both{cells, cells};
  both[0].size[axis] = cells.size[axis] / 2;
  both[1].size[axis] -= both[0].size[axis];
  both[1].first[axis] += both[0].size[axis];
  return both;
}

VOLCAUSTIC_SIMD_CLONES void placeSamples(const double* __restrict offsets, double corner, int count,
                                         double* __restrict p) {
  for (int i = 0; i < count; ++i) p[i] = corner + offsets[i];
}
/// Sum of the parts of sub-voxels that are inside: of one that the surface crosses, as a plane does that faces an axis,
/// at the value's distance from the middle.
VOLCAUSTIC_SIMD_CLONES double sumInside(const double* values, double subVoxels, int count) {
  double inside = 0;
  for (int i = 0; i < count; ++i) inside += std::min(std::max(.5 + values[i] * subVoxels, 0.0), 1.0);
  return inside;
}

/// Fills a patch, from all bricks at once down to samples; each step keeps of the shape what matters in its half.
class ShapeSampler {
public:
  ShapeSampler(const SubLattice& lattice, CoveragePatch& patch, const RunContext& ctx)
      : mLattice(lattice)
      , mPatch(patch)
      , mContext(ctx)
      , mVarying(ctx)
      , mWorkers(threadCount(ctx))
      , mOffsets(sampleOffsets()) {}

  void run(const ShapeProgram& program) {
    // Some hundred pieces, so that threads find work: halving by the first of them costs little.
    std::vector<Cells> pieces{{{0, 0, 0}, mPatch.coverage.brickDims()}};
    for (std::size_t i = 0; i < pieces.size() && pieces.size() < kPieces; ++i) {
      if (pieces[i].count() < kSmallPiece) continue;
      const auto [a, b] = halves(pieces[i]);
      pieces.push_back(a);
      pieces[i--] = b;
    }
    parallelFor(
        static_cast<std::int64_t>(pieces.size()), 1, mContext,
        [&](std::int64_t begin, std::int64_t end, int slot) {
          for (std::int64_t i = begin; i < end; ++i) coverBricks(pieces[i], program, 0, slot);
        },
        "voxelise");
    mVarying.moveInto(mPatch.coverage, "voxelising a shape", mContext);
  }

private:
  static constexpr std::size_t kPieces = 512;
  static constexpr std::int64_t kSmallPiece = 64;
  /// Voxels along the edge of what is sampled as a whole.
  static constexpr int kSampledEdge = 2;

  struct Worker {
    ShapeScratch scratch;
    std::array<ShapeProgram, 64> programs; // one for each level of halving
    BatchNumbers x, y, z, values;
  };

  /// World box of cells of `edge` samples, its samples included.
  [[nodiscard]] Box boxOf(const Cells& cells, int edge) const {
    Box box;
    for (int a = 0; a < 3; ++a) {
      box.min[a] = mLattice.corner[a] + (mLattice.first[a] + double(cells.first[a]) * edge) / mLattice.scale;
      box.max[a] =
          mLattice.corner[a] + (mLattice.first[a] + double(cells.first[a] + cells.size[a]) * edge) / mLattice.scale;
      // Samples lie half a sub-voxel within; this is for roundings.
      const double slack = 1e-15 * std::max(std::abs(box.min[a]), std::abs(box.max[a]));
      box.min[a] -= slack;
      box.max[a] += slack;
    }
    return box;
  }

  /// Beyond half a sub-voxel from the surface sub-voxels are whole.
  [[nodiscard]] bool isInside(const Interval& bound) const { return bound.low * mLattice.scale >= .5; }
  [[nodiscard]] bool isOutside(const Interval& bound) const { return bound.high * mLattice.scale <= -.5; }

  void coverBricks(const Cells& bricks, const ShapeProgram& program, std::size_t level, int slot) {
    mContext.throwIfCancelled(); // a piece of a large shape takes seconds
    Worker& worker = mWorkers[slot];
    ShapeProgram& here = worker.programs[level];
    const Interval bound = program.prune(boxOf(bricks, mLattice.brickSamples()), here, worker.scratch);
    if (isOutside(bound)) return;
    if (isInside(bound)) {
      fill(bricks);
    } else if (bricks.count() == 1) {
      BrickGrid<float>& coverage = mPatch.coverage;
      const std::int64_t brick = coverage.brickIndex(bricks.first);
      std::array<float, kBrickVoxels> voxels{};
      const Vec3i& at = bricks.first;
      coverVoxels({{at[0] * kBrickSize, at[1] * kBrickSize, at[2] * kBrickSize}, {kBrickSize, kBrickSize, kBrickSize}},
                  here, level + 1, worker, voxels);
      if (std::all_of(voxels.begin(), voxels.end(), [&](float v) { return v == voxels[0]; }))
        coverage.setConstant(brick, voxels[0]);
      else
        std::copy(voxels.begin(), voxels.end(), mVarying.add(slot, brick).begin());
    } else {
      for (const Cells& half : halves(bricks)) coverBricks(half, here, level + 1, slot);
    }
  }

  void fill(const Cells& bricks) {
    for (int x = 0; x < bricks.size[0]; ++x)
      for (int y = 0; y < bricks.size[1]; ++y)
        for (int z = 0; z < bricks.size[2]; ++z)
          mPatch.coverage.setConstant(
              mPatch.coverage.brickIndex({bricks.first[0] + x, bricks.first[1] + y, bricks.first[2] + z}), 1);
  }

  using BrickVoxels = std::array<float, kBrickVoxels>;

  void coverVoxels(const Cells& voxels, const ShapeProgram& program, std::size_t level, Worker& worker,
                   BrickVoxels& coverage) {
    ShapeProgram& here = worker.programs[level];
    const Interval bound = program.prune(boxOf(voxels, 1 << mLattice.log2), here, worker.scratch);
    if (isOutside(bound)) return;
    if (isInside(bound))
      forEachVoxel(voxels, [&](int x, int y, int z) { coverage[brickOffset(x, y, z)] = 1; });
    else if (voxels.size[0] <= kSampledEdge)
      sampleVoxels(voxels, here, worker, coverage);
    else
      for (int i = 0; i < 8; ++i) {
        const int half = voxels.size[0] / 2;
        const Vec3i& at = voxels.first;
        coverVoxels(
            {{at[0] + (i & 1) * half, at[1] + (i >> 1 & 1) * half, at[2] + (i >> 2) * half}, {half, half, half}}, here,
            level + 1, worker, coverage);
      }
  }

  template <class Body>
  static void forEachVoxel(const Cells& voxels, const Body& body) {
    for (int x = 0; x < voxels.size[0]; ++x)
      for (int y = 0; y < voxels.size[1]; ++y)
        for (int z = 0; z < voxels.size[2]; ++z) body(voxels.first[0] + x, voxels.first[1] + y, voxels.first[2] + z);
  }

  /// All samples of a cube of kSampledEdge^3 voxels, voxel after voxel.
  void sampleVoxels(const Cells& voxels, const ShapeProgram& program, Worker& worker, BrickVoxels& coverage) const {
    Vec3d corner;
    for (int a = 0; a < 3; ++a)
      corner[a] =
          mLattice.corner[a] + (mLattice.first[a] + double(voxels.first[a]) * (1 << mLattice.log2)) / mLattice.scale;
    const int shift = 3 * mLattice.log2, total = static_cast<int>(mOffsets[0].size());
    std::array<double, kSampledEdge * kSampledEdge * kSampledEdge> inside{};
    for (int begin = 0; begin < total; begin += kShapeBatch) {
      const int count = std::min(total - begin, kShapeBatch), run = std::min(1 << shift, kShapeBatch);
      placeSamples(mOffsets[0].data() + begin, corner[0], count, worker.x.data());
      placeSamples(mOffsets[1].data() + begin, corner[1], count, worker.y.data());
      placeSamples(mOffsets[2].data() + begin, corner[2], count, worker.z.data());
      program.values({worker.x.data(), worker.y.data(), worker.z.data(), count}, worker.values.data(), worker.scratch);
      for (int i = 0; i < count; i += run)
        inside[(begin + i) >> shift] += sumInside(worker.values.data() + i, mLattice.scale, run);
    }
    int voxel = 0;
    forEachVoxel(voxels, [&](int x, int y, int z) {
      coverage[brickOffset(x, y, z)] = static_cast<float>(inside[voxel++] / (1 << shift));
    });
  }

  /// Of the samples of a cube of kSampledEdge^3 voxels from its corner, in world units, along each axis.
  [[nodiscard]] std::array<std::vector<double>, 3> sampleOffsets() const {
    const int s = 1 << mLattice.log2;
    std::array<std::vector<double>, 3> offsets;
    forEachVoxel({{0, 0, 0}, {kSampledEdge, kSampledEdge, kSampledEdge}}, [&](int x, int y, int z) {
      for (int i = 0; i < s; ++i)
        for (int j = 0; j < s; ++j)
          for (int k = 0; k < s; ++k) {
            const Vec3d at{x * s + i + .5, y * s + j + .5, z * s + k + .5};
            for (int a = 0; a < 3; ++a) offsets[a].push_back(at[a] / mLattice.scale);
          }
    });
    return offsets;
  }

  const SubLattice& mLattice;
  CoveragePatch& mPatch;
  const RunContext& mContext;
  BrickCollector<float> mVarying;
  std::vector<Worker> mWorkers;
  const std::array<std::vector<double>, 3> mOffsets;
};

} // namespace

CoveragePatch voxeliseShape(const Body& body, const Domain& domain, int supersample, const RunContext& ctx) {
  const std::string place = body.name.empty() ? "shape" : body.name;
  CoveragePatch patch;
  try {
    const ShapeField field(body.shape);
    const BrickRange range = bricksMet(field.bounds(), 1, domain); // sub-voxels beside the surface count in part
    if (range.empty()) return patch;
    patch.firstBrick = range.first;
    const SubLattice lattice = latticeOf(range, domain, supersample);
    Vec3i dims;
    for (int a = 0; a < 3; ++a) dims[a] = lattice.size[a] >> lattice.log2;
    ctx.requireMemory(std::uint64_t(dims[0]) * dims[1] * dims[2] / kBrickVoxels * 10, "voxelising at this resolution");
    patch.coverage = BrickGrid<float>(dims, 0.0f);
    ShapeSampler(lattice, patch, ctx).run(ShapeProgram(body.shape));
  } catch (const Error& error) { // which knows no body
    throw Error(error.kind(), place + ": " + error.what());
  }
  if (patch.coverage.occupied().empty())
    ctx.warn(place + ": nothing of the domain is inside the shape; it lies outside, or its parts leave nothing");
  return patch;
}

} // namespace volcaustic
