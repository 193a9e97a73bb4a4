#include "volume/step_labels.h"

#include "core/brick_set.h"
#include "core/parallel.h"
#include "core/simd_clones.h"
#include "volcaustic/error.h"
#include "volume/brick_block.h"

#include <algorithm>

namespace volcaustic {

namespace {

constexpr int kTopLevel = 12; // 4096 voxels: the edge of OpenVDB's largest node

using IndexBlock = BrickBlock<float, 1, 1>;
using AttenuationBlock = BrickBlock<Vec3f, 1, 1>;
static_assert(IndexBlock::kRow == AttenuationBlock::kRow && IndexBlock::kRow == IndexField::kRow);

/// Minima and maxima over the 4^3 voxels of each 2^3 cell of a brick and one voxel around it.
template <int Channels>
struct CellRanges {
  static constexpr int kCells = 4;
  static constexpr int kRow = IndexBlock::kRow * Channels, kPlane = IndexBlock::kPlane * Channels;

  std::array<float, kCells * kCells * kCells * Channels> low, high; ///< cells z fastest, channels inside

  /// Of a block whose planes are `stride` numbers apart.
  void run(const float* block, int stride) {
    for (int x = 0; x < kCells; ++x)
      reduce<kPlane>(block + 2 * x * stride, block + 2 * x * stride, stride, &mLowX[x * kPlane], &mHighX[x * kPlane]);
    for (int xy = 0; xy < kCells * kCells; ++xy) {
      const int from = xy / kCells * kPlane + xy % kCells * 2 * kRow;
      reduce<kRow>(&mLowX[from], &mHighX[from], kRow, &mLowY[xy * kRow], &mHighY[xy * kRow]);
    }
    for (int xyz = 0; xyz < kCells * kCells * kCells; ++xyz) {
      const int from = xyz / kCells * kRow + xyz % kCells * 2 * Channels;
      reduce<Channels>(&mLowY[from], &mHighY[from], Channels, &low[xyz * Channels], &high[xyz * Channels]);
    }
  }

private:
  /// Of four runs of Count numbers.
  template <int Count>
  static void reduce(const float* lows, const float* highs, int stride, float* __restrict low, float* __restrict high) {
    for (int i = 0; i < Count; ++i) {
      const float *l = lows + i, *h = highs + i;
      low[i] = std::min(std::min(l[0], l[stride]), std::min(l[2 * stride], l[3 * stride]));
      high[i] = std::max(std::max(h[0], h[stride]), std::max(h[2 * stride], h[3 * stride]));
    }
  }

  std::array<float, kCells * kPlane> mLowX, mHighX;
  std::array<float, kCells * kCells * kRow> mLowY, mHighY;
};

VOLCAUSTIC_SIMD_CLONES void findRanges(const float* block, int stride, CellRanges<1>& ranges) {
  ranges.run(block, stride);
}
VOLCAUSTIC_SIMD_CLONES void findRanges(const float* block, int stride, CellRanges<3>& ranges) {
  ranges.run(block, stride);
}

} // namespace

/// Ranges inside one brick, of cubes with one voxel around them: what a lookup inside the cube can see.
class StepLabels::Ranges {
public:
  Ranges(const BrickGrid<float>& index, const BrickGrid<Vec3f>* attenuation)
      : mIndex(index), mAttenuation(attenuation) {}

  void look(std::int64_t b) {
    mIndexVaries = !mIndex.uniformAround(b);
    mAttenuationVaries = mAttenuation && !mAttenuation->uniformAround(b);
    mConstant.low[0] = mIndexVaries ? 0 : mIndex.constant(b);
    for (int c = 0; c < 3; ++c)
      mConstant.low[c + 1] = mAttenuation && !mAttenuationVaries ? mAttenuation->constant(b)[c] : 0;
    std::copy_n(mConstant.low, 4, mConstant.high);
    if (mIndexVaries) findIndexRanges(mIndex.brickCoord(b));
    if (mAttenuationVaries) {
      mAttenuationBlock.gather(*mAttenuation, mIndex.brickCoord(b));
      findRanges(mAttenuationBlock.data()->data(), AttenuationBlock::kPlane * 3, mAttenuationCells);
    }
  }
  /// n around the brick, or null where it is one value.
  [[nodiscard]] IndexField* field() { return mIndexVaries ? &mField : nullptr; }
  /// Of the cube of n^3 cells from `first` on.
  [[nodiscard]] Range of(const Vec3i& first, int n) const {
    if (!mIndexVaries && !mAttenuationVaries) return mConstant;
    Range r = ofCell(first[0], first[1], first[2]);
    for (int x = first[0]; x < first[0] + n; ++x)
      for (int y = first[1]; y < first[1] + n; ++y)
        for (int z = first[2]; z < first[2] + n; ++z) r.add(ofCell(x, y, z));
    return r;
  }

private:
  void findIndexRanges(const Vec3i& brick) {
    mField.gather(mIndex, brick);
    if (mField.inside()) {
      findRanges(mField.around(), IndexField::kPlane, mIndexCells);
    } else { // the field goes on beyond the domain's faces where a lookup does not
      mIndexBlock.gather(mIndex, brick);
      findRanges(mIndexBlock.data(), IndexBlock::kPlane, mIndexCells);
    }
  }
  [[nodiscard]] Range ofCell(int x, int y, int z) const {
    const int i = (x * kCells + y) * kCells + z;
    Range r = mConstant;
    if (mIndexVaries) {
      r.low[0] = mIndexCells.low[i];
      r.high[0] = mIndexCells.high[i];
    }
    if (mAttenuationVaries)
      for (int c = 0; c < 3; ++c) {
        r.low[c + 1] = mAttenuationCells.low[3 * i + c];
        r.high[c + 1] = mAttenuationCells.high[3 * i + c];
      }
    return r;
  }

