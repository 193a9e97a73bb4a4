#include "volume/cap_winding.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace volcaustic {

namespace {

/// A node further away than this many of its radii is one dipole. Barill et al. use 2 with second-order terms; a
/// first-order dipole at 4 errs by less than 1e-3 of a winding number.
constexpr double kDipoleDistance = 4;
constexpr std::uint32_t kLeafItems = 4;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

double distanceToTriangle(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  bool above = dot(normal, normal) > 0; // p projects into the triangle
  for (int i = 0; i < 3 && above; ++i) above = dot(cross(t[(i + 1) % 3] - t[i], p - t[i]), normal) >= 0;
  if (above) return std::abs(dot(p - t[0], normal)) / length(normal);
  return std::min(
      {distanceToSegment(p, t[0], t[1]), distanceToSegment(p, t[1], t[2]), distanceToSegment(p, t[2], t[0])});
}

template <int N>
Vec3d sumOf(const std::array<Vec3d, N>& item) {
  Vec3d sum = item[0];
  for (int i = 1; i < N; ++i) sum = sum + item[i];
  return sum;
}

/// Triangles or edges of the snapped caps, so that rows cross them exactly where the winding number jumps.
template <std::size_t N>
std::vector<std::array<Vec3d, N>>
snappedItems(const LoopCaps& caps, const std::vector<std::array<std::uint32_t, N>>& items, const SubLattice& lattice) {
  std::vector<std::array<Vec3d, N>> result;
  const auto snapped = [&](std::uint32_t v) {
    const FixedPoint p = lattice.snap(caps.positions[v]);
    return Vec3d{double(p.x) / double(kFixedOne), double(p.y) / double(kFixedOne), double(p.z) / double(kFixedOne)};
  };
  for (const auto& item : items) {
    auto& corners = result.emplace_back();
    std::transform(item.begin(), item.end(), corners.begin(), snapped);
  }
  return result;
}

template <class Visit>
void forEachOctant(const Vec3i& first, int half, Visit&& visit) {
  for (int c = 0; c < 8; ++c)
    visit(Vec3i{first[0] + (c >> 2) * half, first[1] + (c >> 1 & 1) * half, first[2] + (c & 1) * half});
}

} // namespace

template <int N>
BoxTree<N>::BoxTree(std::vector<std::array<Vec3d, N>> primitives) : items(std::move(primitives)) {
  build(0, static_cast<std::uint32_t>(items.size()));
}

template <int N>
std::uint32_t BoxTree<N>::build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(nodes.size());
  Node node{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}, first, count};
  for (std::uint32_t i = first; i < first + count; ++i)
    for (const Vec3d& p : items[i]) extend(node.low, node.high, p);
  nodes.push_back(node);
  if (count <= kLeafItems) return index;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (node.high[a] - node.low[a] > node.high[axis] - node.low[axis]) axis = a;
  const auto begin = items.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count,
                   [axis](const auto& a, const auto& b) { return sumOf<N>(a)[axis] < sumOf<N>(b)[axis]; });
  build(first, count / 2);
  nodes[index].right = build(first + count / 2, count - count / 2);
  return index;
}

CapWinding::CapWinding(std::vector<std::array<Vec3d, 3>> caps, std::vector<std::array<Vec3d, 2>> edges)
    : mCaps(std::move(caps)), mEdges(std::move(edges)) {
  for (const auto& node : mCaps.nodes) {
    const std::span items(mCaps.items.data() + node.first, node.count);
    Dipole dipole{{0, 0, 0}, {0, 0, 0}, 0};
    double area = 0;
    for (const auto& t : items) {
      const Vec3d vector = 0.5 * cross(t[1] - t[0], t[2] - t[0]);
      dipole.areaVector = dipole.areaVector + vector;
      dipole.centroid = dipole.centroid + (length(vector) / 3) * sumOf<3>(t);
      area += length(vector);
    }
    dipole.centroid = area > 0 ? (1 / area) * dipole.centroid : 0.5 * (node.low + node.high);
    for (const auto& t : items)
      for (const Vec3d& p : t) dipole.radius = std::max(dipole.radius, length(p - dipole.centroid));
    // The solid angle of an area A at distance d is at most A / d^2.
    if (mDipoles.empty()) mReach = std::sqrt(2 * area / kWholeSphere);
    mDipoles.push_back(dipole);
  }
  for (const auto& node : mEdges.nodes) {
    double sum = 0;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      sum += length(mEdges.items[i][1] - mEdges.items[i][0]);
    mEdgeLengths.push_back(sum);
  }
}

