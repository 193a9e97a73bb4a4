// The step field: for every voxel the largest aligned cube of 2^m voxels in which n and attenuation hardly change
// (Vyatkin and Dolgovesov, "Volume-oriented visualization of caustics ...", section 2), kept in a VDB tree whose nodes
// are the octree's cubes where the two agree (section 3). The pyramid of minima and maxima lives only while labels are
// made.

#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volume/grids.h"

#include <openvdb/tools/Prune.h>

#include <array>
#include <limits>

namespace volcaustic {

namespace {

constexpr int kTopLevel = 12; // 4096 voxels: the edge of OpenVDB's largest node

/// Minima and maxima of n and of the three attenuation channels over a cube.
struct Range {
  std::array<float, 4> low, high;

  static Range empty() {
    Range r;
    r.low.fill(std::numeric_limits<float>::max());
    r.high.fill(std::numeric_limits<float>::lowest());
    return r;
  }
  void add(float n, const Vec3f& a) {
    const std::array<float, 4> v{n, a[0], a[1], a[2]};
    for (int c = 0; c < 4; ++c) {
      low[c] = std::min(low[c], v[c]);
      high[c] = std::max(high[c], v[c]);
    }
  }
  void add(const Range& r) {
    for (int c = 0; c < 4; ++c) {
      low[c] = std::min(low[c], r.low[c]);
      high[c] = std::max(high[c], r.high[c]);
    }
  }
};

enum class Steps { Fine, Capped, Free };

class StepFieldBuilder {
public:
  StepFieldBuilder(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx)
      : mDomain(medium.domain())
      , mOptions(options)
      , mCtx(ctx)
      , mIndex(fromFloatGrid(*medium.grids().index, mDomain.dims, ctx))
      , mAttenuation(fromVec3Grid(*medium.grids().attenuation, mDomain.dims, ctx)) {}

  openvdb::Int32Grid::Ptr build() {
    buildPyramid();
    labelBricks();
    return assemble();
  }

private:
  struct Level {
    Vec3i dims;
    std::vector<Range> cubes;
    [[nodiscard]] const Range& at(int x, int y, int z) const {
      return cubes[(std::size_t(x) * dims[1] + y) * dims[2] + z];
    }
  };

  [[nodiscard]] Steps classify(const Range& r) const {
    for (int c = 1; c < 4; ++c)
      if ((r.high[c] - r.low[c]) * mDomain.voxelSize > mOptions.attenuationTolerance) return Steps::Fine;
    const float range = r.high[0] - r.low[0];
    if (range < mOptions.indexTolerance) return Steps::Free;
    return range < mOptions.indexTolerance2 ? Steps::Capped : Steps::Fine;
  }

  [[nodiscard]] static int label(int level, Steps steps) { return level + (steps == Steps::Capped ? kStepCapped : 0); }

  /// Calls visit for every voxel of the domain in the cube of edge `size` at `origin`.
  template <class Visit>
  void forVoxels(const Vec3i& origin, int size, const Visit& visit) const {
    const auto end = [&](int axis) { return std::min(origin[axis] + size, mDomain.dims[axis]); };
    for (int x = origin[0]; x < end(0); ++x)
      for (int y = origin[1]; y < end(1); ++y)
        for (int z = origin[2]; z < end(2); ++z) visit(x, y, z);
  }

  /// Over a cube and one voxel around it: what a lookup inside the cube can see.
  [[nodiscard]] Range rangeOf(const Vec3i& origin, int size) const {
    Range r = Range::empty();
    for (int x = origin[0] - 1; x <= origin[0] + size; ++x)
      for (int y = origin[1] - 1; y <= origin[1] + size; ++y)
        for (int z = origin[2] - 1; z <= origin[2] + size; ++z)
          r.add(mIndex.clamped(x, y, z), mAttenuation.clamped(x, y, z));
    return r;
  }

  [[nodiscard]] Range rangeOfBrick(std::int64_t b) const {
    const Vec3i c = mIndex.brickCoord(b);
    return rangeOf({c[0] * kBrickSize, c[1] * kBrickSize, c[2] * kBrickSize}, kBrickSize);
  }

  void buildPyramid() {
    Level bricks{mIndex.brickDims(), std::vector<Range>(mIndex.brickCount())};
    parallelFor(mIndex.brickCount(), 256, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t b = begin; b < end; ++b) bricks.cubes[b] = rangeOfBrick(b);
    });
    mLevels.push_back(std::move(bricks));
    while (static_cast<int>(mLevels.size()) + kBrickLog2 <= kTopLevel && mLevels.back().cubes.size() > 1)
      mLevels.push_back(coarser(mLevels.back()));
  }

