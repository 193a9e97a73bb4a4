#include "shapes/profile.h"

#include "core/simd_clones.h"
#include "shapes/batch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

using Piece = ProfileCurve::Piece;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Of sizes: what lies further apart is apart whatever is rounded.
constexpr double kApart = 1e-12;

// A piece about its end a: with d = p - a, n to the left of the tangent there and the curvature k, the centre of the
// circle is a + n/k, and the distance from it less the radius is (k d.d - 2 d.n)/(|k d - n| + 1), positive to the
// right. That has no difference of large numbers however flat an arc is, and where k is 0 it is that from the line.

/// Less than 0 right of the chord.
[[gnu::always_inline]] inline double sideOf(const Piece& g, double x, double y) {
  return (g.b[0] - g.a[0]) * (y - g.a[1]) - (g.b[1] - g.a[1]) * (x - g.a[0]);
}

[[gnu::always_inline]] inline double alongFrom(const Vec2d& from, const Vec2d& tangent, double x, double y) {
  return (x - from[0]) * tangent[0] + (y - from[1]) * tangent[1];
}

/// \param side sideOf() the point
[[gnu::always_inline]] inline double lineSquare(const Piece& g, double side, double x, double y) {
  const double along = alongFrom(g.a, g.tangentA, x, y);
  const double past = along - std::min(std::max(along, 0.0), g.chord), across = side * (1 / g.chord);
  return across * across + past * past;
}

struct CircleAt {
  double distance; ///< signed
  double x, y;     ///< its gradient times `length`
  double length;
};

[[gnu::always_inline]] inline CircleAt circleAt(const Piece& g, double x, double y) {
  const double dx = x - g.a[0], dy = y - g.a[1], nx = -g.tangentA[1], ny = g.tangentA[0], k = g.curvature;
  const double u = k * dx - nx, v = k * dy - ny, length = std::sqrt(u * u + v * v);
  return {(k * (dx * dx + dy * dy) - 2 * (dx * nx + dy * ny)) / (length + 1), u, v, length};
}

/// Whether the point's nearest one on the circle lies between the ends of the arc.
[[gnu::always_inline]] inline bool isBetween(const Piece& g, double x, double y) {
  return (alongFrom(g.a, g.tangentA, x, y) >= 0) & (alongFrom(g.b, g.tangentB, x, y) <= 0);
}

[[gnu::always_inline]] inline double endSquare(const Vec2d& end, double x, double y) {
  const double dx = x - end[0], dy = y - end[1];
  return dx * dx + dy * dy;
}

[[gnu::always_inline]] inline double arcSquare(const Piece& g, double x, double y) {
  const double circle = circleAt(g, x, y).distance, a = endSquare(g.a, x, y), b = endSquare(g.b, x, y);
  const double ends = a < b ? a : b;
  return isBetween(g, x, y) ? circle * circle : ends;
}

double squareOf(const Piece& g, double x, double y) {
  return g.curvature == 0 ? lineSquare(g, sideOf(g, x, y), x, y) : arcSquare(g, x, y);
}

/// What is known of each point of a batch so far. Loops get it and their piece by value: no store can change them.
struct Progress {
  const double* x;
  const double* y;
  int count;
  double* square;  ///< distance from the nearest piece
  double* nearest; ///< its number
  double* sign;    ///< -1, and turned with each crossing of the way to the right
};

// A way to the right crosses a chord whose heights include the point's where the point is left of it. Where it is
// between an arc and its chord it crosses one of them more. Both go by one and the same sideOf().

VOLCAUSTIC_SIMD_CLONES void addLine(const Piece piece, double number, const Progress at) {
  for (int i = 0; i < at.count; ++i) {
    const double x = at.x[i], y = at.y[i], side = sideOf(piece, x, y), square = lineSquare(piece, side, x, y);
    const double known = at.square[i];
    at.square[i] = square < known ? square : known;
    at.nearest[i] = square < known ? number : at.nearest[i];
    const double passed = side < 0 ? 1 : -1, beneathB = y < piece.b[1] ? passed : 1;
    at.sign[i] *= piece.a[1] <= y ? beneathB : 1;
  }
}

VOLCAUSTIC_SIMD_CLONES void addArc(const Piece piece, double number, const Progress at) {
  const double turn = piece.curvature < 0 ? -1 : 1;
  for (int i = 0; i < at.count; ++i) {
    const double x = at.x[i], y = at.y[i], side = sideOf(piece, x, y), square = arcSquare(piece, x, y);
    const double known = at.square[i];
    at.square[i] = square < known ? square : known;
    at.nearest[i] = square < known ? number : at.nearest[i];
    const double passed = side < 0 ? 1 : -1, beneathB = y < piece.b[1] ? passed : 1;
    const double inDisc = circleAt(piece, x, y).distance * turn < 0 ? -1 : 1;
    at.sign[i] *= (piece.a[1] <= y ? beneathB : 1) * (passed == turn ? inDisc : 1);
  }
}

