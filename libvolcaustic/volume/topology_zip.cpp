#include "volume/topology_zip.h"

#include "volume/topology_tree.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

double distanceBetween(const Vec3d& a, const Vec3d& b) {
  const Vec3d d = difference(a, b);
  return std::sqrt(dot(d, d));
}

/// A closed curve by its arc length.
struct Arc {
  std::vector<std::uint32_t> vertices;
  std::vector<double> start; ///< arc length at each vertex, and that of the whole curve

  Arc(const std::vector<std::uint32_t>& curve, const std::vector<Vec3d>& positions) : vertices(curve), start{0} {
    for (std::size_t i = 0; i < curve.size(); ++i)
      start.push_back(start.back() + distanceBetween(positions[curve[i]], positions[curve[(i + 1) % curve.size()]]));
  }
  [[nodiscard]] double length() const { return start.back(); }
  [[nodiscard]] double wrapped(double s) const { return s - length() * std::floor(s / length()); }
  [[nodiscard]] std::size_t segment(double s) const {
    const auto after = std::upper_bound(start.begin(), start.end() - 1, s);
    return static_cast<std::size_t>(after - start.begin()) - 1;
  }
  [[nodiscard]] Vec3d point(double s, const std::vector<Vec3d>& positions) const {
    const std::size_t i = segment(s);
    const Vec3d &a = positions[vertices[i]], &b = positions[vertices[(i + 1) % vertices.size()]];
    const double span = start[i + 1] - start[i], t = span > 0 ? (s - start[i]) / span : 0;
    return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
  }
};

/// Arc lengths that go once around the curve, made to rise where they do not: halfway between the least rising values
/// above and the greatest below. False where they do not go around once.
bool makeRising(std::vector<double>& s, double length) {
  const std::size_t n = s.size();
  for (std::size_t i = 1; i < n; ++i) s[i] -= length * std::round((s[i] - s[i - 1]) / length);
  if (std::abs(s[0] + length - s[n - 1]) > length / 2) return false;
  std::vector<double> below = s, above = s;
  for (std::size_t i = 1; i < n; ++i) below[i] = std::max(below[i], below[i - 1]);
  for (std::size_t i = n - 1; i-- > 0;) above[i] = std::min(above[i], above[i + 1]);
  constexpr double kApart = 1e-5; // of the curve: keeps vertices apart that would be one point
  for (std::size_t i = 1; i < n; ++i) {
    const double along = std::clamp((below[i] + above[i]) / 2 - s[0], 0.0, (1 - kApart) * length);
    s[i] = s[0] + (1 - kApart) * along + kApart * length * static_cast<double>(i) / static_cast<double>(n);
  }
  return true;
}

class Zipper {
public:
  Zipper(const Curves& fixed, double reach, std::vector<Vec3d>& positions, ZippedCurves& zipped)
      : mReach(reach), mPositions(positions), mZipped(zipped), mTaken(fixed.size(), false) {
    std::vector<TriangleCorners> segments;
    for (std::uint32_t c = 0; c < fixed.size(); ++c) {
      mArcs.emplace_back(fixed[c], positions);
      for (std::uint32_t i = 0; i < fixed[c].size(); ++i) {
        const std::uint32_t to = fixed[c][(i + 1) % fixed[c].size()];
        segments.push_back({fixed[c][i], to, to});
        mOwner.push_back({c, i});
      }
    }
    mFixedPositions.assign(positions.begin(), positions.end());
    mTree = std::make_unique<TriangleTree>(mFixedPositions, std::move(segments));
  }

  bool zip(const std::vector<std::uint32_t>& curve) {
    const std::vector<std::uint32_t> added(curve.rbegin(), curve.rend());
    std::vector<double> s(added.size());
    std::uint32_t owner = 0;
    for (std::size_t i = 0; i < added.size(); ++i) {
      const ClosestPoint c = mTree->closest(mPositions[added[i]], mReach);
      if (!c.found() || (i > 0 && mOwner[c.triangle][0] != owner)) return false;
      owner = mOwner[c.triangle][0];
      const std::uint32_t segment = mOwner[c.triangle][1];
      s[i] = mArcs[owner].start[segment] + distanceBetween(mPositions[mArcs[owner].vertices[segment]], c.point);
    }
    const Arc& arc = mArcs[owner];
    if (mTaken[owner] || added.size() < 3 || !makeRising(s, arc.length())) return false;
    mTaken[owner] = true;
    identify(arc, added, s);
    interleave(arc, added, s);
    return true;
  }

