#include "transport/environment.h"

#include "core/parallel.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

using kernels::cross;
using kernels::dot;
using kernels::Double3;
using kernels::Environment;
using kernels::Float3;
using kernels::length;
using kernels::normalize;

constexpr double kPi = 3.14159265358979323846;

/// Luminance that comes from a part of all directions, W/m2, and the sum of its directions with it as their weight.
struct Moments {
  double light = 0;
  Double3 towards{0, 0, 0};

  Moments operator+(const Moments& b) const { return {light + b.light, towards + b.towards}; }
  Moments operator-(const Moments& b) const { return {light - b.light, towards - b.towards}; }
  /// Sum over the light of the square of its distance from its mean direction.
  [[nodiscard]] double spread() const { return light > 0 ? std::max(light - dot(towards, towards) / light, 0.0) : 0; }
};

/// The rows and columns of a raster in longitude and latitude, integrated: what a pixel has of the sphere is a product.
struct Raster {
  std::int32_t width, height;

  explicit Raster(const Environment& e) : width(e.planes[0] ? e.width : 512), height(e.planes[0] ? e.height : 256) {}

  /// Of a row, per radian of longitude: the solid angle, and the sums of the directions' parts across and along the
  /// pole.
  struct Row {
    double angle, across, along;
  };
  [[nodiscard]] Row row(std::int32_t number) const {
    const double from = kPi * number / height, to = kPi * (number + 1) / height; // from the pole
    const auto across = [](double t) { return 0.5 * (t - std::sin(t) * std::cos(t)); };
    return {std::cos(from) - std::cos(to), across(to) - across(from),
            0.5 * (std::cos(from) - std::cos(to)) * (std::cos(from) + std::cos(to))};
  }
  /// Of a column: the width in radians, and the sums of the directions over `front` and over `left`.
  [[nodiscard]] Double3 column(std::int32_t number) const {
    const double from = kPi - 2 * kPi * (number + 1) / width, to = kPi - 2 * kPi * number / width;
    return {to - from, std::sin(to) - std::sin(from), std::cos(from) - std::cos(to)};
  }
};

/// Radiance of a pixel's area.
Double3 radianceAt(const Environment& e, const Raster::Row& row, std::int64_t pixel) {
  if (e.planes[0]) return Double3(e.planes[0][pixel], e.planes[1][pixel], e.planes[2][pixel]) * Double3(e.scale);
  return Double3(e.bottom) + Double3(e.top - e.bottom) * (0.5 + 0.5 * row.along / row.angle);
}

struct Cell {
  Double3 irradiance{0, 0, 0};
  Moments moments;
};

/// The sphere in cells of one or more pixels each, and the sums over rectangles of them.
class Cells {
public:
  Cells(const Environment& e, const RunContext& ctx) : mRaster(e) {
    width = std::min(mRaster.width, 512);
    height = std::min(mRaster.height, 256);
    mCells.resize(static_cast<std::size_t>(width) * height);
    std::vector<Double3> columns(mRaster.width);
    for (std::int32_t c = 0; c < mRaster.width; ++c) columns[c] = mRaster.column(c);
    parallelFor(height, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t row = begin; row < end; ++row) fillRow(e, columns, static_cast<std::int32_t>(row));
    });
    sumUp();
  }

  std::int32_t width, height;

  [[nodiscard]] const Cell& at(std::int32_t column, std::int32_t row) const {
    return mCells[std::size_t(row) * width + column];
  }
  /// Of the cells from `columns[0]` to before `columns[1]`, likewise the rows.
  [[nodiscard]] Moments sum(std::int32_t left, std::int32_t right, std::int32_t top, std::int32_t bottom) const {
    return corner(right, bottom) - corner(left, bottom) - corner(right, top) + corner(left, top);
  }

private:
  void fillRow(const Environment& e, const std::vector<Double3>& columns, std::int32_t row) {
    const auto first = [](std::int32_t cell, std::int32_t pixels, std::int32_t cells) {
      return static_cast<std::int32_t>(std::int64_t{cell} * pixels / cells);
    };
    for (std::int32_t y = first(row, mRaster.height, height); y < first(row + 1, mRaster.height, height); ++y) {
      const Raster::Row r = mRaster.row(y);
      for (std::int32_t column = 0; column < width; ++column) {
        Cell& cell = mCells[std::size_t(row) * width + column];
        for (std::int32_t x = first(column, mRaster.width, width); x < first(column + 1, mRaster.width, width); ++x) {
          const Double3 radiance = radianceAt(e, r, std::int64_t{y} * mRaster.width + x);
          const double light = kernels::luminance(radiance);
          cell.irradiance += radiance * (r.angle * columns[x].x);
          cell.moments =
              cell.moments +
              Moments{light * r.angle * columns[x].x,
                      Double3(r.across * columns[x].y, r.across * columns[x].z, r.along * columns[x].x) * light};
        }
      }
    }
  }

  /// The sums over all cells above and to the left of each corner.
  void sumUp() {
    mSums.resize(static_cast<std::size_t>(width + 1) * (height + 1));
    for (std::int32_t row = 0; row < height; ++row) {
      Moments along;
      for (std::int32_t column = 0; column < width; ++column) {
        along = along + at(column, row).moments;
        mSums[std::size_t(row + 1) * (width + 1) + column + 1] = corner(column + 1, row) + along;
      }
    }
  }
  [[nodiscard]] const Moments& corner(std::int32_t column, std::int32_t row) const {
    return mSums[std::size_t(row) * (width + 1) + column];
  }

  Raster mRaster;
  std::vector<Cell> mCells;
  std::vector<Moments> mSums;
};