/// A run of pieces that all lie to the right: it is crossed an odd number of times between the heights of its ends.
VOLCAUSTIC_SIMD_CLONES void addRun(double oneEnd, double otherEnd, const Progress at) {
  const double low = std::min(oneEnd, otherEnd), high = std::max(oneEnd, otherEnd);
  for (int i = 0; i < at.count; ++i) at.sign[i] = (low <= at.y[i]) & (at.y[i] < high) ? -at.sign[i] : at.sign[i];
}

VOLCAUSTIC_SIMD_CLONES void finish(const Progress at, double* value) {
  for (int i = 0; i < at.count; ++i) value[i] = at.sign[i] * std::sqrt(at.square[i]);
}

Vec2d middleOf(const Rectangle& r) { return {.5 * (r.min[0] + r.max[0]), .5 * (r.min[1] + r.max[1])}; }
double halfDiagonal(const Rectangle& r) { return .5 * std::hypot(r.max[0] - r.min[0], r.max[1] - r.min[1]); }
double farthest(const Rectangle& r) {
  return std::max({std::abs(r.min[0]), std::abs(r.min[1]), std::abs(r.max[0]), std::abs(r.max[1])});
}
double distanceBetween(const Rectangle& a, const Rectangle& b) {
  double apart[2];
  for (int i = 0; i < 2; ++i) apart[i] = std::max({0.0, a.min[i] - b.max[i], b.min[i] - a.max[i]});
  return std::sqrt(apart[0] * apart[0] + apart[1] * apart[1]);
}
Rectangle hull(const Rectangle& a, const Rectangle& b) {
  return {{std::min(a.min[0], b.min[0]), std::min(a.min[1], b.min[1])},
          {std::max(a.max[0], b.max[0]), std::max(a.max[1], b.max[1])}};
}

/// Holds the rectangle over the chord that is as high as the arc.
Rectangle boxOf(const Piece& g) {
  // With half the arc's angle f the arc is chord/2 tan(f/2) high, and sin(f) = chord curvature / 2.
  const double sine = std::clamp(.5 * g.chord * g.curvature, -1.0, 1.0);
  const double high = .5 * g.chord * sine / (1 + std::sqrt(1 - sine * sine));
  const Vec2d up{high * (g.b[1] - g.a[1]) / g.chord, -high * (g.b[0] - g.a[0]) / g.chord};
  Rectangle box{g.a, g.a};
  for (const Vec2d& p : {g.b, Vec2d{g.a[0] + up[0], g.a[1] + up[1]}, Vec2d{g.b[0] + up[0], g.b[1] + up[1]}})
    box = hull(box, {p, p});
  return box;
}

Piece pieceOf(Vec2d a, Vec2d b, double bulge, bool surface) {
  const bool reversed = b[1] < a[1] || (b[1] == a[1] && b[0] < a[0]);
  if (reversed) {
    std::swap(a, b);
    bulge = -bulge;
  }
  const double chord = std::hypot(b[0] - a[0], b[1] - a[1]), square = 1 + bulge * bulge;
  const double cosine = (1 - bulge * bulge) / square, sine = 2 * bulge / square; // of half the arc's angle
  const Vec2d way{(b[0] - a[0]) / chord, (b[1] - a[1]) / chord};
  const double curvature = 2 * sine / chord;
  Piece g{a, b, way, way, chord, std::abs(curvature) < 1e100 ? curvature : 0, !reversed, surface};
  if (g.curvature != 0) {
    g.tangentA = {cosine * way[0] + sine * way[1], cosine * way[1] - sine * way[0]};
    g.tangentB = {cosine * way[0] - sine * way[1], cosine * way[1] + sine * way[0]};
  }
  return g;
}

/// Twice the area between the way from a to b and `origin`, and between an arc and its chord.
double doubleArea(const Vec2d& origin, const Vec2d& a, const Vec2d& b, double bulge) {
  const double chords = (a[0] - origin[0]) * (b[1] - origin[1]) - (a[1] - origin[1]) * (b[0] - origin[0]);
  if (bulge == 0) return chords;
  const double angle = 4 * std::atan(bulge);
  const double radius = .5 * std::hypot(b[0] - a[0], b[1] - a[1]) / std::sin(.5 * angle);
  return chords + radius * radius * (angle - std::sin(angle));
}