/// Solid angles of triangles, added without an arc tangent for each: half of one is the argument of a complex number
/// (Van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30(2), 1983), so that
/// the sum is the argument of their product, when the turns past the negative real axis are counted.
class CapWinding::AngleSum {
public:
  void add(const std::array<Vec3d, 3>& t, const Vec3d& p) {
    const Vec3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    const double sine = dot(a, cross(b, c));
    const double cosine = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    const double size = std::abs(sine) + std::abs(cosine);
    if (size == 0) return; // p is a corner
    const double re = (mRe * cosine - mIm * sine) / size, im = (mRe * sine + mIm * cosine) / size;
    if (mIm >= 0 && sine >= 0 && im < 0) ++mTurns;
    if (mIm < 0 && sine < 0 && im >= 0) --mTurns;
    mRe = re;
    mIm = im;
  }
  void addDipole(double solidAngle) { mDipoles += solidAngle; }
  [[nodiscard]] double total() const { return mDipoles + 2 * (std::atan2(mIm, mRe) + 2 * std::numbers::pi * mTurns); }

private:
  double mRe = 1, mIm = 0, mDipoles = 0;
  int mTurns = 0;
};

double CapWinding::at(const Vec3d& p) const {
  AngleSum sum;
  addSolidAngle(0, p, sum);
  return sum.total() / kWholeSphere;
}

void CapWinding::addSolidAngle(std::uint32_t node, const Vec3d& p, AngleSum& sum) const {
  const Dipole& dipole = mDipoles[node];
  const Vec3d d = dipole.centroid - p;
  const double squared = dot(d, d);
  if (const double near = kDipoleDistance * dipole.radius; squared > near * near)
    return sum.addDipole(dot(dipole.areaVector, d) / (squared * std::sqrt(squared)));
  const auto& [low, high, first, count, right] = mCaps.nodes[node];
  if (right) {
    addSolidAngle(node + 1, p, sum);
    return addSolidAngle(right, p, sum);
  }
  for (std::uint32_t i = first; i < first + count; ++i) sum.add(mCaps.items[i], p);
}

bool CapWinding::touches(std::uint32_t node, const Vec3d& centre, double radius) const {
  const auto& [low, high, first, count, right] = mCaps.nodes[node];
  if (distanceToBox(centre, low, high) > radius) return false;
  if (right) return touches(node + 1, centre, radius) || touches(right, centre, radius);
  return std::any_of(mCaps.items.begin() + first, mCaps.items.begin() + first + count,
                     [&](const auto& t) { return distanceToTriangle(centre, t) <= radius; });
}

/// Bound on |w(x) - w(centre)| for x within `radius`, where no cap is that near. The gradient of a solid angle is the
/// Biot-Savart integral over its boundary: at distance d an edge of length l adds at most l / (4 pi d^2). Stops early
/// beyond `limit`.
double CapWinding::variation(std::uint32_t node, const Vec3d& centre, double radius, double limit) const {
  const auto bound = [&](double distance, double edgeLength) {
    const double d = distance - radius;
    return d > 0 ? radius * edgeLength / (kWholeSphere * d * d) : kInfinity;
  };
  const auto& [low, high, first, count, right] = mEdges.nodes[node];
  const double near = distanceToBox(centre, low, high);
  if (near > length(high - low) + radius) return bound(near, mEdgeLengths[node]);
  double total = 0;
  if (right) {
    total = variation(node + 1, centre, radius, limit);
    return total > limit ? total : total + variation(right, centre, radius, limit - total);
  }
  for (std::uint32_t i = first; i < first + count && total <= limit; ++i) {
    const auto& [a, b] = mEdges.items[i];
    total += bound(distanceToSegment(centre, a, b), length(b - a));
  }
  return total;
}

std::optional<int> CapWinding::nearestWhole(const Vec3d& centre, double radius) const {
  if (distanceToBox(centre, mCaps.nodes[0].low, mCaps.nodes[0].high) - radius > mReach) return 0;
  if (radius == 0) return static_cast<int>(std::lround(at(centre)));
  if (touches(0, centre, radius)) return std::nullopt;
  const double change = variation(0, centre, radius, 0.5);
  if (change >= 0.5) return std::nullopt;
  const double w = at(centre), nearest = std::round(w);
  if (std::abs(w - nearest) + change >= 0.5) return std::nullopt;
  return static_cast<int>(nearest);
}

