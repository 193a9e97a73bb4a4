// Emission over a row of a raster's tiles, in lanes or one number at a time: the same source for every instruction set.
#pragma once

#include "backends/lanes.h"
#include "kernels/beam_search.h"

namespace volcaustic::tiles {

// The vocabulary for single numbers; lanes bring their own.
using kernels::any;
using kernels::both;
using kernels::exponential;
using kernels::larger;
using kernels::negate;
using kernels::select;
using kernels::smaller;

/// What emission asks of a number type besides the vocabulary of kernels/lanes.h; lane_emission.cpp has the one for
/// registers.
template <class F>
struct Packet;
template <>
struct Packet<float> {
  static constexpr int kLanes = 1;
  static float load(const float* p) { return *p; }
  static void store(float v, float* p) { *p = v; }
  static int count(bool on) { return on ? 1 : 0; }

  /// Sum of values, each turned into an integer with a factor before it is added: no order changes it.
  class Sum {
  public:
    void add(float v, double factor) { mSum += static_cast<std::int64_t>(static_cast<double>(v) * factor); }
    [[nodiscard]] std::int64_t total() const { return mSum; }

  private:
    std::int64_t mSum = 0;
  };
};

/// One row of tiles. Bits depend neither on the other rows of the raster nor on which of the tiles' rows are asked for:
/// all power is added in integers, that of a run of cells as a difference of corner terms which are integers already.
template <class F>
class TileRowEmission {
public:
  TileRowEmission(const EmissionTask& task, std::int32_t tileRow, PhotonTally& tally)
      : mTask(task)
      , mFrame(task.frame)
      , mTally(tally)
      , mOptics(task.medium.optics[0])
      , mClear(!(kernels::maxComponent(mOptics.attenuation) > 0))
      , mTileRow(tileRow)
      , mRow(tileRow * kTile)
      , mBelow(smaller(mRow + kTile, task.frame.rows))
      , mBegin(larger(mRow, task.rows.begin))
      , mEnd(smaller(mBelow, task.rows.end))
      , mUnits(task.frame.strength * task.scale.tally) {
    for (int i = 0; i < kCells; ++i) {
      mColumns[i] = static_cast<float>(i % kTile);
      mRows[i] = static_cast<float>(mRow + i / kTile);
      mTileColumns[i] = static_cast<float>(i * kTile);
    }
  }

  void run() {
    for (std::int32_t row = mBegin; row < mEnd; ++row)
      for (std::int32_t c = 0; c < mFrame.columns; ++c) entryAt(row, c) = kernels::kNeverBends;
    if (mClear && mFrame.cone.isSphere() && !mTask.stops) bookRun();
    for (std::int32_t tile = 0; tile < mTask.reach.columns; ++tile) {
      const bool booked = mRunBegin <= tile && tile < mRunEnd;
      if (!booked || reaches(tile)) emitTile(tile, booked);
    }
    settle();
  }

private:
  using M = kernels::MaskOf<F>;
  using Lanes = Packet<F>;
  using Outcome = kernels::Outcome;
  using Counter = kernels::Counter;
  static constexpr int kTile = kernels::kReachTile, kCells = kTile * kTile, kPackets = kCells / Lanes::kLanes;

  /// The rays of a tile.
  struct Rays {
    kernels::GridRay<F> ray[kPackets];
    kernels::RaySpan<F> span[kPackets];
    M sees[kPackets];  ///< the box
    M stops[kPackets]; ///< ends on a receiver, unless it bends before
    F found[kPackets]; ///< first bends
  };
  /// Power in units of the tally, channel by channel.
  using Power = typename Lanes::Sum[3];

  [[nodiscard]] float& entryAt(std::int32_t row, std::int32_t column) const {
    return mTask.entry[std::int64_t{row} * mFrame.columns + column];
  }
  [[nodiscard]] float nearest(std::int32_t tile) const {
    return mTask.reach.nearest[std::int64_t{mTileRow} * mTask.reach.columns + tile];
  }
  [[nodiscard]] float farthest(std::int32_t tile) const {
    return mTask.reach.farthest[std::int64_t{mTileRow} * mTask.reach.columns + tile];
  }
  [[nodiscard]] bool reaches(std::int32_t tile) const { return nearest(tile) <= farthest(tile); }