// Least and greatest distance of a rectangle's points from a piece. Where no better is known the latter is infinite.

Interval lineRange(const Piece& g, const Rectangle& r) {
  double greatest = 0;
  for (const double x : {r.min[0], r.max[0]}) // distances from what is convex are greatest in a corner
    for (const double y : {r.min[1], r.max[1]}) greatest = std::max(greatest, squareOf(g, x, y));
  const Vec2d m = middleOf(r), half{.5 * (r.max[0] - r.min[0]), .5 * (r.max[1] - r.min[1])}, &t = g.tangentA;
  const double across = std::abs(sideOf(g, m[0], m[1])) / g.chord - std::abs(t[1]) * half[0] - std::abs(t[0]) * half[1];
  const double along = alongFrom(g.a, t, m[0], m[1]);
  const double past = std::max(-along, along - g.chord) - std::abs(t[0]) * half[0] - std::abs(t[1]) * half[1];
  return {std::hypot(std::max(across, 0.0), std::max(past, 0.0)), std::sqrt(greatest)};
}

/// How many corners of the rectangle are beyond the end a, and beyond the end b: it is all there where all four are.
struct Beyond {
  int a = 0, b = 0;
};
Beyond cornersBeyond(const Piece& g, const Rectangle& r) {
  Beyond beyond;
  for (const double x : {r.min[0], r.max[0]})
    for (const double y : {r.min[1], r.max[1]}) {
      beyond.a += alongFrom(g.a, g.tangentA, x, y) < 0;
      beyond.b += alongFrom(g.b, g.tangentB, x, y) > 0;
    }
  return beyond;
}

Interval arcRange(const Piece& g, const Rectangle& r) {
  const Beyond beyond = cornersBeyond(g, r);
  if (beyond.a == 4 || beyond.b == 4)
    return {std::min(distanceBetween(r, {g.a, g.a}), distanceBetween(r, {g.b, g.b})), kInfinity};
  const double radius = 1 / std::abs(g.curvature);
  const Vec2d centre{g.a[0] - g.tangentA[1] / g.curvature, g.a[1] + g.tangentA[0] / g.curvature};
  const double close = distanceBetween(r, {centre, centre});
  const double far = std::hypot(std::max(std::abs(r.min[0] - centre[0]), std::abs(r.max[0] - centre[0])),
                                std::max(std::abs(r.min[1] - centre[1]), std::abs(r.max[1] - centre[1])));
  const double slack = kRoundingSlack * (radius + far);
  return {std::max({close - radius, radius - far, 0.0}) - slack,
          beyond.a + beyond.b == 0 ? std::max(std::abs(far - radius), std::abs(close - radius)) + slack : kInfinity};
}

} // namespace

ProfileCurve::ProfileCurve(const shapes::Profile& profile, ProfileUse use) {
  const std::vector<ChainLink> chain = chainOf(profile, use);
  double area = 0;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Vec2d &from = chain[i].from, &to = chain[(i + 1) % chain.size()].from;
    if (from == to) continue; // shorter than what is rounded
    mPieces.push_back(pieceOf(from, to, chain[i].bulge, !chain[i].onAxis));
    mHeights.push_back(from[1]);
    area += doubleArea(chain[0].from, from, to, chain[i].bulge);
  }
  mHeights.push_back(mHeights.front());
  if (area < 0)
    for (Piece& piece : mPieces) piece.interiorLeft = !piece.interiorLeft;
  mTree.resize(2 * mPieces.size() - 1);
  mExtent = farthest(buildTree(all()));
}

Rectangle ProfileCurve::buildTree(const Range& range) {
  Rectangle& box = mTree[range.node];
  return box = range.end - range.begin == 1 ? boxOf(mPieces[range.begin])
                                            : hull(buildTree(firstHalf(range)), buildTree(secondHalf(range)));
}

/// The least of `best` and the squares of the point's distances from pieces of a range.
double ProfileCurve::nearestSquare(const Range& range, const Vec2d& p, double best) const {
  if (range.end - range.begin == 1) {
    const Piece& piece = mPieces[range.begin];
    return piece.surface ? std::min(best, squareOf(piece, p[0], p[1])) : best;
  }
  Range close = firstHalf(range), far = secondHalf(range);
  double closeBy = distanceBetween(mTree[close.node], {p, p}), farBy = distanceBetween(mTree[far.node], {p, p});
  if (farBy < closeBy) {
    std::swap(close, far);
    std::swap(closeBy, farBy);
  }
  if (closeBy * closeBy < best) best = nearestSquare(close, p, best);
  if (farBy * farBy < best) best = nearestSquare(far, p, best);
  return best;
}

