#include "transport/landing_beams.h"

#include "core/parallel.h"
#include "transport/landing_quads.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::EmissionFrame;

/// Sums over quads, for each channel, W: what landed, what of it is in no beam, and what beams have of it if each
/// photon's power is that of its cell.
struct PowerSums {
  Double3 landed{0, 0, 0}, torn{0, 0, 0}, beams{0, 0, 0};
};

/// A quarter of each of a quad's photons.
Double3 quartersOf(const LandingQuad& q) {
  Double3 sum(0, 0, 0);
  for (const LandedCell* l : q)
    if (l) sum += l->power() * 0.25;
  return sum;
}

/// Adds units to texels for one of several threads. Beams are often smaller than texels: the latest texels are kept
/// here until others come to their places.
class UnitAdder {
public:
  explicit UnitAdder(TexelPower& units) : mUnits(units) {}
  ~UnitAdder() {
    for (const Pending& p : mPending) settle(p);
  }
  UnitAdder(const UnitAdder&) = delete;
  UnitAdder& operator=(const UnitAdder&) = delete;

  void add(std::int64_t texel, std::int32_t column, std::int32_t row, const Double3& units) {
    Pending& p = mPending[static_cast<std::size_t>((column & 3) | (row & 3) << 2)];
    if (p.texel != texel) {
      settle(p);
      p = {texel, {0, 0, 0}};
    }
    for (int c = 0; c < 3; ++c) p.units[c] += static_cast<std::int64_t>(units[c] + 0.5);
  }

private:
  struct Pending {
    std::int64_t texel = -1;
    std::array<std::int64_t, 3> units{};
  };
  void settle(const Pending& p) {
    for (std::size_t c = 0; c < 3 && p.texel >= 0; ++c)
      std::atomic_ref<std::int64_t>(mUnits[3 * static_cast<std::size_t>(p.texel) + c])
          .fetch_add(p.units[c], std::memory_order_relaxed);
  }

  TexelPower& mUnits;
  std::array<Pending, 16> mPending;
};

/// Puts power into texels.
class PowerPainter {
public:
  PowerPainter(const ReceiverSet& set, LandingQuads& quads, TexelPower& units, const Double3& unitsPerWatt,
               const Double3& unitsPerBeamWatt)
      : mSet(set), mQuads(quads), mUnits(units), mScale(unitsPerWatt), mBeamScale(unitsPerBeamWatt) {}

  void paintBeam(std::int32_t column, std::int32_t row) {
    const LandingQuad q = mQuads.at(column, row);
    const QuadTriangles triangles = mQuads.trianglesOf(column, row);
    const TexelRange box = mQuads.boxOf(q);
    const double share = triangles.areas[0] + triangles.areas[1];
    mCover.begin(box);
    if (box.columns == 1 && box.rows == 1)
      mCover.addAt(q[0]->point(), share);
    else
      for (int i = 0; i < 2; ++i) {
        const auto& [a, b, c] = triangles.corners[i];
        spread({q[a]->point(), q[b]->point(), q[c]->point()}, triangles.areas[i]);
      }
    give(*q[0], quartersOf(q) * share * mBeamScale);
  }

