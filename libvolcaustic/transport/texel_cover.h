// How much of each texel polygons cover, exactly: areas between their edges and the right end of a row, edge by edge.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace volcaustic {

/// A point of a map, in texels.
struct MapPoint {
  double column, row;
};
using MapTriangle = std::array<MapPoint, 3>;

/// Twice the area, positive where the corners run clockwise in a picture whose rows come from the top.
inline double doubleArea(const MapTriangle& t) {
  return (t[1].column - t[0].column) * (t[2].row - t[0].row) - (t[2].column - t[0].column) * (t[1].row - t[0].row);
}

/// A rectangle of texels.
struct TexelRange {
  std::int32_t column, row, columns, rows;
};

/// Those that a triangle in the rectangle `limits` touches, at least one.
TexelRange texelsOf(const MapTriangle& triangle, const TexelRange& limits);

/// Sums of areas over a rectangle of texels. Kept from one use to the next for its memory; what it costs is the texels
/// that are touched.
class TexelCover {
public:
  /// Takes a rectangle. Triangles to come lie in its columns; of its rows they may stick out.
  void begin(const TexelRange& range);
  /// `density` times the area of each texel that is in the triangle, whichever way that runs.
  void add(const MapTriangle& triangle, double density);
  /// To the texel at a point of the rectangle.
  void addAt(const MapPoint& point, double amount);

  /// Calls visit(column, row, amount) for the texels that have been given more than 0, and forgets all.
  template <class Visit>
  void take(const Visit& visit) {
    for (std::int32_t row = 0; row < mRange.rows; ++row) {
      double* sums = mSums.data() + std::size_t(row) * mStride;
      double sum = 0;
      for (std::int32_t c = mSpans[row].begin; c < mSpans[row].end; ++c) {
        sum += sums[c];
        sums[c] = 0;
        if (sum > 0 && c < mRange.columns) visit(mRange.column + c, mRange.row + row, sum);
      }
    }
  }

private:
  void addEdge(const MapPoint& from, const MapPoint& to, double density);
  void addPiece(std::int32_t row, double x0, double x1, double height);
  void touch(std::int32_t row, std::int32_t begin, std::int32_t end);

  struct Span {
    std::int32_t begin, end;
  };
  TexelRange mRange{};
  std::size_t mStride = 0;
  std::vector<double> mSums; ///< changes along a row; one more than there are texels. Zeros beyond the spans
  std::vector<Span> mSpans;  ///< what has been touched of a row
};

} // namespace volcaustic
