#include "transport/texel_cover.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

/// Of numbers that are not negative.
std::int32_t floorOf(double v) { return static_cast<std::int32_t>(v); }
std::int32_t ceilingOf(double v) {
  const std::int32_t whole = floorOf(v);
  return whole + (whole < v);
}

} // namespace

TexelRange texelsOf(const MapTriangle& t, const TexelRange& limits) {
  struct Side {
    std::int32_t first, count;
  };
  const auto side = [](double a, double b, double c, std::int32_t low, std::int32_t count) {
    const double from = std::min({a, b, c}), to = std::max({a, b, c});
    const std::int32_t first = floorOf(std::clamp<double>(from, low, low + count - 1)),
                       beyond = ceilingOf(std::clamp<double>(to, first + 1, low + count));
    return Side{first, beyond - first};
  };
  const Side across = side(t[0].column, t[1].column, t[2].column, limits.column, limits.columns),
             down = side(t[0].row, t[1].row, t[2].row, limits.row, limits.rows);
  return {across.first, down.first, across.count, down.count};
}

void TexelCover::begin(const TexelRange& range) {
  mRange = range;
  mStride = static_cast<std::size_t>(range.columns) + 1;
  if (mSums.size() < mStride * range.rows) mSums.resize(mStride * range.rows, 0.0);
  mSpans.assign(range.rows, {range.columns, 0});
}

void TexelCover::touch(std::int32_t row, std::int32_t begin, std::int32_t end) {
  mSpans[row].begin = std::min(mSpans[row].begin, begin);
  mSpans[row].end = std::max(mSpans[row].end, end);
}

void TexelCover::addAt(const MapPoint& p, double amount) {
  const auto within = [](double at, std::int32_t low, std::int32_t count) {
    return floorOf(std::clamp(at - low, 0.0, count - 1.0));
  };
  const std::int32_t column = within(p.column, mRange.column, mRange.columns),
                     row = within(p.row, mRange.row, mRange.rows);
  double* sums = mSums.data() + std::size_t(row) * mStride;
  sums[column] += amount;
  sums[column + 1] -= amount;
  touch(row, column, column + 2);
}

void TexelCover::add(const MapTriangle& t, double density) {
  const double sign = doubleArea(t) < 0 ? -density : density;
  for (int i = 0; i < 3; ++i) addEdge(t[i], t[(i + 1) % 3], sign);
}

/// In each row that the edge crosses, a height of it is there: the texels right of it have all of that as area, those
/// that it crosses a part.
void TexelCover::addEdge(const MapPoint& from, const MapPoint& to, double density) {
  const double rise = to.row - from.row;
  if (std::abs(rise) < 1e-100) return;
  const MapPoint &top = rise > 0 ? from : to, &bottom = rise > 0 ? to : from;
  const double sign = rise > 0 ? -density : density;
  double x = top.column - mRange.column, y = std::max<double>(top.row, mRange.row);
  const double end = bottom.column - mRange.column, left = std::min(x, end), right = std::max(x, end);
  const std::int32_t last = std::min(ceilingOf(bottom.row), mRange.row + mRange.rows);
  std::int32_t row = floorOf(y);
  if (y == top.row && bottom.row <= row + 1) {
    if (row < last) addPiece(row - mRange.row, left, right, sign * (bottom.row - y));
    return;
  }
  const double slope = (bottom.column - top.column) / (bottom.row - top.row);
  x = std::clamp(x + slope * (y - top.row), left, right);
  for (; row < last; ++row) {
    const double next = std::min<double>(row + 1, bottom.row), across = std::clamp(x + slope * (next - y), left, right);
    addPiece(row - mRange.row, std::min(x, across), std::max(x, across), sign * (next - y));
    x = across;
    y = next;
  }
}

/// A piece of an edge inside a row, from x0 to x1.
void TexelCover::addPiece(std::int32_t row, double x0, double x1, double height) {
  double* sums = mSums.data() + std::size_t(row) * mStride;
  const std::int32_t first = std::min(floorOf(x0), mRange.columns - 1),
                     beyond = std::min(std::max(ceilingOf(x1), first + 1), mRange.columns);
  touch(row, first, beyond + 1);
  if (beyond == first + 1) {
    const double within = 0.5 * (x0 + x1) - first;
    sums[first] += height * (1 - within);
    sums[first + 1] += height * within;
    return;
  }
  // Right of the edge, in a column: all of what is higher than the column, and a trapezium.
  const double steep = height / (x1 - x0);
  double before = 0; // area of the column before
  for (std::int32_t c = first; c < beyond; ++c) {
    const double in = std::max<double>(x0, c), out = std::min<double>(x1, c + 1);
    const double area = steep * ((in - x0) + (out - in) * (c + 1 - 0.5 * (in + out)));
    sums[c] += area - before;
    before = area;
  }
  sums[beyond] += height - before;
}

} // namespace volcaustic
