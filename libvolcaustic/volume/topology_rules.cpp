#include "volume/topology_rules.h"

#include "core/parallel.h"

#include <limits>

namespace volcaustic {

namespace {

/// Voxels from a surface to the farthest node of a cell that it passes through, about.
constexpr double kNear = 1.8;

/// Changes below this part of a voxel are none.
constexpr double kTiny = 1e-3;

struct NodeChange {
  float value;
  float old; ///< the value before
  bool changed;
};

LevelSet emptyLevelSet(BlockGrid grid, const RunContext& ctx) {
  constexpr std::uint64_t kBytesPerNode = 32; // values, marks, distances and what contours need
  ctx.requireMemory(grid.nodeCount() * kBytesPerNode, "the level set where surfaces change; take larger voxels");
  LevelSet set{std::move(grid), {}, {}};
  set.value.resize(set.grid.nodeCount());
  set.changed.resize(set.grid.nodeCount());
  return set;
}

/// How far from a surface distances have to be known, which parts count, and which one comes first of all.
struct RuleReach {
  double limit; ///< of each part's distance
  double near;  ///< of the boxes of parts and blocks
  double exact; ///< values beyond this one need only have the right sign
  std::size_t first;
};

/// Fills one block after another with rule(distances of the parts at a node), dividing it where a surface is near.
template <class Rule>
class BlockFiller {
public:
  BlockFiller(LevelSet& set, const SurfaceParts& parts, const RuleReach& reach, const Rule& rule)
      : mSet(set), mParts(parts), mReach(reach), mRule(rule) {}

  void fill(std::size_t block) {
    const Vec3i& first = mSet.grid.blocks()[block];
    Box box{mSet.grid.position(first), mSet.grid.position(first)};
    for (double& x : box.max) x += mSet.grid.voxelSize() * (BlockGrid::kSide - 1);
    mNear.clear();
    if (mReach.first < mParts.size()) mNear.push_back(mReach.first);
    for (std::size_t p = 0; p < mParts.size(); ++p)
      if (p != mReach.first && areNear(mParts[p]->tree().bounds(), box, mReach.near)) mNear.push_back(p);
    mDistances.resize(mNear.size());
    mHints.assign(mNear.size(), ClosestPoint::kNone);
    fillCube(block * BlockGrid::kNodes, first, BlockGrid::kSide);
  }

private:
  NodeChange changeAt(const Vec3d& p, const Vec3i& n) {
    for (std::size_t i = 0; i < mNear.size(); ++i)
      mDistances[i] = mParts[mNear[i]]->distance(p, n, mReach.limit, mHints[i]);
    return mRule(std::span<const NodeDistance>(mDistances));
  }

  void fillCube(std::size_t base, const Vec3i& low, int side) {
    const double h = mSet.grid.voxelSize(), half = (side - 1) / 2.0;
    if (side == 1) {
      set(base, low, changeAt(mSet.grid.position(low), low));
      return;
    }
    const Vec3d centre{h * (low[0] + half), h * (low[1] + half), h * (low[2] + half)};
    const int middle = (side - 1) / 2;
    const NodeChange change = changeAt(centre, {low[0] + middle, low[1] + middle, low[2] + middle});
    constexpr double kSlope = 1.25; // at most, of what rules make of distances
    if (std::min(std::abs(change.value), std::abs(change.old)) > kSlope * half * std::sqrt(3.0) * h + mReach.exact) {
      for (int k = 0; k < side; ++k)
        for (int j = 0; j < side; ++j)
          for (int i = 0; i < side; ++i)
            set(base, {low[0] + i, low[1] + j, low[2] + k}, {change.value, change.old, false});
      return;
    }
    const int part = side / 2;
    for (int c = 0; c < 8; ++c)
      fillCube(base, {low[0] + (c & 1) * part, low[1] + (c >> 1 & 1) * part, low[2] + (c >> 2) * part}, part);
  }

  void set(std::size_t base, const Vec3i& n, const NodeChange& change) {
    const std::size_t node = base + BlockGrid::inBlock(n);
    mSet.value[node] = change.value;
    mSet.changed[node] = change.changed;
  }