  const BrickGrid<float>& mIndex;
  const BrickGrid<Vec3f>* mAttenuation;
  bool mIndexVaries = false, mAttenuationVaries = false;
  Range mConstant{};
  IndexField mField;
  IndexBlock mIndexBlock;
  AttenuationBlock mAttenuationBlock;
  CellRanges<1> mIndexCells;
  CellRanges<3> mAttenuationCells;
};

void requireTolerances(const StepFieldOptions& options) {
  if (options.indexTolerance > options.indexTolerance2)
    throw Error(ErrorKind::Usage,
                "stepField: indexTolerance is above indexTolerance2; the first is the tighter of the two");
}

StepLabels::StepLabels(const BrickGrid<float>& index, const BrickGrid<Vec3f>* attenuation, double voxelSize,
                       const StepFieldOptions& options, const RunContext& ctx, const Visit& visit)
    : mRules{voxelSize, options.indexTolerance, options.indexTolerance2, options.attenuationTolerance}
    , mDims(index.dims()) {
  requireTolerances(options);
  const Vec3f a = attenuation ? attenuation->background() : Vec3f{0, 0, 0};
  const float n = index.background();
  mAmbient = {{n, a[0], a[1], a[2]}, {n, a[0], a[1], a[2]}};
  BrickSet band(index.brickDims());
  band.insertAround(index.occupied());
  if (attenuation) band.insertAround(attenuation->occupied());
  mBand = band.sorted();
  ctx.requireMemory(mBand.size() * (sizeof(Range) + sizeof(Cells) + sizeof(Vec3i) + sizeof(std::int64_t)),
                    "stepField: labels");
  labelBand(index, attenuation, ctx, visit);
  while (static_cast<int>(mLevels.size()) + kBrickLog2 <= kTopLevel && mLevels.back().cubeCount() > 1)
    mLevels.push_back(coarser(mLevels.back(), static_cast<int>(mLevels.size())));
  const Vec3i& top = mLevels.back().dims;
  for (int x = 0; x < top[0]; ++x)
    for (int y = 0; y < top[1]; ++y)
      for (int z = 0; z < top[2]; ++z) collect(static_cast<int>(mLevels.size()) - 1, {x, y, z});
}

void StepLabels::labelBand(const BrickGrid<float>& index, const BrickGrid<Vec3f>* attenuation, const RunContext& ctx,
                           const Visit& visit) {
  Level bricks(index.brickDims());
  bricks.resize(mBand.size());
  mCells.resize(mBand.size());
  for (std::size_t i = 0; i < mBand.size(); ++i) bricks.slots[mBand[i]] = static_cast<std::int32_t>(i + 1);
  parallelFor(static_cast<std::int64_t>(mBand.size()), 32, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    Ranges ranges(index, attenuation);
    for (std::int64_t i = begin; i < end; ++i) {
      ranges.look(mBand[i]);
      bricks.coords[i] = index.brickCoord(mBand[i]);
      bricks.ranges[i] = ranges.of({0, 0, 0}, kCells);
      bricks.labels[i] = classify(bricks.ranges[i], kBrickLog2);
      if (bricks.labels[i] == kMixed) labelCells(ranges, mCells[i]);
      if (visit)
        visit(static_cast<std::size_t>(i), mBand[i], bricks.ranges[i].high[0] - bricks.ranges[i].low[0],
              ranges.field());
    }
  });
  for (std::size_t i = 0; i < mBand.size(); ++i)
    if (bricks.labels[i] == kMixed) mMixed.push_back(mBand[i]);
  mLevels.push_back(std::move(bricks));
}