  /// Finds the run of tiles all of whose corners see the box, and books its cells as emitted and escaped. What sees a
  /// convex box is convex, so all cells between do; the light of those that bend is taken back later.
  void bookRun() {
    const std::int32_t corners = mTask.reach.columns + 1;
    std::int32_t first = corners, end = corners;
    for (std::int32_t k = 0; k < corners && end == corners; k += Lanes::kLanes) {
      const F column =
          smaller(F(static_cast<float>(k * kTile)) + Lanes::load(mTileColumns), F(static_cast<float>(mFrame.columns)));
      float seen[kCells];
      Lanes::store(select(both(seesBox(column, mRow), seesBox(column, mBelow)), F(1), F(0)), seen);
      for (std::int32_t i = 0; i < Lanes::kLanes && k + i < corners && end == corners; ++i) {
        if (seen[i] > 0) first = smaller(first, k + i);
        if (seen[i] == 0 && first < corners) end = k + i;
      }
    }
    if (first + 1 >= end) return;
    mRunBegin = first;
    mRunEnd = end - 1;
    const std::int32_t begin = first * kTile, last = smaller(mRunEnd * kTile, mFrame.columns);
    mTally.counts[static_cast<int>(Counter::Emitted)] += std::int64_t{mEnd - mBegin} * (last - begin);
    for (int c = 0; c < 3; ++c) {
      const std::int64_t power = unitsOf(begin, last, mUnits[c]);
      book(Outcome::Emitted, c, power);
      book(Outcome::Escaped, c, power);
    }
  }

  [[nodiscard]] M seesBox(F column, std::int32_t row) const {
    const kernels::GridRay<F> ray = kernels::gridRay(mTask.view, column, F(static_cast<float>(row)));
    const kernels::RaySpan<F> span = kernels::lightSpan(mTask.medium, mTask.view, ray);
    return span.exit > span.entry;
  }

  /// Power of the asked rows' cells in columns [begin, end).
  [[nodiscard]] std::int64_t unitsOf(std::int32_t begin, std::int32_t end, double units) const {
    if (!mFrame.point) return static_cast<std::int64_t>(units) * (mEnd - mBegin) * (end - begin);
    const auto corner = [&](std::int32_t column, std::int32_t row) {
      return static_cast<std::int64_t>(units * mFrame.cornerAngle(column, row));
    };
    return corner(end, mEnd) - corner(begin, mEnd) - corner(end, mBegin) + corner(begin, mBegin);
  }

  void book(Outcome outcome, int channel, std::int64_t units) {
    mTally.power[static_cast<int>(outcome)][channel] += units;
  }

  void emitTile(std::int32_t tile, bool booked) {
    Rays rays;
    launch(tile, rays);
    if (reaches(tile) && !search(tile, rays) && booked) return;
    const std::int32_t first = tile * kTile, end = smaller(first + kTile, mFrame.columns);
    if (reaches(tile)) {
      alignas(64) float found[kCells];
      for (int p = 0; p < kPackets; ++p) Lanes::store(rays.found[p], found + p * Lanes::kLanes);
      for (std::int32_t row = mBegin; row < mEnd; ++row)
        for (std::int32_t c = first; c < end; ++c) entryAt(row, c) = found[(row - mRow) * kTile + c - first];
    }
    for (int p = 0; p < kPackets; ++p) {
      const M bends = rays.found[p] < F(kernels::kNeverBends);
      if (!any(booked ? bends : rays.sees[p])) continue;
      F share = kernels::cellShare(mTask.view, F(static_cast<float>(first)) + Lanes::load(mColumns + p * Lanes::kLanes),
                                   Lanes::load(mRows + p * Lanes::kLanes));
      if (!mFrame.cone.isSphere()) share = share * mFrame.cone.share(rays.ray[p].direction);
      mTally.counts[static_cast<int>(Counter::Traced)] += Lanes::count(bends);
      if (booked)
        add(mEscaped, bends, -share);
      else
        bookPacket(rays, p, bends, share);
    }
  }