/// A rectangle of cells, and the best place to divide it.
struct Region {
  std::int32_t left, right, top, bottom;
  double gain = 0;     ///< of spread; 0 where nothing is gained
  bool across = false; ///< divided between columns, else between rows
  std::int32_t at = 0;

  Region(const Cells& cells, std::int32_t l, std::int32_t r, std::int32_t t, std::int32_t b)
      : left(l), right(r), top(t), bottom(b) {
    const Moments all = cells.sum(left, right, top, bottom);
    const double whole = all.spread();
    const auto consider = [&](const Moments& part, bool columns, std::int32_t place) {
      const double less = whole - part.spread() - (all - part).spread();
      if (less <= gain) return;
      gain = less;
      across = columns;
      at = place;
    };
    for (std::int32_t c = left + 1; c < right; ++c) consider(cells.sum(left, c, top, bottom), true, c);
    for (std::int32_t r2 = top + 1; r2 < bottom; ++r2) consider(cells.sum(left, right, top, r2), false, r2);
  }

  [[nodiscard]] Region first(const Cells& cells) const {
    return {cells, left, across ? at : right, top, across ? bottom : at};
  }
  [[nodiscard]] Region second(const Cells& cells) const {
    return {cells, across ? at : left, right, across ? top : at, bottom};
  }
};

EnvironmentPart partOf(const Cells& cells, const Region& region, const Environment& e) {
  Cell all;
  for (std::int32_t row = region.top; row < region.bottom; ++row)
    for (std::int32_t column = region.left; column < region.right; ++column) {
      all.irradiance += cells.at(column, row).irradiance;
      all.moments = all.moments + cells.at(column, row).moments;
    }
  Double3 t = all.moments.towards;
  if (length(t) < 1e-9 * all.moments.light) t = {0, 0, 1}; // evenly from everywhere
  const Double3 from = normalize(Double3(e.front) * t.x + Double3(e.left) * t.y + Double3(e.up) * t.z);
  return {{from.x, from.y, from.z}, {all.irradiance.x, all.irradiance.y, all.irradiance.z}};
}

bool isFinite(const Vec3d& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }
Double3 toDouble3(const Vec3d& v) { return {v[0], v[1], v[2]}; }

void checkBackground(const Background& b, const std::string& place) {
  const auto refuse = [&](const char* what) { throw Error(ErrorKind::Usage, place + what); };
  if (!isFinite(b.up) || !(length(toDouble3(b.up)) > 0)) refuse(".up: must be finite and not zero");
  if (!std::isfinite(b.turn)) refuse(".turn: must be finite");
  for (const auto& [colour, what] : {std::pair{b.bottom, ".bottom: must be finite and not negative"},
                                     {b.top, ".top: must be finite and not negative"},
                                     {b.scale, ".scale: must be finite and not negative"}})
    if (!isFinite(colour) || std::min({colour[0], colour[1], colour[2]}) < 0) refuse(what);
  if (!b.image) {
    if (!b.file.empty()) refuse(".file: is not read yet; set the image to what readEnvironment makes of it");
    return;
  }
  const Image& map = *b.image;
  const std::size_t pixels = static_cast<std::size_t>(map.width) * map.height;
  if (map.width < 1 || map.height < 1 || pixels > 0x7fffffff || map.planes.size() != 3 ||
      std::any_of(map.planes.begin(), map.planes.end(), [&](const auto& plane) { return plane.size() != pixels; }))
    refuse(".image: needs three planes, and at most 2^31 pixels");
}

} // namespace

Environment environmentOf(const Background& background, const std::string& place) {
  checkBackground(background, place);
  const Double3 up = normalize(toDouble3(background.up));
  const Double3 near = std::abs(up.x) < 1 - 1e-9 ? Double3(1, 0, 0) : Double3(0, 1, 0);
  const Double3 front = normalize(near - up * dot(near, up)), left = cross(up, front);
  const double turn = background.turn * kPi / 180, cosine = std::cos(turn), sine = std::sin(turn);
  Environment e;
  e.up = Float3(up);
  e.front = Float3(front * cosine + left * sine);
  e.left = Float3(left * cosine - front * sine);
  e.bottom = Float3(toDouble3(background.bottom));
  e.top = Float3(toDouble3(background.top));
  e.scale = Float3(toDouble3(background.scale));
  if (!background.image) return e;
  e.width = background.image->width;
  e.height = background.image->height;
  for (int c = 0; c < 3; ++c) e.planes[c] = background.image->planes[c].data();
  return e;
}

std::vector<EnvironmentPart> environmentParts(const Environment& environment, int most, const RunContext& ctx) {
  const Cells cells(environment, ctx);
  std::vector<Region> regions{{cells, 0, cells.width, 0, cells.height}};
  const double least = 1e-12 * cells.sum(0, cells.width, 0, cells.height).light; // less is rounding
  while (static_cast<int>(regions.size()) < most) {
    const auto worst = std::max_element(regions.begin(), regions.end(),
                                        [](const Region& a, const Region& b) { return a.gain < b.gain; });
    if (!(worst->gain > least)) break;
    const Region whole = *worst;
    *worst = whole.first(cells);
    regions.push_back(whole.second(cells));
  }
  std::vector<EnvironmentPart> parts;
  for (const Region& region : regions) {
    const EnvironmentPart part = partOf(cells, region, environment);
    if (std::max({part.irradiance[0], part.irradiance[1], part.irradiance[2]}) > 0) parts.push_back(part);
  }
  return parts;
}

} // namespace volcaustic