  [[nodiscard]] bool allTaken() const { return std::find(mTaken.begin(), mTaken.end(), false) == mTaken.end(); }

private:
  /// A vertex next to a fixed one becomes that one, where no other vertex comes between.
  void identify(const Arc& arc, const std::vector<std::uint32_t>& added, std::vector<double>& s) {
    const double near = mReach / 16;
    std::vector<bool> taken(arc.vertices.size(), false);
    const std::size_t n = s.size();
    for (std::size_t i = 0; i < n; ++i) {
      const double here = arc.wrapped(s[i]);
      const std::size_t low = arc.segment(here), high = low + 1;
      const bool takesHigh = arc.start[high] - here < here - arc.start[low];
      const double move = takesHigh ? arc.start[high] - here : arc.start[low] - here;
      const std::size_t vertex = (takesHigh ? high : low) % arc.vertices.size();
      const double before = i > 0 ? s[i - 1] : s[n - 1] - arc.length();
      const double after = i + 1 < n ? s[i + 1] : s[0] + arc.length();
      if (taken[vertex] || std::abs(move) > near || s[i] + move >= after || s[i] + move <= before) continue;
      taken[vertex] = true;
      s[i] += move;
      mZipped.sameAs.emplace(added[i], arc.vertices[vertex]);
    }
  }

  void interleave(const Arc& arc, const std::vector<std::uint32_t>& added, const std::vector<double>& s) {
    struct Stop {
      double at;
      std::uint32_t vertex;
      bool isFixed, isAdded;
    };
    std::vector<Stop> stops;
    std::unordered_map<std::uint32_t, std::uint32_t> addedOf; // of a fixed vertex
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto same = mZipped.sameAs.find(added[i]);
      if (same != mZipped.sameAs.end()) {
        addedOf.emplace(same->second, added[i]);
        continue;
      }
      const double at = arc.wrapped(s[i]);
      mPositions[added[i]] = arc.point(at, mPositions);
      stops.push_back({at, added[i], false, true});
    }
    for (std::size_t i = 0; i < arc.vertices.size(); ++i)
      stops.push_back({arc.start[i], arc.vertices[i], true, addedOf.contains(arc.vertices[i])});
    std::stable_sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) { return a.at < b.at; });
    fill(
        stops, [](const Stop& stop) { return stop.isFixed; }, [](const Stop& stop) { return stop.vertex; },
        mZipped.inFixed);
    std::reverse(stops.begin(), stops.end()); // added curves run the other way
    fill(
        stops, [](const Stop& stop) { return stop.isAdded; },
        [&](const Stop& stop) { return stop.isFixed ? addedOf.at(stop.vertex) : stop.vertex; }, mZipped.inAdded);
  }

  /// Lists after each stop of a curve the stops of the other curve that follow it.
  template <class Stop, class Ends, class Name>
  static void fill(const std::vector<Stop>& stops, Ends ends, Name name,
                   std::unordered_map<std::uint32_t, std::vector<std::uint32_t>>& between) {
    const auto first = std::find_if(stops.begin(), stops.end(), ends);
    if (first == stops.end()) return;
    const auto offset = static_cast<std::size_t>(first - stops.begin());
    std::vector<std::uint32_t>* list = nullptr;
    for (std::size_t i = 0; i < stops.size(); ++i) {
      const Stop& stop = stops[(offset + i) % stops.size()];
      if (ends(stop))
        list = &between[name(stop)];
      else
        list->push_back(stop.vertex);
    }
  }

  double mReach;
  std::vector<Vec3d>& mPositions;
  ZippedCurves& mZipped;
  std::vector<bool> mTaken;
  std::vector<Arc> mArcs;
  std::vector<std::array<std::uint32_t, 2>> mOwner; ///< of each segment: its curve and place in it
  std::vector<Vec3d> mFixedPositions;
  std::unique_ptr<TriangleTree> mTree;
};

} // namespace

bool zipCurves(const Curves& fixed, const Curves& added, double reach, std::vector<Vec3d>& positions,
               ZippedCurves& zipped) {
  if (fixed.size() != added.size()) return false;
  if (fixed.empty()) return true;
  Zipper zipper(fixed, reach, positions, zipped);
  for (const std::vector<std::uint32_t>& curve : added)
    if (!zipper.zip(curve)) return false;
  return zipper.allTaken();
}

} // namespace volcaustic