  void launch(std::int32_t tile, Rays& rays) const {
    alignas(64) float columns[kCells], rows[kCells];
    const std::int32_t first = tile * kTile;
    for (int i = 0; i < kCells; ++i) {
      columns[i] = static_cast<float>(first) + mColumns[i] + 0.5f;
      rows[i] = mRows[i] + 0.5f;
    }
    if (mFrame.jitter)
      for (std::int32_t row = mBegin; row < mEnd; ++row)
        for (std::int32_t c = first; c < smaller(first + kTile, mFrame.columns); ++c) {
          const kernels::RasterPoint p = mFrame.pointOf(std::int64_t{row} * mFrame.columns + c);
          columns[(row - mRow) * kTile + c - first] = static_cast<float>(p.column);
          rows[(row - mRow) * kTile + c - first] = static_cast<float>(p.row);
        }
    const F width(static_cast<float>(mFrame.columns - first)), begin(static_cast<float>(mBegin)),
        end(static_cast<float>(mEnd));
    alignas(64) float stops[kCells];
    for (float& stop : stops) stop = kernels::kNeverBends;
    if (mTask.stops)
      for (std::int32_t row = mBegin; row < mEnd; ++row)
        for (std::int32_t c = first; c < smaller(first + kTile, mFrame.columns); ++c)
          stops[(row - mRow) * kTile + c - first] = mTask.stops[std::int64_t{row} * mFrame.columns + c];
    for (int p = 0; p < kPackets; ++p) {
      const int i = p * Lanes::kLanes;
      rays.ray[p] = kernels::gridRay(mTask.view, Lanes::load(columns + i), Lanes::load(rows + i));
      rays.span[p] = kernels::lightSpan(mTask.medium, mTask.view, rays.ray[p]);
      const F stop = Lanes::load(stops + i);
      rays.stops[p] = stop < F(kernels::kNeverBends);
      rays.span[p].exit = smaller(rays.span[p].exit, stop);
      const F row = Lanes::load(mRows + i);
      const M asked = both(Lanes::load(mColumns + i) < width, both(row >= begin, row < end));
      rays.sees[p] = both(asked, rays.span[p].exit > rays.span[p].entry);
      rays.found[p] = F(kernels::kNeverBends);
    }
  }

  /// First bends of a tile's rays. False where there are none.
  bool search(std::int32_t tile, Rays& rays) const {
    const auto left = static_cast<float>(tile * kTile), top = static_cast<float>(mRow), size = float{kTile};
    const kernels::GridRay<float> corners[4] = {
        kernels::gridRay(mTask.view, left, top), kernels::gridRay(mTask.view, left + size, top),
        kernels::gridRay(mTask.view, left, top + size), kernels::gridRay(mTask.view, left + size, top + size)};
    const kernels::Beam<F> beam(mTask.medium, corners, nearest(tile), farthest(tile));
    const F nearestBend(nearest(tile)), farthestBend(farthest(tile));
    return beam.narrow() ? searchBySlabs(beam, nearestBend, farthestBend, rays)
                         : searchByRays(nearestBend, farthestBend, rays);
  }

  bool searchBySlabs(const kernels::Beam<F>& beam, F nearestBend, F farthestBend, Rays& rays) const {
    kernels::SlabSearch<F> searches[kPackets];
    bool looked = false;
    beam.forEachSlab([&](const kernels::SlabWindow& window) {
      if (!looked)
        for (int p = 0; p < kPackets; ++p)
          searches[p] = kernels::SlabSearch<F>(beam, rays.ray[p], larger(rays.span[p].entry, nearestBend),
                                               smaller(rays.span[p].exit, farthestBend), rays.sees[p]);
      looked = true;
      bool goesOn = false;
      for (kernels::SlabSearch<F>& search : searches) goesOn |= search.look(window, beam.forward());
      return goesOn;
    });
    if (looked)
      for (int p = 0; p < kPackets; ++p) rays.found[p] = searches[p].found();
    return looked;
  }

  /// The packets take turns: while one waits for its gathers, another one computes.
  bool searchByRays(F nearestBend, F farthestBend, Rays& rays) const {
    kernels::BendSearch<F> searches[kPackets];
    for (int p = 0; p < kPackets; ++p)
      searches[p] = kernels::BendSearch<F>(mTask.medium, rays.ray[p], larger(rays.span[p].entry, nearestBend),
                                           smaller(rays.span[p].exit, farthestBend), rays.sees[p]);
    for (bool goesOn = true; goesOn;) {
      goesOn = false;
      for (int p = 0; p < kPackets; ++p) {
        if (!searches[p].goesOn()) continue;
        searches[p].step(mTask.medium, rays.ray[p]);
        goesOn = true;
      }
    }
    for (int p = 0; p < kPackets; ++p) rays.found[p] = searches[p].found();
    return true;
  }

