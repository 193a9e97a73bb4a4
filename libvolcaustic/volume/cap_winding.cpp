#include "volume/cap_winding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace volcaustic {

namespace {

/// A group further away than this many of its radii is seen as its moments: an error below 1e-3 of a winding number.
constexpr double kGroupDistance = 6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kWholeSphere = 4 * std::numbers::pi;

Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3d operator-(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3d operator*(double s, const Vec3d& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vec3d& a) { return std::sqrt(dot(a, a)); }

void extend(Vec3d& low, Vec3d& high, const Vec3d& p) {
  for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
}

double distanceToBox(const Vec3d& p, const Vec3d& low, const Vec3d& high) {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const double d = std::max({low[i] - p[i], 0.0, p[i] - high[i]});
    squared += d * d;
  }
  return std::sqrt(squared);
}

double distanceToSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a, ap = p - a;
  const double squared = dot(ab, ab);
  const double t = squared > 0 ? std::clamp(dot(ap, ab) / squared, 0.0, 1.0) : 0.0;
  return length(ap - t * ab);
}

template <int N>
Vec3d sumOf(const std::array<Vec3d, N>& item) {
  Vec3d sum = item[0];
  for (int i = 1; i < N; ++i) sum = sum + item[i];
  return sum;
}

Vec3d areaVector(const std::array<Vec3d, 3>& t) { return 0.5 * cross(t[1] - t[0], t[2] - t[0]); }

/// Each figure once, with the number of times that it comes; less those that come as often the other way round.
template <int N>
std::vector<Weighted<N>> merged(const std::vector<std::array<Vec3d, N>>& figures) {
  std::vector<Weighted<N>> result;
  for (std::array<Vec3d, N> corners : figures) {
    double sign = 1; // of the permutation that sorts the corners
    for (int pass = 1; pass < N; ++pass)
      for (int i = 0; i + 1 < N; ++i)
        if (corners[i + 1] < corners[i]) {
          std::swap(corners[i], corners[i + 1]);
          sign = -sign;
        }
    result.push_back({corners, sign});
  }
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.corners < b.corners; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < result.size();) {
    Weighted<N> sum{result[i].corners, 0};
    for (; i < result.size() && result[i].corners == sum.corners; ++i) sum.weight += result[i].weight;
    if (sum.weight != 0) result[kept++] = sum;
  }
  result.resize(kept);
  return result;
}

/// The gradient of a solid angle is the Biot-Savart integral over its boundary: of a side of length l at distance d
/// less than l / (4 pi d^2) of the whole sphere, and than 1 / (4 d), that of a whole straight line.
double sideGradient(double side, double distance) {
  return distance > 0 ? std::min(side / (kWholeSphere * distance * distance), 1 / (4 * distance)) : kInfinity;
}

AreaMoments momentsOf(std::span<const WeightedTriangle> triangles, const Vec3d& middle) {
  AreaMoments m{{0, 0, 0}, {0, 0, 0}, {}, 0};
  double area = 0;
  for (const auto& [t, weight] : triangles) {
    const Vec3d vector = weight * areaVector(t);
    m.areaVector = m.areaVector + vector;
    m.centroid = m.centroid + (length(vector) / 3) * sumOf<3>(t);
    area += length(vector);
  }
  m.centroid = area > 0 ? (1 / area) * m.centroid : middle;
  for (const auto& [t, weight] : triangles) {
    const Vec3d a = weight * areaVector(t), c = (1.0 / 3) * sumOf<3>(t) - m.centroid;
    const std::array<double, 6> product{a[0] * c[0],
                                        a[1] * c[1],
                                        a[2] * c[2],
                                        0.5 * (a[0] * c[1] + a[1] * c[0]),
                                        0.5 * (a[0] * c[2] + a[2] * c[0]),
                                        0.5 * (a[1] * c[2] + a[2] * c[1])};
    for (int i = 0; i < 6; ++i) m.first[i] += product[i];
    for (const Vec3d& p : t) m.radius = std::max(m.radius, length(p - m.centroid));
  }
  return m;
}

} // namespace

double distanceToTriangle(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  bool above = dot(normal, normal) > 0; // p projects into the triangle
  for (int i = 0; i < 3 && above; ++i) above = dot(cross(t[(i + 1) % 3] - t[i], p - t[i]), normal) >= 0;
  if (above) return std::abs(dot(p - t[0], normal)) / length(normal);
  return distanceToRim(p, t);
}

double distanceToRim(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  return std::min(
      {distanceToSegment(p, t[0], t[1]), distanceToSegment(p, t[1], t[2]), distanceToSegment(p, t[2], t[0])});
}

template <int N>
BoxTree<N>::BoxTree(std::vector<Weighted<N>> primitives) : items(std::move(primitives)) {
  if (items.empty()) items.push_back({{}, 0}); // all cancel: one that counts for nothing
  build(0, static_cast<std::uint32_t>(items.size()));
}

template <int N>
std::uint32_t BoxTree<N>::build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(nodes.size());
  Node node{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}, first, count};
  for (std::uint32_t i = first; i < first + count; ++i)
    for (const Vec3d& p : items[i].corners) extend(node.low, node.high, p);
  nodes.push_back(node);
  if (count == 1) return index;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (node.high[a] - node.low[a] > node.high[axis] - node.low[axis]) axis = a;
  const auto begin = items.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [axis](const auto& a, const auto& b) {
    return sumOf<N>(a.corners)[axis] < sumOf<N>(b.corners)[axis];
  });
  build(first, count / 2);
  const std::uint32_t right = build(first + count / 2, count - count / 2);
  nodes[index].right = right;
  return index;
}

