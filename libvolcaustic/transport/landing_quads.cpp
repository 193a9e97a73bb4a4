#include "transport/landing_quads.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

constexpr double kTear = 8;           // times the edges beside
constexpr double kLargestBeam = 1024; // texels; or
constexpr double kBeamSpacings = 64;  // times what a photon has of all texels

double squaredDistance(const LandedCell& a, const LandedCell& b) {
  const double c = double(a.column) - b.column, r = double(a.row) - b.row;
  return c * c + r * r;
}

} // namespace

LandingQuads::LandingQuads(const ReceiverSet& set, const kernels::EmissionFrame& frame,
                           std::span<const kernels::Landing> landings, const RunContext& ctx)
    : mSet(set), mFrame(frame), mFirst(landings.data()), mCells(set, frame.columns, frame.rows, landings, ctx) {
  std::size_t quads = 0;
  for (std::int32_t row = -1; row < frame.rows; ++row) {
    Row quadRow{frame.columns, -1, quads};
    for (const LandedCells::Columns c : {mCells.columnsOf(row), mCells.columnsOf(row + 1)}) {
      if (c.begin >= c.end) continue;
      quadRow.begin = std::min(quadRow.begin, c.begin - 1);
      quadRow.end = std::max(quadRow.end, c.end);
    }
    if (quadRow.end > quadRow.begin) quads += static_cast<std::size_t>(quadRow.end - quadRow.begin);
    mRows.push_back(quadRow);
  }
  mTorn.resize(quads);
  if (mCells.landed() > 0)
    mSpacing = std::sqrt(static_cast<double>(set.texelCount()) / static_cast<double>(mCells.landed()));
}

bool LandingQuads::isBeam(const LandingQuad& q, std::int32_t column, std::int32_t row) const {
  for (const LandedCell* l : q)
    if (!l || l->chart != q[0]->chart) return false;
  const auto [c0, c1] = std::minmax({q[0]->column, q[1]->column, q[2]->column, q[3]->column});
  const auto [r0, r1] = std::minmax({q[0]->row, q[1]->row, q[2]->row, q[3]->row});
  if (double(c1 - c0) * double(r1 - r0) > std::max(kLargestBeam, kBeamSpacings * mSpacing * mSpacing)) return false;
  return !isTear(*q[0], *q[1], {column, row, 1, 0}) && !isTear(*q[2], *q[3], {column, row + 1, 1, 0}) &&
         !isTear(*q[0], *q[2], {column, row, 0, 1}) && !isTear(*q[1], *q[3], {column + 1, row, 0, 1});
}

/// Jittered rays that happen to be close together land close together.
double LandingQuads::squaredStretch(const LandedCell& a, const LandedCell& b) const {
  const double length = squaredDistance(a, b);
  if (!mFrame.jitter) return length;
  const kernels::RasterPoint p = mFrame.pointOf(a.landing - mFirst), q = mFrame.pointOf(b.landing - mFirst);
  const double c = p.column - q.column, r = p.row - q.row;
  return length / std::max(c * c + r * r, 1e-12);
}

double LandingQuads::stretchBeyond(const LandedCell& from, std::int32_t column, std::int32_t row, std::int32_t dc,
                                   std::int32_t dr) const {
  double most = -1;
  const LandedCell* last = &from;
  for (int i = 1; i <= 2; ++i) {
    const LandedCell* next = mCells.at(column + i * dc, row + i * dr);
    if (!next || next->chart != from.chart) break;
    most = std::max(most, squaredStretch(*last, *next));
    last = next;
  }
  return most;
}

bool LandingQuads::isTear(const LandedCell& a, const LandedCell& b, const Edge& e) const {
  if (squaredDistance(a, b) <= 1) return false;
  const double before = stretchBeyond(a, e.column, e.row, -e.toColumn, -e.toRow),
               after = stretchBeyond(b, e.column + e.toColumn, e.row + e.toRow, e.toColumn, e.toRow);
  // One side is enough: on the other there may be the next tear.
  const double beside = before < 0 ? after : after < 0 ? before : std::min(before, after);
  return beside < 0 || squaredStretch(a, b) > kTear * kTear * beside;
}

TexelRange LandingQuads::boxOf(const LandingQuad& q) const {
  const auto [c0, c1] = std::minmax({q[0]->column, q[1]->column, q[2]->column, q[3]->column});
  const auto [r0, r1] = std::minmax({q[0]->row, q[1]->row, q[2]->row, q[3]->row});
  const MapPoint low{c0, r0}, high{c1, r1};
  return texelsOf({low, high, high}, mSet.charts()[q[0]->chart].texels);
}

QuadTriangles LandingQuads::trianglesOf(std::int32_t column, std::int32_t row) const {
  constexpr QuadTriangles kRegular{{{{0, 1, 3}, {0, 3, 2}}}, {0.5, 0.5}};
  if (!mFrame.jitter) return kRegular;
  std::array<MapPoint, 4> p;
  for (int i = 0; i < 4; ++i) {
    const kernels::RasterPoint at =
        mFrame.pointOf((static_cast<std::int64_t>(row) + i / 2) * mFrame.columns + column + i % 2);
    p[i] = {at.column, at.row};
  }
  QuadTriangles one = kRegular, other{{{{0, 1, 2}, {1, 3, 2}}}, {}};
  for (QuadTriangles* t : {&one, &other})
    for (int i = 0; i < 2; ++i) {
      const auto& [a, b, c] = t->corners[i];
      t->areas[i] = 0.5 * doubleArea({p[a], p[b], p[c]});
    }
  const auto least = [](const QuadTriangles& t) { return std::min(t.areas[0], t.areas[1]); };
  QuadTriangles best = least(one) >= least(other) ? one : other;
  for (double& a : best.areas) a = std::max(a, 0.0);
  return best;
}

double LandingQuads::tentOf(const LandedCell& here, std::int32_t column, std::int32_t row) const {
  const double most = std::max(2.0, 4 * mSpacing);
  double sum = 0;
  int count = 0;
  for (const auto& [dc, dr] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    const LandedCell* l = mCells.at(column + dc, row + dr);
    if (!l || l->chart != here.chart) continue;
    const double d = std::sqrt(squaredDistance(*l, here));
    if (d > most) continue;
    sum += d;
    ++count;
  }
  return std::clamp(count > 0 ? sum / count : mSpacing, 1.0, most);
}

} // namespace volcaustic