CapOffsets::CapOffsets(const LoopCaps& caps, const SubLattice& lattice, const RunContext& ctx)
    : mLattice(lattice)
    , mWinding(snappedItems(caps, caps.triangles, lattice), snappedItems(caps, caps.edges, lattice)) {
  for (int a = 0; a < 3; ++a) mBricks[a] = lattice.size[a] / lattice.brickSamples();
  mTable.assign(static_cast<std::size_t>(mBricks[0]) * mBricks[1] * mBricks[2], 0);
  constexpr int kBlock = 8; // bricks along an edge of what one thread takes at a time
  Vec3i blocks{};
  for (int a = 0; a < 3; ++a) blocks[a] = (mBricks[a] + kBlock - 1) / kBlock;
  parallelFor(std::int64_t{blocks[0]} * blocks[1] * blocks[2], 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) {
      const int z = static_cast<int>(b % blocks[2]), y = static_cast<int>(b / blocks[2] % blocks[1]);
      const int x = static_cast<int>(b / blocks[2] / blocks[1]);
      fillBricks({x * kBlock, y * kBlock, z * kBlock}, kBlock);
    }
  });
}

/// Of a cube of n^3 samples, where it is one number.
std::optional<std::int16_t> CapOffsets::ofCube(const Vec3i& first, int n) const {
  Vec3d centre{first[0] + 0.5 * n, first[1] + 0.5 * n, first[2] + 0.5 * n};
  double radius = 0.5 * n * std::numbers::sqrt3; // samples are inside their sub-voxels
  if (n == 1) {
    // A sample on a cap lies on the side where the rows put it: see coverage_rows.h; in z, the crossing is before it.
    const Vec3d sample = mLattice.sample(first[0], first[1], first[2]);
    centre = {sample[0] + 0x1p-24, sample[1] + 0x1p-32, sample[2] + 0x1p-18};
    radius = 0;
  }
  const std::optional<int> whole = mWinding.nearestWhole(centre, radius);
  if (!whole) return std::nullopt;
  constexpr int kMax = std::numeric_limits<std::int16_t>::max();
  return static_cast<std::int16_t>(std::clamp(-*whole, -kMax, kMax));
}

void CapOffsets::fillBricks(const Vec3i& first, int n) {
  for (int a = 0; a < 3; ++a)
    if (first[a] >= mBricks[a]) return;
  const int samples = mLattice.brickSamples();
  const auto whole = ofCube({first[0] * samples, first[1] * samples, first[2] * samples}, n * samples);
  if (!whole && n > 1) return forEachOctant(first, n / 2, [&](const Vec3i& octant) { fillBricks(octant, n / 2); });
  for (int x = first[0]; x < std::min(first[0] + n, mBricks[0]); ++x)
    for (int y = first[1]; y < std::min(first[1] + n, mBricks[1]); ++y)
      for (int z = first[2]; z < std::min(first[2] + n, mBricks[2]); ++z)
        mTable[(static_cast<std::size_t>(x) * mBricks[1] + y) * mBricks[2] + z] = whole.value_or(kVaries);
}

void CapOffsets::ofSamples(const Vec3i& brick, std::vector<std::int16_t>& offsets) const {
  const int n = mLattice.brickSamples();
  offsets.resize(static_cast<std::size_t>(n) * n * n);
  fillSamples({brick[0] * n, brick[1] * n, brick[2] * n}, {0, 0, 0}, n, offsets);
}

void CapOffsets::fillSamples(const Vec3i& origin, const Vec3i& first, int n, std::vector<std::int16_t>& offsets) const {
  const auto whole = ofCube({origin[0] + first[0], origin[1] + first[1], origin[2] + first[2]}, n);
  if (!whole)
    return forEachOctant(first, n / 2, [&](const Vec3i& octant) { fillSamples(origin, octant, n / 2, offsets); });
  const int all = mLattice.brickSamples();
  for (int x = first[0]; x < first[0] + n; ++x)
    for (int y = first[1]; y < first[1] + n; ++y)
      std::fill_n(offsets.begin() + (static_cast<std::ptrdiff_t>(x) * all + y) * all + first[2], n, *whole);
}

} // namespace volcaustic