CapWinding::CapWinding(const std::vector<std::array<Vec3d, 3>>& caps, const std::vector<std::array<Vec3d, 2>>& edges)
    : mCaps(merged<3>(caps)), mEdges(merged<2>(edges)) {
  for (const auto& node : mCaps.nodes)
    mMoments.push_back(momentsOf({mCaps.items.data() + node.first, node.count}, 0.5 * (node.low + node.high)));
  // The solid angle of an area A at distance d is at most A / d^2.
  double area = 0;
  for (const auto& [t, weight] : mCaps.items) area += std::abs(weight) * length(areaVector(t));
  mReach = std::sqrt(2 * area / kWholeSphere);
  for (const auto& node : mEdges.nodes) {
    double sum = 0;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      sum += std::abs(mEdges.items[i].weight) * length(mEdges.items[i].corners[1] - mEdges.items[i].corners[0]);
    mEdgeLengths.push_back(sum);
  }
}

double CapWinding::at(const Vec3d& p) const {
  PointSums points;
  points.add(p);
  std::vector<Group> near;
  addFar(kAll, p, 0, 0, points, near);
  addNear(near, points);
  return points.sum(0);
}

void CapWinding::addFar(std::span<const Group> groups, const Vec3d& centre, double radius, double clearance,
                        PointSums& points, std::vector<Group>& near) const {
  near.clear();
  for (const Group g : groups) addGroups(g, {centre, radius, clearance}, points, near);
}

void CapWinding::addGroups(Group group, const Ball& ball, PointSums& points, std::vector<Group>& near) const {
  const AreaMoments& moments = mMoments[group];
  const double distance = length(moments.centroid - ball.centre);
  if (distance - ball.radius > kGroupDistance * moments.radius && distance - moments.radius > ball.clearance)
    return addGroup(moments, points);
  if (const std::uint32_t right = mCaps.nodes[group].right) {
    addGroups(group + 1, ball, points, near);
    return addGroups(right, ball, points, near);
  }
  if (distanceToTriangle(ball.centre, cap(group).corners) > ball.clearance) return addTriangle(cap(group), points);
  near.push_back(group);
}

void CapWinding::addNear(std::span<const Group> near, PointSums& points) const {
  for (const Group g : near) addTriangle(cap(g), points);
}

bool CapWinding::touches(Group group, const Vec3d& centre, double radius) const {
  const auto& [low, high, first, count, right] = mCaps.nodes[group];
  if (distanceToBox(centre, low, high) > radius) return false;
  if (right) return touches(group + 1, centre, radius) || touches(right, centre, radius);
  return distanceToTriangle(centre, cap(group).corners) <= radius;
}

double CapWinding::nearChange(std::span<const Group> near, const Vec3d& centre, double radius) const {
  double gradient = 0;
  for (const Group g : near) {
    const auto& [t, weight] = cap(g);
    for (int i = 0; i < 3; ++i) {
      const Vec3d &a = t[i], &b = t[(i + 1) % 3];
      gradient += std::abs(weight) * sideGradient(length(b - a), distanceToSegment(centre, a, b) - radius);
    }
  }
  return radius * gradient;
}

double CapWinding::edgeGradient(Group group, double distance) const {
  const auto& [low, high, first, count, right] = mEdges.nodes[group];
  if (right) return distance > 0 ? mEdgeLengths[group] / (kWholeSphere * distance * distance) : kInfinity;
  const auto& [corners, weight] = mEdges.items[first];
  return std::abs(weight) * sideGradient(length(corners[1] - corners[0]), distance);
}

void CapWinding::addFarEdges(std::span<const Group> edges, const Vec3d& centre, double radius, double clearance,
                             double& gradient, std::vector<Group>& near) const {
  near.clear();
  for (const Group g : edges) addEdges(g, {centre, radius, clearance}, gradient, near);
}

void CapWinding::addEdges(Group group, const Ball& ball, double& gradient, std::vector<Group>& near) const {
  const auto& [low, high, first, count, right] = mEdges.nodes[group];
  if (right) {
    const double distance = distanceToBox(ball.centre, low, high);
    if (distance > ball.clearance && distance - ball.radius > length(high - low)) {
      gradient += edgeGradient(group, distance - ball.radius);
      return;
    }
    addEdges(group + 1, ball, gradient, near);
    return addEdges(right, ball, gradient, near);
  }
  const auto& [a, b] = mEdges.items[first].corners;
  const double distance = distanceToSegment(ball.centre, a, b);
  if (distance > ball.clearance)
    gradient += edgeGradient(group, distance - ball.radius);
  else
    near.push_back(group);
}

double CapWinding::nearGradient(std::span<const Group> near, const Vec3d& centre, double radius) const {
  double sum = 0;
  for (const Group g : near) {
    const auto& [a, b] = mEdges.items[mEdges.nodes[g].first].corners;
    sum += edgeGradient(g, distanceToSegment(centre, a, b) - radius);
  }
  return sum;
}

std::optional<int> CapWinding::wholeWithin(const Vec3d& centre, double radius) const {
  if (distanceToBox(centre, mCaps.nodes[0].low, mCaps.nodes[0].high) - radius > mReach) return 0;
  if (touches(0, centre, radius)) return std::nullopt;
  double gradient = 0;
  std::vector<Group> near;
  addFarEdges(kAll, centre, radius, radius, gradient, near);
  return near.empty() && radius * gradient < 0.5 ? oneWhole(at(centre), radius * gradient) : std::nullopt;
}

std::optional<int> oneWhole(double w, double change) {
  const int whole = roundedWinding(w - change);
  return whole == roundedWinding(w + change) ? std::optional(whole) : std::nullopt;
}

} // namespace volcaustic
