#include "transport/receiver_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace volcaustic {

namespace {

using kernels::Float3;
using kernels::ReceiverTriangle;

constexpr int kBins = 16, kLeaf = 4;
constexpr int kDeepest = 48; ///< beyond this depth halves by number, so that recursion ends soon

struct Bounds {
  Float3 low{std::numeric_limits<float>::max()}, high{-std::numeric_limits<float>::max()};

  void add(const Float3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const Bounds& b) {
    low = {std::min(low.x, b.low.x), std::min(low.y, b.low.y), std::min(low.z, b.low.z)};
    high = {std::max(high.x, b.high.x), std::max(high.y, b.high.y), std::max(high.z, b.high.z)};
  }
  /// Half of the surface.
  [[nodiscard]] double area() const {
    const kernels::Double3 d = kernels::Double3(high) - kernels::Double3(low);
    return high.x < low.x ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
  }
};

struct Item {
  Bounds bounds;
  Float3 middle;
  std::int32_t triangle;
};

class Builder {
public:
  explicit Builder(const std::vector<ReceiverTriangle>& triangles) {
    float largest = 0;
    mItems.reserve(triangles.size());
    for (const ReceiverTriangle& t : triangles) {
      Item item;
      item.triangle = static_cast<std::int32_t>(mItems.size());
      for (const Float3& p : t.corner) {
        item.bounds.add(p);
        largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      }
      item.middle = (item.bounds.low + item.bounds.high) * 0.5f;
      mItems.push_back(item);
    }
    mPad = Float3(std::max(largest, 1.0f) * 0x1p-20f);
  }

  ReceiverTree run() {
    if (!mItems.empty()) build(0, static_cast<std::int32_t>(mItems.size()), 0);
    mTree.order.reserve(mItems.size());
    for (const Item& item : mItems) mTree.order.push_back(item.triangle);
    return std::move(mTree);
  }

private:
  void build(std::int32_t begin, std::int32_t end, int depth) {
    Bounds all, middles;
    for (std::int32_t i = begin; i < end; ++i) {
      all.add(mItems[i].bounds);
      middles.add(mItems[i].middle);
    }
    const auto number = mTree.nodes.size();
    mTree.nodes.push_back({all.low - mPad, begin, all.high + mPad, end - begin});
    if (end - begin <= kLeaf) return;
    const std::int32_t middle = depth < kDeepest ? split(begin, end, middles) : begin + (end - begin) / 2;
    build(begin, middle, depth + 1);
    build(middle, end, depth + 1);
    mTree.nodes[number].count = 0;
    mTree.nodes[number].first = static_cast<std::int32_t>(mTree.nodes.size());
  }

  /// Which of the bins along an axis a middle is in.
  struct Bins {
    float low, scale;
    int axis;

    [[nodiscard]] int of(const Item& item) const {
      return std::min(static_cast<int>((item.middle[axis] - low) * scale), kBins - 1);
    }
  };

  /// Parts the items along the axis on which they spread most, so that the expected cost of a ray is least; by number
  /// where all are at one place.
  std::int32_t split(std::int32_t begin, std::int32_t end, const Bounds& middles) {
    const Float3 size = middles.high - middles.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const Bins bins{middles.low[axis], kBins / size[axis], axis};
    const int cut = std::isfinite(bins.scale) ? bestCut(begin, end, bins) : 0;
    if (cut == 0) return begin + (end - begin) / 2;
    const auto middle = std::stable_partition(mItems.begin() + begin, mItems.begin() + end,
                                              [&](const Item& item) { return bins.of(item) < cut; });
    return static_cast<std::int32_t>(middle - mItems.begin());
  }

  /// The first bin of the right side; 0 where all would be on one.
  [[nodiscard]] int bestCut(std::int32_t begin, std::int32_t end, const Bins& bins) const {
    std::array<Bounds, kBins> bounds;
    std::array<std::int32_t, kBins> counts{};
    for (std::int32_t i = begin; i < end; ++i) {
      const int bin = bins.of(mItems[i]);
      bounds[bin].add(mItems[i].bounds);
      ++counts[bin];
    }
    std::array<double, kBins> right{}; // cost of the bins from one on
    Bounds sum;
    std::int32_t count = 0;
    for (int bin = kBins - 1; bin > 0; --bin) {
      sum.add(bounds[bin]);
      right[bin] = sum.area() * (count += counts[bin]);
    }
    sum = {};
    count = 0;
    int best = 0;
    double least = std::numeric_limits<double>::max();
    for (int bin = 1; bin < kBins; ++bin) {
      sum.add(bounds[bin - 1]);
      count += counts[bin - 1];
      if (count == 0 || count == end - begin) continue;
      if (const double cost = sum.area() * count + right[bin]; cost < least) {
        least = cost;
        best = bin;
      }
    }
    return best;
  }

  std::vector<Item> mItems;
  Float3 mPad;
  ReceiverTree mTree;
};

} // namespace

ReceiverTree receiverTree(const std::vector<ReceiverTriangle>& triangles) { return Builder(triangles).run(); }

} // namespace volcaustic
