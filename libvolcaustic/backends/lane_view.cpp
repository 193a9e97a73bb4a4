// The camera's rays in lanes (docs/algorithms/view.md). Compiled once for each instruction set of lanes.h.
//
// A register holds the rays of neighbouring pixels, a tile of 4x4 or half of one. They meet the same bricks at about
// the same time and end together, so lanes wait little for each other, and branches that skip work for all of them pay.

#include "backends/highway_lanes.h"
#include "backends/lanes.h"

#include <algorithm>

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

/// kernels::mixCell of light: four loads of two neighbours along z for each lane.
VOLCAUSTIC_HD static inline kernels::Vec3<Float> mixCell(const kernels::HalfVoxel* voxels, Int offset,
                                                         const kernels::Vec3<Float>& t) {
  constexpr int kX = kernels::kFieldEdge * kernels::kFieldEdge, kY = kernels::kFieldEdge;
  HWY_ALIGN std::int32_t at[kLanes];
  HWY_ALIGN float w00[kLanes], w01[kLanes], w10[kLanes], w11[kLanes], z[kLanes];
  const Float w1 = t.x * t.y;
  store(offset, at);
  store(w1, w11);
  store(t.x - w1, w10);
  store(t.y - w1, w01);
  store(Float(1) - t.x - t.y + w1, w00);
  store(t.z, z);
  const auto lane = [&](int i) __attribute__((always_inline)) {
    const hn::FixedTag<float, 8> pair;
    const hn::FixedTag<float, 4> one;
    const kernels::HalfVoxel* c = voxels + at[i];
    const auto two = [&](int k) __attribute__((always_inline)) {
      const auto bits = hn::LoadU(hn::FixedTag<std::uint16_t, 8>(), &c[k].x);
      return hn::PromoteTo(pair, hn::BitCast(hn::FixedTag<hwy::float16_t, 8>(), bits));
    };
    const auto a = hn::MulAdd(hn::Set(pair, w01[i]), two(kY), hn::Mul(hn::Set(pair, w00[i]), two(0)));
    const auto b = hn::MulAdd(hn::Set(pair, w11[i]), two(kX + kY), hn::Mul(hn::Set(pair, w10[i]), two(kX)));
    const auto sum = hn::Add(a, b);
    const auto low = hn::LowerHalf(one, sum), high = hn::UpperHalf(one, sum);
    return hn::MulAdd(hn::Set(one, z[i]), hn::Sub(high, low), low);
  };
  const FourFloats f = transposed(lane);
  return {f.of[0], f.of[1], f.of[2]};
}

namespace {

constexpr int kColumns = 4, kRows = kLanes / kColumns; ///< of pixels in a register
/// A register goes on with this many rays at least: the others wait until the tile's last ones are put together. A few
/// rays in a body go round for thousands of steps.
constexpr int kLeastRays = kLanes / 4;

class Viewer {
public:
  Viewer(const ViewTask& task, ViewCounts& counts)
      : mTask(task), mScene(task.scene), mScratch(task.scratch), mCounts(counts) {}

  void run() {
    for (std::int32_t s = mTask.firstSample; s < mTask.endSample; ++s) {
      // Down the columns: rays one above the other share lines of the cache, in which z runs fastest.
      for (std::int32_t c = 0; c < columns(); c += kColumns)
        for (std::int32_t r = 0; r < rows(); r += kRows) look(c, r, s);
      finishWaiting();
      merge(s);
    }
  }

private:
  [[nodiscard]] std::int32_t columns() const { return std::min(kViewTile, mScene.camera.width - mTask.column); }
  [[nodiscard]] std::int32_t rows() const { return std::min(kViewTile, mScene.camera.height - mTask.row); }

  /// The pixels of a register; column and row in the tile.
  void look(std::int32_t column, std::int32_t row, std::int32_t sample) {
    alignas(64) double pointColumns[kLanes], pointRows[kLanes];
    alignas(64) std::int32_t pixels[kLanes];
    alignas(64) float on[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const std::int32_t c = column + i % kColumns, r = row + i / kColumns;
      const auto at = mScene.sampler.point(mTask.column + c, mTask.row + r, sample);
      pointColumns[i] = at.column;
      pointRows[i] = at.row;
      pixels[i] = r * kViewTile + c;
      on[i] = c < columns() && r < rows();
    }
    Mask hits;
    kernels::ViewRay<Float> r =
        kernels::lookThrough<Float>(mScene, load(pointColumns), load(pointRows), load(on) > Float(0), hits);
    const Mask waiting = carry(r, hits, kLeastRays);
    put<kColumns>(r, negate(waiting), pixels, kRows);
    if (any(waiting)) wait(r, load(pixels), waiting);
  }

  /// Carries rays on as long as there are as many. \return those left
  Mask carry(kernels::ViewRay<Float>& r, const Mask& on, int least) {
    const Mask none = both(on, negate(on));
    kernels::RayEnd<Float> end{none, none};
    const Mask left = kernels::ViewMarch<Float>(mScene).run(
        r, on, end, [least](const Mask& alive) __attribute__((always_inline)) { return count(alive) >= least; });
    alignas(64) std::int32_t steps[kLanes];
    store(select(both(on, negate(left)), r.steps, Int(0)), steps);
    for (const std::int32_t n : steps) mCounts.steps += n;
    mCounts.notFinite += count(end.notFinite);
    mCounts.stepLimit += count(end.stepLimit);
    return left;
  }