  LevelSet& mSet;
  const SurfaceParts& mParts;
  RuleReach mReach;
  const Rule& mRule;
  std::vector<std::size_t> mNear;
  std::vector<std::uint32_t> mHints;
  std::vector<NodeDistance> mDistances;
};

template <class Rule>
void applyRule(LevelSet& set, const SurfaceParts& parts, const RuleReach& reach, const RunContext& ctx, Rule rule) {
  parallelFor(static_cast<std::int64_t>(set.grid.blocks().size()), 1, ctx,
              [&](std::int64_t begin, std::int64_t end, int) {
                BlockFiller filler(set, parts, reach, rule);
                for (std::int64_t b = begin; b < end; ++b) filler.fill(static_cast<std::size_t>(b));
              });
}

/// The smooth minimum of Quilez's quadratic kind, of the nearest part and each other one. Its width shrinks where both
/// surfaces face the same way (after Gourmel et al. 2013), so that nothing bulges where parts run along each other.
NodeChange mergedNode(std::span<const NodeDistance> parts, float far, double voxelSize, double blend) {
  if (parts.empty()) return {far, far, false};
  std::size_t nearest = 0;
  int close = 0;
  bool atCrease = false;
  const double near = kNear * voxelSize;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].distance < parts[nearest].distance) nearest = p;
    close += std::abs(parts[p].distance) < near;
    atCrease |= parts[p].atCrease;
  }
  const double low = parts[nearest].distance;
  double value = low;
  for (std::size_t p = 0; p < parts.size() && blend > 0; ++p) {
    if (p == nearest) continue;
    double cosine = 0;
    for (int k = 0; k < 3; ++k) cosine += double{parts[p].gradient[k]} * parts[nearest].gradient[k];
    cosine = std::clamp(cosine, 0.0, 1.0);
    const double width = 2 * blend * (1 - cosine * cosine) * (1 - cosine * cosine);
    const double apart = parts[p].distance - low;
    if (apart < width) value -= width / 4 * (1 - apart / width) * (1 - apart / width);
  }
  const bool isNear = std::min(std::abs(low), std::abs(value)) < near;
  return {static_cast<float>(value), static_cast<float>(low),
          isNear && (close > 1 || atCrease || low - value > kTiny * voxelSize)};
}

/// Part 0 of `parts` gives way to each other one until half the gap is between it and where both are equally deep.
NodeChange apartNode(std::span<const NodeDistance> parts, double voxelSize, double gap) {
  const double old = parts[0].distance;
  double value = old;
  for (std::size_t p = 1; p < parts.size(); ++p) value = std::max(value, (old - parts[p].distance + gap) / 2);
  const bool isNear = std::min(std::abs(old), std::abs(value)) < kNear * voxelSize;
  return {static_cast<float>(value), parts[0].distance, isNear && value - old > kTiny * voxelSize};
}

} // namespace

LevelSet mergedParts(const SurfaceParts& parts, const TopologyLengths& lengths, bool everywhere,
                     const RunContext& ctx) {
  const double h = lengths.voxelSize, width = 2 * lengths.blend;
  const double reach = std::max(width, 2 * kNear * h);
  RegionMarker marker(parts, h, width / 4 + (kNear + kMargin + kStrip) * h, ctx);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (everywhere) marker.markSurface(p);
    marker.markSelfOverlap(p);
    for (std::size_t q = 0; q < parts.size(); ++q)
      if (q != p && areNear(parts[p]->tree().bounds(), parts[q]->tree().bounds(), reach)) marker.markNear(p, q, reach);
  }
  LevelSet set = emptyLevelSet(marker.take(), ctx);
  const double limit = 1.25 * width + 2 * kNear * h;
  applyRule(set, parts, {limit, limit, kNear * h, parts.size()}, ctx, [&](std::span<const NodeDistance> here) {
    return mergedNode(here, static_cast<float>(limit), h, lengths.blend);
  });
  return set;
}