  /// The quarters of a photon that are in no beam.
  void paintTorn(const LandedCell& cell, std::int32_t column, std::int32_t row) {
    int quarters = 0;
    for (int i = 0; i < 4; ++i) quarters += mQuads.torn(column - i % 2, row - i / 2);
    if (quarters == 0) return;
    const MapPoint p = cell.point();
    const double reach = mQuads.tentOf(cell, column, row);
    const MapPoint low{p.column - reach, p.row - reach}, high{p.column + reach, p.row + reach};
    const TexelRange box = texelsOf({low, high, high}, mSet.charts()[cell.chart].texels);
    const auto tent = [reach](double at, std::int32_t texel) { return 1 - std::abs(texel + 0.5 - at) / reach; };
    mCover.begin(box);
    for (std::int32_t r = box.row; r < box.row + box.rows; ++r)
      for (std::int32_t c = box.column; c < box.column + box.columns; ++c)
        if (const double across = tent(p.column, c), down = tent(p.row, r); across > 0 && down > 0)
          mCover.addAt({c + 0.5, r + 0.5}, across * down);
    give(cell, cell.power() * (0.25 * quarters) * mScale);
  }

private:
  /// A triangle's share, evenly over it.
  void spread(const MapTriangle& t, double share) {
    constexpr double kLine = 1e-6; // texels squared, below which a triangle is a line
    constexpr int kMostParts = 16; // of its sides
    const double area = 0.5 * std::abs(doubleArea(t));
    if (area > kLine) {
      mCover.add(t, share / area);
      return;
    }
    const auto edge = [&](int i, int k) { return std::hypot(t[i].column - t[k].column, t[i].row - t[k].row); };
    const double longest = std::max({edge(0, 1), edge(1, 2), edge(2, 0)});
    const int n = std::clamp(static_cast<int>(2 * longest) + 1, 1, kMostParts);
    // The middles of n * n like triangles.
    const auto at = [&](double u, double v) {
      u /= n, v /= n;
      return MapPoint{t[0].column + u * (t[1].column - t[0].column) + v * (t[2].column - t[0].column),
                      t[0].row + u * (t[1].row - t[0].row) + v * (t[2].row - t[0].row)};
    };
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n - i; ++k) {
        mCover.addAt(at(i + 1 / 3.0, k + 1 / 3.0), share / (n * n));
        if (k < n - i - 1) mCover.addAt(at(i + 2 / 3.0, k + 2 / 3.0), share / (n * n));
      }
  }

  /// Shares units among the texels that are covered and have surface; where there are none, the one of the triangle
  /// landed on that is nearest has them.
  void give(const LandedCell& cell, const Double3& units) {
    mParts.clear();
    double sum = 0;
    const std::int32_t receiver = mSet.charts()[cell.chart].receiver;
    mCover.take([&](std::int32_t column, std::int32_t row, double amount) {
      const std::int64_t texel = mSet.texelAt(receiver, column, row);
      const double part = amount * mSet.texels()[texel].cover;
      if (!(part > 0)) return;
      mParts.push_back({texel, column, row, part});
      sum += part;
    });
    if (!(sum > 0)) {
      mParts = {nearestTexel(*cell.landing)};
      sum = 1;
    }
    const Double3 each = units * (1 / sum);
    for (const Part& p : mParts) mUnits.add(p.texel, p.column, p.row, each * p.amount);
  }

  struct Part {
    std::int64_t texel;
    std::int32_t column, row;
    double amount;
  };

  [[nodiscard]] Part nearestTexel(const kernels::Landing& l) const {
    const kernels::ReceiverTriangle& t = mSet.triangles()[l.triangle];
    const TexelRange box = texelsOf(mapTriangle(t), mSet.charts()[mSet.chartOf(l.triangle)].texels);
    Part nearest{mSet.texelAt(t.receiver, box.column, box.row), box.column, box.row, 1};
    double least = 1e300;
    for (std::int32_t r = box.row; r < box.row + box.rows; ++r)
      for (std::int32_t c = box.column; c < box.column + box.columns; ++c) {
        const std::int64_t texel = mSet.texelAt(t.receiver, c, r);
        const double away = std::hypot(c + 0.5 - l.column, r + 0.5 - l.row);
        if (!(mSet.texels()[texel].area > 0) || away >= least) continue;
        least = away;
        nearest = {texel, c, r, 1};
      }
    return nearest;
  }

  const ReceiverSet& mSet;
  LandingQuads& mQuads;
  UnitAdder mUnits;
  Double3 mScale, mBeamScale;
  TexelCover mCover;
  std::vector<Part> mParts;
};

/// Tells beams from torn quads, and sums their powers.
PowerSums classify(LandingQuads& quads, const RunContext& ctx) {
  std::vector<PowerSums> rows(quads.rows());
  parallelFor(quads.rows(), 8, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const auto row = static_cast<std::int32_t>(i) - 1;
      PowerSums& sums = rows[i];
      const auto [first, last] = quads.columnsOf(row);
      for (std::int32_t column = first; column < last; ++column) {
        const LandingQuad q = quads.at(column, row);
        const Double3 quarters = quartersOf(q);
        if (q[3]) sums.landed += q[3]->power();
        const bool beam = quads.isBeam(q, column, row);
        quads.torn(column, row) = !beam;
        if (!beam) {
          sums.torn += quarters;
          continue;
        }
        const auto [a, b] = quads.trianglesOf(column, row).areas;
        sums.beams += quarters * (a + b);
      }
    }
  });
  PowerSums all;
  for (const PowerSums& r : rows) {
    all.landed += r.landed;
    all.torn += r.torn;
    all.beams += r.beams;
  }
  return all;
}

void paint(const ReceiverSet& set, LandingQuads& quads, TexelPower& units, const Double3& scale,
           const Double3& beamScale, const RunContext& ctx) {
  parallelFor(quads.rows(), 8, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    PowerPainter painter(set, quads, units, scale, beamScale);
    for (std::int64_t i = begin; i < end; ++i) {
      const auto row = static_cast<std::int32_t>(i) - 1;
      const auto [first, last] = quads.columnsOf(row);
      for (std::int32_t column = first; column < last; ++column) {
        if (!quads.torn(column, row)) painter.paintBeam(column, row);
        if (const LandedCell* cell = quads.cells().at(column, row)) painter.paintTorn(*cell, column, row);
      }
    }
  });
}

} // namespace

void addLandedPower(const ReceiverSet& set, const EmissionFrame& frame, std::span<const kernels::Landing> landings,
                    TexelPower& units, std::span<float> power, const RunContext& ctx) {
  LandingQuads quads(set, frame, landings, ctx);
  const PowerSums sums = classify(quads, ctx);
  const double most = kernels::maxComponent(sums.landed);
  if (!(most > 0)) return;
  int exponent = 0;
  std::frexp(most, &exponent);
  const double scale = std::ldexp(1.0, 60 - exponent);
  // Areas of jittered quads are not those of cells at the rim: beams have what is left.
  const auto beamScale = [&](int c) {
    return sums.beams[c] > 0 ? scale * std::max(0.0, sums.landed[c] - sums.torn[c]) / sums.beams[c] : 0;
  };
  paint(set, quads, units, Double3(scale), {beamScale(0), beamScale(1), beamScale(2)}, ctx);
  parallelFor(static_cast<std::int64_t>(units.size()), 1 << 15, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      if (units[i] == 0) continue;
      power[i] += static_cast<float>(static_cast<double>(units[i]) / scale);
      units[i] = 0;
    }
  });
}

} // namespace volcaustic