/// No point of the rectangle is nearest to a piece that is further from the rectangle: its middle is that near to
/// another one, and its other points half a diagonal further at most.
double ProfileCurve::reachFrom(const Rectangle& r) const {
  return std::sqrt(nearestSquare(all(), middleOf(r), kInfinity)) + halfDiagonal(r) + kApart * (mExtent + farthest(r));
}

/// Calls `near` for the number of each piece within reach and how far its box is, and `right`, for each run of others
/// to the right, for the heights of its ends. What else there is lies to the left, above or beneath.
template <class Near, class Right>
void ProfileCurve::walk(const Rectangle& r, double reach, const Near& near, const Right& right,
                        const Range& range) const {
  const Rectangle& box = mTree[range.node];
  const double apart = distanceBetween(box, r);
  if (apart > reach) {
    if (box.min[0] > r.max[0]) right(mHeights[range.begin], mHeights[range.end]);
    return;
  }
  if (range.end - range.begin == 1) {
    if (mPieces[range.begin].surface) near(range.begin, apart);
    return;
  }
  walk(r, reach, near, right, firstHalf(range));
  walk(r, reach, near, right, secondHalf(range));
}

void ProfileCurve::evaluate(const double* x, const double* y, int count, const Results& results) const {
  if (count == 0) return;
  const auto [left, right] = std::minmax_element(x, x + count);
  const auto [bottom, top] = std::minmax_element(y, y + count);
  const Rectangle r{{*left, *bottom}, {*right, *top}};
  BatchNumbers square, nearest, sign;
  std::fill_n(square.data(), count, kInfinity);
  std::fill_n(nearest.data(), count, 0.0);
  std::fill_n(sign.data(), count, -1.0);
  const Progress progress{x, y, count, square.data(), nearest.data(), sign.data()};
  walk(
      r, reachFrom(r),
      [&](std::size_t i, double) {
        if (mPieces[i].curvature == 0)
          addLine(mPieces[i], double(i), progress);
        else
          addArc(mPieces[i], double(i), progress);
      },
      [&](double from, double to) { addRun(from, to, progress); }, all());
  finish(progress, results.value);
  if (results.gradient[0]) findGradients(x, y, count, nearest.data(), results);
}

void ProfileCurve::findGradients(const double* x, const double* y, int count, const double* nearest,
                                 const Results& results) const {
  constexpr double kTiny = 1e-300;
  for (int i = 0; i < count; ++i) {
    const Piece& g = mPieces[std::size_t(nearest[i])];
    const bool inside = results.value[i] > 0;
    if (isBetween(g, x[i], y[i])) {
      const CircleAt circle = circleAt(g, x[i], y[i]); // its gradient points to the right
      const bool clear = std::abs(circle.distance) > kRoundingSlack * mExtent;
      const bool interiorLeft = clear ? inside == (circle.distance < 0) : g.interiorLeft;
      const double k = (interiorLeft ? -1 : 1) / (circle.length + kTiny);
      results.gradient[0][i] = k * circle.x;
      results.gradient[1][i] = k * circle.y;
    } else {
      const Vec2d& end = endSquare(g.a, x[i], y[i]) < endSquare(g.b, x[i], y[i]) ? g.a : g.b;
      const double dx = x[i] - end[0], dy = y[i] - end[1], k = (inside ? 1 : -1) / (std::hypot(dx, dy) + kTiny);
      results.gradient[0][i] = k * dx;
      results.gradient[1][i] = k * dy;
    }
  }
}

Interval ProfileCurve::bound(const Rectangle& r) const {
  const double reach = farthest(r), slack = kRoundingSlack * (mExtent + reach);
  if (!(reach < 1e100)) return {-2 * mExtent - 2 * reach, 2 * mExtent}; // squares are not finite
  const Vec2d middle = middleOf(r);
  double value;
  evaluate(&middle[0], &middle[1], 1, {&value, {nullptr, nullptr}});
  const double half = halfDiagonal(r) + slack;
  // The distance without its sign.
  Interval range{kInfinity, std::abs(value) + half};
  walk(
      r, std::abs(value) + half,
      [&](std::size_t i, double apart) {
        const Piece& g = mPieces[i];
        const Interval one = g.curvature == 0 ? lineRange(g, r) : arcRange(g, r);
        range = {std::min(range.low, std::max(one.low, apart)), std::min(range.high, one.high)};
      },
      [](double, double) {}, all());
  range = widened(range, slack);
  Interval values = range;
  if (range.low <= 0)
    values.low = -range.high;
  else if (value < 0)
    values = -range;
  return {std::max(values.low, value - half), std::min(values.high, value + half)};
}

} // namespace volcaustic