LevelSet keptApart(const SurfaceParts& parts, std::size_t part, const TopologyLengths& lengths, bool everywhere,
                   const RunContext& ctx) {
  const double h = lengths.voxelSize, reach = lengths.gap + 2 * kNear * h;
  RegionMarker marker(parts, h, (kNear + kMargin + kStrip) * h, ctx);
  if (everywhere) marker.markSurface(part);
  for (std::size_t q = 0; q < parts.size(); ++q) {
    if (q == part || !areNear(parts[part]->tree().bounds(), parts[q]->tree().bounds(), reach)) continue;
    marker.markNear(part, q, reach);
    marker.markOverlap(part, q);
  }
  LevelSet set = emptyLevelSet(marker.take(), ctx);
  applyRule(set, parts, {std::numeric_limits<double>::infinity(), reach, kNear * h, part}, ctx,
            [&](std::span<const NodeDistance> here) { return apartNode(here, h, lengths.gap); });
  return set;
}

LevelSet measuredPart(BlockGrid grid, const SurfaceParts& parts, double limit, const RunContext& ctx) {
  LevelSet set = emptyLevelSet(std::move(grid), ctx);
  applyRule(set, parts, {limit, 0, limit, 0}, ctx, [](std::span<const NodeDistance> here) {
    return NodeChange{here[0].distance, here[0].distance, false};
  });
  return set;
}

namespace {

/// Blocks in or beside which something changes.
std::vector<bool> blocksNearChange(const LevelSet& set) {
  std::vector<bool> near(set.grid.blocks().size(), false);
  for (std::size_t b = 0; b < near.size(); ++b) {
    const auto first = set.changed.begin() + static_cast<std::ptrdiff_t>(b * BlockGrid::kNodes);
    if (std::find(first, first + BlockGrid::kNodes, 1) == first + BlockGrid::kNodes) continue;
    const Vec3i& at = set.grid.blocks()[b];
    for (int n = 0; n < 27; ++n) {
      const std::int64_t beside =
          set.grid.node(at[0] + BlockGrid::kSide * (n % 3 - 1), at[1] + BlockGrid::kSide * (n / 3 % 3 - 1),
                        at[2] + BlockGrid::kSide * (n / 9 - 1));
      if (beside != BlockGrid::kNone) near[static_cast<std::size_t>(beside) / BlockGrid::kNodes] = true;
    }
  }
  return near;
}

} // namespace

std::vector<float> distanceFromChange(const LevelSet& set, double margin, const RunContext& ctx) {
  const double h = set.grid.voxelSize();
  const int cap = static_cast<int>(std::ceil(margin / h + kStrip)); // less than a block
  const auto none = static_cast<float>(cap * cap);
  const std::vector<bool> near = blocksNearChange(set);
  std::vector<float> squared(set.grid.nodeCount()), next(squared.size(), none);
  for (std::size_t n = 0; n < squared.size(); ++n) squared[n] = set.changed[n] ? 0 : none;
  // One axis after another: the smallest sum of a square along the axis and of what the other axes found.
  for (int axis = 0; axis < 3; ++axis) {
    parallelFor(static_cast<std::int64_t>(near.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (auto n = static_cast<std::size_t>(begin) * BlockGrid::kNodes;
           n < static_cast<std::size_t>(end) * BlockGrid::kNodes; ++n) {
        if (!near[n / BlockGrid::kNodes]) continue;
        float best = squared[n];
        Vec3i at = set.grid.coordinates(n);
        const int centre = at[axis];
        for (int d = -cap; d <= cap; ++d) {
          if (static_cast<float>(d * d) >= best) continue;
          at[axis] = centre + d;
          const std::int64_t other = set.grid.node(at[0], at[1], at[2]);
          if (other != BlockGrid::kNone)
            best = std::min(best, squared[static_cast<std::size_t>(other)] + static_cast<float>(d * d));
        }
        next[n] = best;
      }
    });
    squared.swap(next);
  }
  for (float& value : squared) value = static_cast<float>(h * std::sqrt(value) - margin);
  return squared;
}

} // namespace volcaustic