  void bookPacket(const Rays& rays, int p, const M& bends, F share) {
    const M sees = rays.sees[p], straight = both(sees, negate(bends));
    mTally.counts[static_cast<int>(Counter::Emitted)] += Lanes::count(sees);
    const M lands = both(straight, rays.stops[p]), escapes = both(straight, negate(rays.stops[p]));
    add(mEmitted, sees, share);
    if (mClear) {
      add(mEscaped, escapes, share);
      if (mTask.stops) add(mReceived, lands, share);
      return;
    }
    const F way = smaller(rays.found[p], rays.span[p].exit) - rays.span[p].entry;
    for (int c = 0; c < 3; ++c) {
      const float attenuation = mOptics.attenuation[c];
      const F kept = share * exponential(-(F(attenuation) * way));
      mKept[c].add(select(sees, kept, F(0)), mUnits[c]);
      mEscaped[c].add(select(escapes, kept, F(0)), mUnits[c]);
      if (mTask.stops) mReceived[c].add(select(lands, kept, F(0)), mUnits[c]);
      if (!(attenuation > 0)) continue;
      const double albedo = static_cast<double>(mOptics.scattering[c]) / static_cast<double>(attenuation);
      mScattered[c].add(select(sees, share - kept, F(0)), mUnits[c] * albedo);
    }
  }

  void add(Power& power, const M& on, F share) const {
    const F value = select(on, share, F(0));
    for (int c = 0; c < 3; ++c) power[c].add(value, mUnits[c]);
  }

  void settle() {
    for (int c = 0; c < 3; ++c) {
      book(Outcome::Emitted, c, mEmitted[c].total());
      book(Outcome::Escaped, c, mEscaped[c].total());
      book(Outcome::Received, c, mReceived[c].total());
      if (mClear) continue;
      book(Outcome::Scattered, c, mScattered[c].total());
      book(Outcome::Absorbed, c, mEmitted[c].total() - mKept[c].total() - mScattered[c].total());
    }
  }

  const EmissionTask& mTask;
  const kernels::EmissionFrame& mFrame;
  PhotonTally& mTally;
  const kernels::Optics& mOptics; ///< of the ambient medium
  const bool mClear;
  const std::int32_t mTileRow, mRow, mBelow; ///< first row of the tiles, and the one below them
  const std::int32_t mBegin, mEnd;           ///< rows asked for
  const kernels::Double3 mUnits;             ///< of the tally in the frame's strength
  std::int32_t mRunBegin = 0, mRunEnd = 0;   ///< tiles that bookRun has booked
  Power mEmitted, mEscaped, mReceived, mKept, mScattered;
  alignas(64) float mColumns[kCells], mRows[kCells]; ///< low corners of a tile's cells; columns from the tile's first
  alignas(64) float mTileColumns[kCells];            ///< first columns of tiles
};

/// LaneSet::findStops.
template <class F>
VOLCAUSTIC_HD inline void findStops(const StopTask& task) {
  using Lanes = Packet<F>;
  const kernels::EmissionFrame& frame = task.frame;
  // Parallel light comes from before the box.
  const F nearest(frame.point ? -task.view.depth0 : -kernels::kNeverBends);
  alignas(64) float columns[Lanes::kLanes], rows[Lanes::kLanes], stops[Lanes::kLanes];
  for (std::int32_t row = task.rows.begin; row < task.rows.end; ++row)
    for (std::int32_t first = 0; first < frame.columns; first += Lanes::kLanes) {
      const std::int32_t count = smaller(frame.columns - first, std::int32_t{Lanes::kLanes});
      for (std::int32_t i = 0; i < Lanes::kLanes; ++i) {
        const kernels::RasterPoint p = frame.pointOf(std::int64_t{row} * frame.columns + first + smaller(i, count - 1));
        columns[i] = static_cast<float>(p.column);
        rows[i] = static_cast<float>(p.row);
      }
      const kernels::GridRay<F> ray = kernels::gridRay(task.view, Lanes::load(columns), Lanes::load(rows));
      const auto all = nearest <= nearest;
      const kernels::ReceiverHit<F> hit =
          kernels::nearestHit<F>(task.receivers, ray.at, ray.direction, nearest, F(kernels::kNeverBends), all);
      Lanes::store(select(hit.triangle < kernels::IntOf<F>(0), F(kernels::kNeverBends), hit.distance), stops);
      for (std::int32_t i = 0; i < count; ++i) task.stops[std::int64_t{row} * frame.columns + first + i] = stops[i];
    }
}

} // namespace volcaustic::tiles
