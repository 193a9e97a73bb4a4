#include "volume/topology_cut.h"

#include <algorithm>
#include <unordered_map>

namespace volcaustic {

namespace {

class Cutter {
public:
  Cutter(std::vector<Vec3d>& positions, bool keepsNegative, const std::function<double(const Vec3d&)>& level)
      : mPositions(positions), mLevel(level), mKeepsNegative(keepsNegative), mIsKept(positions.size(), kUnknown) {}

  bool isKept(std::uint32_t vertex) {
    std::uint8_t& state = mIsKept[vertex];
    if (state == kUnknown) state = isKept(mPositions[vertex]);
    return state != 0;
  }

  /// The vertex where the edge leaves what is kept.
  std::uint32_t crossing(std::uint32_t kept, std::uint32_t dropped) {
    const std::uint64_t key = std::uint64_t{std::min(kept, dropped)} << 32 | std::max(kept, dropped);
    const auto [entry, isNew] = mCrossings.try_emplace(key, static_cast<std::uint32_t>(mPositions.size()));
    if (isNew) {
      constexpr double kClear = 1e-3; // of the edge: no triangle without area at its ends
      const Vec3d a = mPositions[kept], b = mPositions[dropped];
      const auto at = [&](double t) {
        return Vec3d{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
      };
      double low = 0, high = 1;
      for (int step = 0; step < 24; ++step) {
        const double t = (low + high) / 2;
        (isKept(at(t)) ? low : high) = t;
      }
      mPositions.push_back(at(std::clamp(low, kClear, 1 - kClear)));
    }
    return entry->second;
  }

private:
  static constexpr std::uint8_t kUnknown = 2;
  [[nodiscard]] bool isKept(const Vec3d& p) const { return (mLevel(p) < 0) == mKeepsNegative; }

  std::vector<Vec3d>& mPositions;
  const std::function<double(const Vec3d&)>& mLevel;
  bool mKeepsNegative;
  std::vector<std::uint8_t> mIsKept;
  std::unordered_map<std::uint64_t, std::uint32_t> mCrossings;
};

} // namespace

CutTriangles cutTriangles(const std::vector<TriangleCorners>& triangles, std::vector<Vec3d>& positions,
                          bool keepsNegative, const std::function<double(const Vec3d&)>& level) {
  Cutter cutter(positions, keepsNegative, level);
  CutTriangles result;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const TriangleCorners& t = triangles[i];
    const std::array<bool, 3> kept{cutter.isKept(t[0]), cutter.isKept(t[1]), cutter.isKept(t[2])};
    const int count = kept[0] + kept[1] + kept[2];
    if (count == 3) result.whole.push_back(i);
    if (count != 1 && count != 2) continue;
    // Turned so that the one corner that is alone comes first (one kept) or last (two kept).
    int first = 0;
    while (count == 1 ? !kept[first] : kept[(first + 2) % 3]) ++first;
    const std::uint32_t a = t[first], b = t[(first + 1) % 3], c = t[(first + 2) % 3];
    if (count == 1)
      result.cut.push_back({a, CutTriangle::kNone, cutter.crossing(a, b), cutter.crossing(a, c), i});
    else
      result.cut.push_back({a, b, cutter.crossing(b, c), cutter.crossing(a, c), i});
  }
  return result;
}

bool curvesOf(const std::vector<CutTriangle>& cuts, std::vector<std::vector<std::uint32_t>>& curves) {
  std::unordered_map<std::uint32_t, std::uint32_t> next;
  for (const CutTriangle& c : cuts)
    if (!next.try_emplace(c.from, c.to).second) return false;
  for (const CutTriangle& c : cuts) { // in their order, so that curves have one, too
    if (!next.contains(c.from)) continue;
    std::vector<std::uint32_t>& curve = curves.emplace_back();
    std::uint32_t vertex = c.from;
    do {
      const auto step = next.find(vertex);
      if (step == next.end()) return false;
      curve.push_back(vertex);
      vertex = step->second;
      next.erase(step);
    } while (vertex != c.from);
  }
  return true;
}

} // namespace volcaustic
