// The march of photons in lanes (docs/algorithms/photons.md, "Lanes"). Compiled once for each instruction set of
// lanes.h.
//
// A worker holds kPackets packets of photons. Each round takes one step of every packet: the steps of different packets
// do not wait for each other, so one's gathers overlap another's arithmetic. A photon that ends is replaced by the next
// of the list in the same lane.
//
// The short chords of a step, where light bends, are collected, rasterised a register at a time into a list of voxels
// crossed, and the list is added to the sums in a loop without a branch that depends on the data. Long chords, straight
// ways through many voxels, are put aside for lane_blocks.cpp.

#include "backends/cpu_sink.h"
#include "backends/highway_lanes.h"

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace {

using kernels::ChordOf;
using kernels::Counter;
using kernels::Outcome;
using kernels::Vec3;

constexpr int kPackets = 4;
constexpr int kPhotons = kPackets * kLanes;

/// Chords waiting to be rasterised.
class ChordList {
public:
  static constexpr int kCapacity = 512;

  explicit ChordList(bool decays) : mDecays(decays) {}

  [[nodiscard]] bool decays() const { return mDecays; }
  [[nodiscard]] int size() const { return mSize; }
  void clear() { mSize = 0; }
  [[nodiscard]] bool hasRoom() const { return mSize + kLanes <= kCapacity; }

  void append(const ChordOf<Float>& c, Float scale, const Mask& on) {
    const Squeeze squeeze(on);
    store(squeeze(c.start.x), x + mSize);
    store(squeeze(c.start.y), y + mSize);
    store(squeeze(c.start.z), z + mSize);
    store(squeeze(c.direction.x), dx + mSize);
    store(squeeze(c.direction.y), dy + mSize);
    store(squeeze(c.direction.z), dz + mSize);
    store(squeeze(c.length), length + mSize);
    storeRate(c.power * scale, c.direction, squeeze, rates);
    if (mDecays) storeRate(c.slope * scale, c.direction, squeeze, slopes);
    mSize += squeeze.count();
  }

  // A register beyond the end may be written and read; its lanes are masked.
  alignas(64) float x[kCapacity + kLanes], y[kCapacity + kLanes], z[kCapacity + kLanes], dx[kCapacity + kLanes],
      dy[kCapacity + kLanes], dz[kCapacity + kLanes], length[kCapacity + kLanes];
  /// What each chord adds to a voxel for each unit of length, in fixed-point units: RGB and 0, direction and 0. Then
  /// how that changes along it, where the medium attenuates.
  struct Rates {
    alignas(64) float power[kCapacity + kLanes][4], direction[kCapacity + kLanes][4];
  } rates, slopes;

private:
  void storeRate(const Vec3<Float>& power, const Vec3<Float>& towards, const Squeeze& squeeze, Rates& out) const {
    const Vec3<Float> direction = towards * kernels::luminance(power);
    const auto zero = hn::Zero(FloatTag());
    hn::StoreInterleaved4(squeeze(power.x).v, squeeze(power.y).v, squeeze(power.z).v, zero, FloatTag(),
                          out.power[mSize]);
    hn::StoreInterleaved4(squeeze(direction.x).v, squeeze(direction.y).v, squeeze(direction.z).v, zero, FloatTag(),
                          out.direction[mSize]);
  }

  bool mDecays;
  int mSize = 0;
};

/// Voxels crossed: where, for how long, and by which chord of the list.
class CrossingList {
public:
  using Address = kernels::BrickCells::Address<Float>;
  static constexpr int kCapacity = 1024;

  [[nodiscard]] bool hasRoom() const { return mSize + 3 * kLanes <= kCapacity; }

  /// `half` is half the length of each chord.
  void append(const kernels::SlabCrossing<Float, Address>& c, Int chord, Float half, const Mask& on) {
    append(c.first, chord, half, on);
    append(c.second, chord, half, on);
    append(c.third, chord, half, on);
  }
  /// Adds every crossing to the sums.
  void drain(const ChordList& chords, CpuSums& sums) {
    if (chords.decays())
      drain<true>(chords, sums);
    else
      drain<false>(chords, sums);
    sums.tally.counts.data()[static_cast<int>(Counter::VoxelsCrossed)] += mSize;
    mSize = 0;
  }

private:
  void append(const kernels::CrossedCell<Float, Address>& v, Int chord, Float half, const Mask& on) {
    const Squeeze squeeze(both(on, v.length > Float(0)));
    store(squeeze(v.at.brick), mBrick + mSize);
    store(squeeze(v.at.offset), mOffset + mSize);
    store(squeeze(chord), mChord + mSize);
    store(squeeze(v.length), mLength + mSize);
    store(squeeze(v.middle - half), mMiddle + mSize);
    mSize += squeeze.count();
  }

  template <bool kDecays>
  void drain(const ChordList& chords, CpuSums& sums) {
    const hn::FixedTag<float, 8> eight;
    const hn::FixedTag<std::int32_t, 8> integers;
    const auto of = [&](const ChordList::Rates& r, std::int32_t chord) {
      const hn::FixedTag<float, 4> four;
      return hn::Combine(eight, hn::Load(four, r.direction[chord]), hn::Load(four, r.power[chord]));
    };
    LightBricks::Brick* const* table = sums.bricks.table();
    for (int i = 0; i < mSize; ++i) {
      if (!table[mBrick[i]]) [[unlikely]]
        sums.bricks.allocate(mBrick[i]);
      std::int32_t* at = reinterpret_cast<std::int32_t*>(table[mBrick[i]]) + std::ptrdiff_t{8} * mOffset[i];
      auto rate = of(chords.rates, mChord[i]);
      if constexpr (kDecays) rate = hn::MulAdd(of(chords.slopes, mChord[i]), hn::Set(eight, mMiddle[i]), rate);
      const auto added = roundedProduct(rate, hn::Set(eight, mLength[i]));
      const auto sum = hn::Add(hn::Load(integers, at), added);
      hn::Store(sum, integers, at);
      // The sign of sum + kCarryAt changes where a sum is at or beyond the range that it may keep.
      const auto beyond = hn::Add(sum, hn::Set(integers, LightBricks::kCarryAt));
      if (!hn::AllFalse(integers, hn::MaskFromVec(hn::BroadcastSignBit(beyond)))) [[unlikely]]
        sums.bricks.carry(mBrick[i], mOffset[i]);
    }
  }

  std::int32_t mBrick[kCapacity + kLanes], mOffset[kCapacity + kLanes], mChord[kCapacity + kLanes];
  float mLength[kCapacity + kLanes], mMiddle[kCapacity + kLanes]; ///< mMiddle: from the chord's middle
  int mSize = 0;
};

/// Short chords to the sums, long ones to the list of those.
class Rasteriser {
public:
  Rasteriser(const kernels::FlatMedium& medium, CpuSums& sums, float scale, FarChords& far)
      : mCells{medium.dims, medium.brickDims}, mSums(sums), mScale(scale), mFar(far), mShort(medium.attenuates) {}

  void add(const ChordOf<Float>& chord, const Mask& on) {
    const Mask isLong = both(on, chord.length > Float(kLongest));
    if (!mShort.hasRoom()) flush();
    mShort.append(chord, mScale, any(isLong) ? both(on, negate(isLong)) : on);
    if (any(isLong)) putAside(chord, isLong);
  }

  void flush() {
    for (int i = 0; i < mShort.size(); i += kLanes) {
      const Mask on = firstLanes(mShort.size() - i);
      const Float length = load(mShort.length + i), half = Float(0.5f) * length;
      const kernels::SlabChord<Float, kernels::BrickCells> slabs(
          mCells, load3(mShort.x + i, mShort.y + i, mShort.z + i), load3(mShort.dx + i, mShort.dy + i, mShort.dz + i),
          length);
      const Int number = Int(hn::Iota(IntTag(), i));
      for (Int k(0);; k = k + Int(1)) {
        const Mask reaching = both(on, k < slabs.slabs());
        if (!any(reaching)) break;
        if (!mCrossings.hasRoom()) mCrossings.drain(mShort, mSums);
        mCrossings.append(slabs.crossing(k), number, half, reaching);
      }
    }
    mCrossings.drain(mShort, mSums);
    mShort.clear();
  }

private:
  static constexpr float kLongest = 3; ///< voxels, of a chord that is short

  void putAside(const ChordOf<Float>& c, const Mask& on) {
    constexpr int kNumbers = 13;
    alignas(64) float columns[kNumbers][kLanes];
    const Float values[kNumbers] = {c.start.x,     c.start.y, c.start.z, c.direction.x, c.direction.y,
                                    c.direction.z, c.length,  c.power.x, c.power.y,     c.power.z,
                                    c.slope.x,     c.slope.y, c.slope.z};
    const Squeeze squeeze(on);
    for (int i = 0; i < kNumbers; ++i) store(squeeze(values[i]), columns[i]);
    FarChord chords[kLanes];
    for (int k = 0; k < squeeze.count(); ++k) {
      FarChord& f = chords[k];
      for (int i = 0; i < 3; ++i) {
        f.start[i] = columns[i][k];
        f.direction[i] = columns[3 + i][k];
        f.power[i] = columns[7 + i][k];
        f.slope[i] = columns[10 + i][k];
      }
      f.length = columns[6][k];
      f.unused = 0;
    }
    mFar.append(chords, squeeze.count());
    countVoxels(c, on);
  }

  /// A voxel more for each face between voxels on the way.
  void countVoxels(const ChordOf<Float>& c, const Mask& on) {
    const auto faces = [&](Float start, Float direction, std::int32_t dim) {
      const auto cell = [dim](Float p) { return kernels::clampTo(toInt(p), Int(0), Int(dim - 1)); };
      return absOf(toFloat(cell(mulAdd(direction, c.length, start)) - cell(start)));
    };
    const Float crossed = Float(1) + faces(c.start.x, c.direction.x, mCells.dims.x) +
                          faces(c.start.y, c.direction.y, mCells.dims.y) +
                          faces(c.start.z, c.direction.z, mCells.dims.z);
    const Float sum(hn::SumOfLanes(FloatTag(), select(on, crossed, Float(0)).v));
    mSums.tally.counts.data()[static_cast<int>(Counter::VoxelsCrossed)] +=
        static_cast<std::int64_t>(hn::GetLane(sum.v));
  }

  kernels::BrickCells mCells;
  CpuSums& mSums;
  Float mScale;
  FarChords& mFar;
  ChordList mShort;
  CrossingList mCrossings;
};

/// The photons in flight, number by number, so that any lane can be read and replaced.
struct Flight {
  alignas(64) float x[kPhotons], y[kPhotons], z[kPhotons], vx[kPhotons], vy[kPhotons], vz[kPhotons];
  alignas(64) float fromX[kPhotons], fromY[kPhotons], fromZ[kPhotons];
  alignas(64) float power[3][kPhotons], scattered[3][kPhotons], threshold[kPhotons];
  alignas(64) std::int32_t steps[kPhotons], optics[kPhotons], alive[kPhotons];
  alignas(64) float mirrors[kernels::kPhotonMirrorNumbers][kPhotons]; ///< held where photons may be reflected
  kernels::Float3 first[kPhotons];
  kernels::Double3 gained[kPhotons];
  std::uint32_t cell[kPhotons];

  [[nodiscard]] kernels::PhotonOf<Float> get(int at) const {
    return {{load3(x + at, y + at, z + at), load3(vx + at, vy + at, vz + at)},
            load3(power[0] + at, power[1] + at, power[2] + at),
            load3(scattered[0] + at, scattered[1] + at, scattered[2] + at),
            load(threshold + at),
            load(steps + at),
            load3(fromX + at, fromY + at, fromZ + at),
            load(optics + at)};
  }
  void put(int at, const kernels::PhotonOf<Float>& p) {
    store(p.ray.x.x, x + at), store(p.ray.x.y, y + at), store(p.ray.x.z, z + at);
    store(p.ray.v.x, vx + at), store(p.ray.v.y, vy + at), store(p.ray.v.z, vz + at);
    store(p.power.x, power[0] + at), store(p.power.y, power[1] + at), store(p.power.z, power[2] + at);
    store(p.scattered.x, scattered[0] + at), store(p.scattered.y, scattered[1] + at);
    store(p.scattered.z, scattered[2] + at), store(p.steps, steps + at), store(p.optics, optics + at);
    store(p.from.x, fromX + at), store(p.from.y, fromY + at), store(p.from.z, fromZ + at);
  }
  [[nodiscard]] kernels::Photon photon(int i) const {
    return {{{x[i], y[i], z[i]}, {vx[i], vy[i], vz[i]}},
            {power[0][i], power[1][i], power[2][i]},
            {scattered[0][i], scattered[1][i], scattered[2][i]},
            threshold[i],
            steps[i],
            {fromX[i], fromY[i], fromZ[i]},
            optics[i]};
  }
  [[nodiscard]] kernels::PhotonMirror<Float> mirrorsAt(int at) const {
    kernels::PhotonMirror<Float> m;
    int k = 0;
    m.forEach([&](Float & v) __attribute__((always_inline)) { v = load(mirrors[k++] + at); });
    return m;
  }
  void putMirrors(int at, kernels::PhotonMirror<Float>& m) {
    int k = 0;
    m.forEach([&](Float & v) __attribute__((always_inline)) { store(v, mirrors[k++] + at); });
  }
  [[nodiscard]] kernels::PhotonMirror<float> mirror(int i) const {
    kernels::PhotonMirror<float> m;
    int k = 0;
    m.forEach([&](float& v) { v = mirrors[k++][i]; });
    return m;
  }
  void setMirror(int i, kernels::PhotonMirror<float> m) {
    int k = 0;
    m.forEach([&](float& v) { mirrors[k++][i] = v; });
  }
  void set(int i, const kernels::Photon& p) {
    x[i] = p.ray.x.x, y[i] = p.ray.x.y, z[i] = p.ray.x.z;
    vx[i] = p.ray.v.x, vy[i] = p.ray.v.y, vz[i] = p.ray.v.z;
    power[0][i] = p.power.x, power[1][i] = p.power.y, power[2][i] = p.power.z;
    scattered[0][i] = p.scattered.x, scattered[1][i] = p.scattered.y, scattered[2][i] = p.scattered.z;
    threshold[i] = p.threshold, steps[i] = p.steps, optics[i] = p.optics;
    fromX[i] = p.from.x, fromY[i] = p.from.y, fromZ[i] = p.from.z;
  }
  void move(int i, int to) {
    set(to, photon(i));
    first[to] = first[i], gained[to] = gained[i], cell[to] = cell[i], alive[to] = alive[i];
    for (auto& numbers : mirrors) numbers[to] = numbers[i];
    alive[i] = 0;
  }
};

class Tracer {
public:
  Tracer(const PhotonTask& task, CpuSums& sums, FarChords& far)
      : mTask(task)
      , mSink(sums, task.scale)
      , mRasteriser(task.medium, sums, static_cast<float>(task.scale.deposit), far) {}

  void run() {
    for (int i = 0; i < kPhotons; ++i) {
      // Lanes that never held a photon must hold something finite.
      mFlight.set(i, {{{0, 0, 0}, {1, 0, 0}}, {0, 0, 0}, {0, 0, 0}, 0, 0, {0, 0, 0}, 0});
      mFlight.setMirror(i, {});
      launch(i);
    }
    while (mAlive > 0) {
      for (int packet = 0; packet < mInUse; packet += kLanes) step(packet);
      if (mNext == mTask.count && mAlive <= mInUse - kLanes) closeRanks();
    }
    mRasteriser.flush();
  }

private:
  /// At the list's end: moves the last packet's photons to empty lanes of the others.
  void closeRanks() {
    const int last = mInUse - kLanes;
    int empty = 0;
    for (int i = last; i < mInUse; ++i) {
      if (!mFlight.alive[i]) continue;
      while (mFlight.alive[empty]) ++empty;
      mFlight.move(i, empty);
    }
    mInUse = last;
  }

  /// Puts the list's next photon into a lane, or leaves the lane empty at the list's end.
  void launch(int i) {
    mFlight.alive[i] = 0;
    if (mNext == mTask.count) return;
    const std::uint32_t cell = mTask.cells[mNext++];
    const kernels::Photon p = kernels::startPhoton(mTask.medium, mTask.frame, mTask.rules, cell, mTask.entry[cell]);
    mFlight.set(i, p);
    mFlight.setMirror(i, {});
    mFlight.first[i] = p.power;
    mFlight.gained[i] = kernels::Double3(0, 0, 0);
    mFlight.cell[i] = cell;
    mFlight.alive[i] = -1;
    ++mAlive;
  }

  void step(int at) {
    const Mask alive = load(mFlight.alive + at) != Int(0);
    if (!any(alive)) return;
    kernels::PhotonOf<Float> p = mFlight.get(at);
    const auto advance = [&](kernels::PhotonMirror<Float> * mirror) __attribute__((always_inline)) {
      return kernels::stepPhoton(mTask.medium, mTask.rules, p, mirror, alive,
                                 [&](const ChordOf<Float>& chord, const Mask& on) { mRasteriser.add(chord, on); });
    };
    if (!mTask.rules.fresnel) {
      const kernels::StepOutcome<Float> outcome = advance(nullptr);
      mFlight.put(at, p);
      endThose(at, outcome, alive);
      return;
    }
    kernels::PhotonMirror<Float> mirror = mFlight.mirrorsAt(at);
    const kernels::StepOutcome<Float> outcome = advance(&mirror);
    mFlight.put(at, p);
    mFlight.putMirrors(at, mirror);
    const Mask reflects = both(alive, outcome.reflection.on);
    if (any(reflects)) [[unlikely]]
      reflectSome(at, outcome.reflection, reflects);
    endThose(at, outcome, alive);
  }

  VOLCAUSTIC_HD void endThose(int at, const kernels::StepOutcome<Float>& outcome, const Mask& alive) {
    const Mask ends = both(alive, either(either(either(outcome.leaves, outcome.lands), outcome.notFinite),
                                         either(outcome.fades, outcome.limit)));
    if (any(ends)) [[unlikely]]
      endSome(at, outcome, ends);
  }

  static std::uint32_t bits(const Mask& m) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(FloatTag(), m.m, bytes);
    return static_cast<std::uint32_t>(bytes[0] | bytes[1] << 8);
  }

  /// Sends photons back by their chances.
  void reflectSome(int at, const kernels::Reflection<Float>& all, const Mask& on) {
    constexpr int kNumbers = 11;
    alignas(64) float numbers[kNumbers][kLanes];
    const Float values[kNumbers] = {all.share,  all.rise,   all.to.x.x,  all.to.x.y,  all.to.x.z, all.to.v.x,
                                    all.to.v.y, all.to.v.z, all.light.x, all.light.y, all.light.z};
    for (int k = 0; k < kNumbers; ++k) store(values[k], numbers[k]);
    for (std::uint32_t left = bits(on); left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left), i = at + lane;
      const auto n = [&](int k) { return numbers[k][lane]; };
      const kernels::Reflection<float> r{
          true, n(0), {{n(2), n(3), n(4)}, {n(5), n(6), n(7)}}, n(1), {n(8), n(9), n(10)}};
      kernels::Photon p = mFlight.photon(i);
      kernels::PhotonMirror<float> mirror = mFlight.mirror(i);
      if (!kernels::reflectByChance(mTask.medium, mTask.rules, mFlight.cell[i], r, p, mirror)) continue;
      mFlight.set(i, p);
      mFlight.setMirror(i, mirror);
    }
  }

  /// Books the photons that end, and fills their lanes.
  void endSome(int at, const kernels::StepOutcome<Float>& outcome, const Mask& ends) {
    const std::uint32_t leaves = bits(outcome.leaves), notFinite = bits(outcome.notFinite), fades = bits(outcome.fades),
                        lands = bits(both(ends, outcome.lands));
    alignas(64) float distances[kLanes], firsts[kLanes], seconds[kLanes];
    alignas(64) std::int32_t triangles[kLanes];
    if (lands != 0) {
      store(outcome.hit.distance, distances), store(outcome.hit.b1, firsts), store(outcome.hit.b2, seconds);
      store(outcome.hit.triangle, triangles);
    }
    for (std::uint32_t left = bits(ends); left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left), i = at + lane;
      const std::uint32_t bit = 1u << lane;
      kernels::Photon p = mFlight.photon(i);
      Outcome end = Outcome::CutOff;
      if (notFinite & bit) {
        mSink.count(Counter::NotFinite, 1);
      } else if (lands & bit) {
        kernels::land(mTask.rules.receivers, {distances[lane], triangles[lane], firsts[lane], seconds[lane]}, p,
                      landingOf(i));
        end = Outcome::Received;
      } else if (leaves & bit) {
        end = kernels::landBeyond(mTask.rules, p, landingOf(i));
      } else if (!(fades & bit) || !kernels::endsByRoulette(mTask.rules, mFlight.cell[i], p, mFlight.gained[i])) {
        if (p.steps < mTask.rules.maxSteps) { // roulette lets it live
          mFlight.set(i, p);
          continue;
        }
        mSink.count(Counter::StepLimit, 1);
      }
      kernels::bookEnd(mSink, end, p, mFlight.first[i], mFlight.gained[i]);
      --mAlive;
      launch(i);
    }
  }

  [[nodiscard]] kernels::Landing* landingOf(int i) const {
    return mTask.landings ? mTask.landings + mFlight.cell[i] : nullptr;
  }

  const PhotonTask& mTask;
  CpuSink mSink;
  Rasteriser mRasteriser;
  Flight mFlight;
  std::int64_t mNext = 0, mAlive = 0;
  int mInUse = kPhotons; ///< lanes of the packets that are stepped
};

} // namespace

void tracePhotons(const PhotonTask& task, CpuSums& sums, FarChords& far) {
  Tracer tracer(task, sums, far);
  tracer.run();
}

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