  [[nodiscard]] static Level coarser(const Level& fine) {
    Level coarse{{(fine.dims[0] + 1) / 2, (fine.dims[1] + 1) / 2, (fine.dims[2] + 1) / 2}, {}};
    coarse.cubes.assign(std::size_t(coarse.dims[0]) * coarse.dims[1] * coarse.dims[2], Range::empty());
    for (int x = 0; x < fine.dims[0]; ++x)
      for (int y = 0; y < fine.dims[1]; ++y)
        for (int z = 0; z < fine.dims[2]; ++z)
          coarse.cubes[(std::size_t(x / 2) * coarse.dims[1] + y / 2) * coarse.dims[2] + z / 2].add(fine.at(x, y, z));
    return coarse;
  }

  /// The label of a whole brick, or -1 when it needs finer ones.
  [[nodiscard]] int brickLabel(const Vec3i& c) const {
    for (int l = static_cast<int>(mLevels.size()) - 1; l >= 0; --l)
      if (const Steps s = classify(mLevels[l].at(c[0] >> l, c[1] >> l, c[2] >> l)); s != Steps::Fine)
        return label(l + kBrickLog2, s);
    return -1;
  }

  void labelBricks() {
    const std::int64_t count = mIndex.brickCount();
    mBrickLabels.resize(count);
    parallelFor(count, 1024, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t b = begin; b < end; ++b) mBrickLabels[b] = brickLabel(mIndex.brickCoord(b));
    });
    for (std::int64_t b = 0; b < count; ++b)
      if (mBrickLabels[b] < 0) mMixed.push_back(b);
    mVoxelLabels.resize(mMixed.size());
    parallelFor(static_cast<std::int64_t>(mMixed.size()), 16, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) labelVoxels(mMixed[i], mVoxelLabels[i]);
    });
  }

  /// Levels 2 and 1 inside a brick; what neither takes stays 0.
  void labelVoxels(std::int64_t b, std::array<int, kBrickVoxels>& labels) const {
    labels.fill(0);
    const Vec3i c = mIndex.brickCoord(b);
    for (int level = 2; level >= 1; --level) {
      const int size = 1 << level;
      forVoxels({c[0] * kBrickSize, c[1] * kBrickSize, c[2] * kBrickSize}, kBrickSize, [&](int x, int y, int z) {
        const bool corner = ((x | y | z) & (size - 1)) == 0;
        if (!corner || labels[brickOffset(x, y, z)] != 0) return;
        const Steps s = classify(rangeOf({x, y, z}, size));
        if (s == Steps::Fine) return;
        forVoxels({x, y, z}, size, [&](int i, int j, int k) { labels[brickOffset(i, j, k)] = label(level, s); });
      });
    }
  }

  [[nodiscard]] openvdb::Int32Grid::Ptr assemble() const {
    auto grid = openvdb::Int32Grid::create(0);
    auto& tree = grid->tree();
    const auto origin = [&](std::int64_t b) {
      const Vec3i c = mIndex.brickCoord(b);
      return openvdb::Coord(c[0] * kBrickSize, c[1] * kBrickSize, c[2] * kBrickSize);
    };
    for (std::int64_t b = 0; b < mIndex.brickCount(); ++b)
      if (mBrickLabels[b] >= 0) tree.addTile(1, origin(b), mBrickLabels[b], true);
    for (std::size_t i = 0; i < mMixed.size(); ++i) {
      auto* leaf = tree.touchLeaf(origin(mMixed[i]));
      leaf->setValuesOn();
      std::copy(mVoxelLabels[i].begin(), mVoxelLabels[i].end(), leaf->buffer().data());
    }
    openvdb::tools::prune(tree);
    grid->setName("stepField");
    grid->setTransform(domainTransform(mDomain));
    return grid;
  }

  Domain mDomain;
  StepFieldOptions mOptions;
  const RunContext& mCtx;
  BrickGrid<float> mIndex;
  BrickGrid<Vec3f> mAttenuation;
  std::vector<Level> mLevels; // [0] holds the bricks
  std::vector<int> mBrickLabels;
  std::vector<std::int64_t> mMixed;
  std::vector<std::array<int, kBrickVoxels>> mVoxelLabels;
};

} // namespace

openvdb::Int32Grid::Ptr stepFieldGrid(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx) {
  if (options.indexTolerance > options.indexTolerance2)
    throw Error(ErrorKind::Usage,
                "stepField: indexTolerance is above indexTolerance2; the first is the tighter of the two");
  return StepFieldBuilder(medium, options, ctx).build();
}

} // namespace volcaustic