/// Levels 2 and 1 inside a brick; what neither takes is 0.
void StepLabels::labelCells(const Ranges& ranges, Cells& labels) const {
  const auto cell = [&](const Vec3i& c) -> StepLabel& { return labels[(c[0] * kCells + c[1]) * kCells + c[2]]; };
  const auto forEight = [](const Vec3i& first, int step, auto&& visit) {
    for (int i = 0; i < 8; ++i)
      visit(Vec3i{first[0] + (i >> 2) * step, first[1] + (i >> 1 & 1) * step, first[2] + (i & 1) * step});
  };
  forEight({0, 0, 0}, 2, [&](const Vec3i& first) {
    const StepLabel four = classify(ranges.of(first, 2), 2);
    forEight(first, 1, [&](const Vec3i& c) {
      const StepLabel two = four != kMixed ? four : classify(ranges.of(c, 1), 1);
      cell(c) = two != kMixed ? two : StepLabel{0};
    });
  });
}

StepLabels::Level StepLabels::coarser(const Level& fine, int level) const {
  Level coarse({(fine.dims[0] + 1) / 2, (fine.dims[1] + 1) / 2, (fine.dims[2] + 1) / 2});
  std::vector<std::uint8_t> children;
  for (std::size_t i = 0; i < fine.coords.size(); ++i) {
    const Vec3i& c = fine.coords[i];
    std::int32_t& slot = coarse.slots[coarse.place({c[0] / 2, c[1] / 2, c[2] / 2})];
    if (slot == 0) {
      coarse.coords.push_back({c[0] / 2, c[1] / 2, c[2] / 2});
      coarse.ranges.push_back(fine.ranges[i]);
      children.push_back(0);
      slot = static_cast<std::int32_t>(children.size());
    }
    coarse.ranges[slot - 1].add(fine.ranges[i]);
    ++children[slot - 1];
  }
  coarse.labels.resize(children.size());
  for (std::size_t i = 0; i < children.size(); ++i) {
    int inDomain = 1;
    for (int a = 0; a < 3; ++a) inDomain *= 2 * coarse.coords[i][a] + 1 < fine.dims[a] ? 2 : 1;
    if (children[i] < inDomain) coarse.ranges[i].add(mAmbient);
    coarse.labels[i] = classify(coarse.ranges[i], level + kBrickLog2);
  }
  return coarse;
}

StepLabel StepLabels::ofCube(int level, const Vec3i& cube) const {
  if (const std::int32_t slot = mLevels[level].slots[mLevels[level].place(cube)]; slot > 0)
    return mLevels[level].labels[slot - 1];
  const StepLabel ambient = classify(mAmbient, level + kBrickLog2);
  return ambient != kMixed ? ambient : StepLabel{0};
}

void StepLabels::collect(int level, const Vec3i& cube) {
  const StepLabel label = ofCube(level, cube);
  if (label != kMixed) {
    Cube c{cube, cube, label};
    for (int a = 0; a < 3; ++a) {
      c.first[a] = cube[a] << level;
      c.last[a] = std::min(((cube[a] + 1) << level) - 1, mLevels[0].dims[a] - 1);
    }
    mCubes.push_back(c);
    return;
  }
  if (level == 0) return;
  const Vec3i& dims = mLevels[level - 1].dims;
  for (int i = 0; i < 8; ++i) {
    const Vec3i child{2 * cube[0] + (i >> 2), 2 * cube[1] + (i >> 1 & 1), 2 * cube[2] + (i & 1)};
    if (child[0] < dims[0] && child[1] < dims[1] && child[2] < dims[2]) collect(level - 1, child);
  }
}

StepLabel StepLabels::ofBrick(const Vec3i& brick) const {
  for (int level = static_cast<int>(mLevels.size()) - 1; level >= 0; --level)
    if (const StepLabel label = ofCube(level, {brick[0] >> level, brick[1] >> level, brick[2] >> level});
        label != kMixed)
      return label;
  return kMixed;
}

void StepLabels::ofVoxels(const Vec3i& brick, std::span<StepLabel, kBrickVoxels> labels) const {
  const Cells& cells = mCells[mLevels[0].slots[mLevels[0].place(brick)] - 1];
  Vec3i end;
  for (int a = 0; a < 3; ++a) end[a] = std::min(mDims[a] - brick[a] * kBrickSize, kBrickSize);
  std::fill(labels.begin(), labels.end(), StepLabel{0});
  for (int x = 0; x < end[0]; ++x)
    for (int y = 0; y < end[1]; ++y) {
      const StepLabel* row = &cells[((x >> 1) * kCells + (y >> 1)) * kCells];
      for (int z = 0; z < end[2]; ++z) labels[brickOffset(x, y, z)] = row[z >> 1];
    }
}

} // namespace volcaustic