  /// Writes what rays have seen into the planes of the tile: `count` times `run` side by side. Those that have not
  /// `ended` are written again when they have.
  template <int run>
  void put(kernels::ViewRay<Float>& r, const Mask& ended, const std::int32_t* pixels, int count) {
    mTask.planes.forEach<Float>(
        kernels::seen(mScene, r, ended), [&](int plane, Float v) __attribute__((always_inline)) {
          alignas(64) float numbers[kLanes];
          store(v, numbers);
          for (int i = 0; i < count * run; i += run) std::copy_n(numbers + i, run, mScratch.planes[plane] + pixels[i]);
        });
  }

  void wait(kernels::ViewRay<Float>& r, Int pixels, const Mask& on) {
    const Squeeze squeeze(on);
    const auto keep = [&](std::int32_t* to, Int v) {
      alignas(64) std::int32_t numbers[kLanes];
      store(squeeze(v), numbers);
      std::copy_n(numbers, squeeze.count(), to + mWaiting);
    };
    r.forEach([&](int i, auto& v) { keep(mScratch.rays[i], bitsOf(v)); });
    keep(mScratch.pixels, pixels);
    mWaiting += squeeze.count();
  }

  void finishWaiting() {
    for (int first = 0; first < mWaiting; first += kLanes) {
      const int rays = std::min(kLanes, mWaiting - first);
      const Mask on = firstLanes(rays);
      kernels::ViewRay<Float> r;
      r.forEach([&](int i, auto& v) {
        alignas(64) std::int32_t numbers[kLanes];
        for (int k = 0; k < kLanes; ++k) numbers[k] = mScratch.rays[i][first + (k < rays ? k : 0)];
        fromBits(load(numbers), v);
      });
      carry(r, on, 1);
      put<1>(r, on, mScratch.pixels + first, rays);
    }
    mWaiting = 0;
  }
  static Int bitsOf(Int v) { return v; }
  static Int bitsOf(Float v) { return Int(hn::BitCast(IntTag(), v.v)); }
  static void fromBits(Int bits, Int& v) { v = bits; }
  static void fromBits(Int bits, Float& v) { v = floatOfBits(bits); }

  void merge(std::int32_t sample) {
    for (std::int32_t r = 0; r < rows(); ++r)
      mTask.planes.add(std::int64_t{mTask.row + r} * mScene.camera.width + mTask.column, columns(), sample,
                       [&](int plane) { return mScratch.planes[plane] + r * kViewTile; });
  }

  const ViewTask& mTask;
  const kernels::ViewScene& mScene;
  ViewScratch& mScratch;
  ViewCounts& mCounts;
  int mWaiting = 0;
};

} // namespace

void view(const ViewTask& task, ViewCounts& counts) { Viewer(task, counts).run(); }

void addCorners(const kernels::FluenceField& field, const std::int32_t (&entries)[8], const CornerVoxels& voxels,
                bool directions, CornerLight& light) {
  std::int32_t table[kernels::kLookUpSize] = {};
  std::copy(std::begin(entries), std::end(entries), table);
  for (int k = 0; k < kernels::kFieldVoxels; k += kLanes) {
    const Int entry = lookUp(table, load(voxels.brick + k)), offset = load(voxels.offset + k);
    const Mask stored = entry > Int(0), constant = entry < Int(0);
    kernels::LightOf<Float> sum;
    if (any(stored))
      kernels::addUnpacked<Float>(sum, loadVoxel(field.voxels, select(stored, entry - Int(1), Int(0)), offset),
                                  select(stored, Float(1), Float(0)), directions);
    if (any(constant)) {
      const Int number = select(constant, ~entry, Int(0));
      kernels::addUnpacked<Float>(sum, loadVoxel(field.constants, number >> 9, number & Int(kernels::kStepVoxels - 1)),
                                  select(constant, Float(1), Float(0)), directions);
    }
    const kernels::Vec3<Float>& add = directions ? sum.towards : sum.fluence;
    for (int i = 0; i < 3; ++i) store(load(light.of[i] + k) + add[i], light.of[i] + k);
  }
}

std::int32_t packCorners(const CornerLight& light, kernels::HalfVoxel* out) {
  const hn::FixedTag<float, 8> eight;
  const hn::FixedTag<std::uint16_t, 8> bits;
  auto most = hn::Zero(eight);
  for (const auto& part : light.of)
    for (int k = 0; k < kCornersPadded; k += 8) most = hn::Max(most, hn::Abs(hn::Load(eight, part + k)));
  const std::int32_t unit = kernels::textureUnitFor(hn::GetLane(hn::MaxOfLanes(eight, most)));
  if (unit == 0) return 0;
  const auto scale = hn::Set(eight, kernels::inverseOfUnit(unit));
  const auto halves = [&](int part, int k) __attribute__((always_inline)) {
    const auto v = hn::Mul(hn::Load(eight, light.of[part] + k), scale);
    return hn::BitCast(bits, hn::DemoteTo(hn::FixedTag<hwy::float16_t, 8>(), v));
  };
  alignas(64) std::uint16_t last[4 * 8];
  for (int k = 0; k < kernels::kFieldVoxels; k += 8) {
    const bool whole = k + 8 <= kernels::kFieldVoxels;
    hn::StoreInterleaved4(halves(0, k), halves(1, k), halves(2, k), hn::Zero(bits), bits, whole ? &out[k].x : last);
    if (!whole) std::copy_n(last, 4 * (kernels::kFieldVoxels - k), &out[k].x);
  }
  return unit;
}

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
