// The search of many rays at once: a beam, the rays between four, goes through the medium in slabs of one voxel across
// the axis that it is most along. The bends of a slab's few voxels are brought into one small window, where all rays
// look theirs up.
#pragma once

#include "kernels/bend_search.h"

namespace volcaustic::kernels {

/// Bends of a slab's voxels around a beam: bit v - v0 of row u - u0.
struct SlabWindow {
  static constexpr std::int32_t kRows = kLookUpSize, kColumns = 31;

  std::int32_t u0, v0;
  std::int32_t low = 0; ///< the slab is [low, low + 1]
  alignas(64) std::int32_t rows[kRows] = {};

  VOLCAUSTIC_HD SlabWindow(std::int32_t u0_, std::int32_t v0_) : u0(u0_), v0(v0_) {}
};

/// A beam in single numbers: where its slabs are, and what is in them. F names the lanes that help.
template <class F>
class Beam {
public:
  /// Four rays whose points in any plane are the corners of a convex shape, and bounds of the distance at which the
  /// beam can bend.
  VOLCAUSTIC_HD Beam(const FlatMedium& m, const GridRay<float> (&corners)[4], float nearest, float farthest)
      : mMedium(m), mAxis(dominant(corners[0].direction)) {
    float first = 1e30f, last = -1e30f;
    for (int i = 0; i < 4; ++i) {
      const Float3 at = sorted(corners[i].at), d = sorted(corners[i].direction);
      if (i == 0) mForward = d.x > 0;
      if ((d.x > 0) != mForward || absOf(d.x) < larger(absOf(d.y), absOf(d.z))) return;
      const float inverse = 1 / d.x;
      mSlopeU[i] = d.y * inverse;
      mSlopeV[i] = d.z * inverse;
      mU[i] = at.y - mSlopeU[i] * at.x;
      mV[i] = at.z - mSlopeV[i] * at.x;
      const float a = at.x + nearest * d.x, b = at.x + farthest * d.x;
      first = smaller(first, smaller(a, b));
      last = larger(last, larger(a, b));
    }
    const Int3 dims = sorted(m.dims);
    const auto slab = [&](float w) {
      return static_cast<std::int32_t>(clampTo(w, 0.0f, static_cast<float>(dims.x - 1)));
    };
    mFirst = slab(first - kSlack);
    mLast = slab(last + kSlack);
    mLastU = dims.y - 1;
    mLastV = dims.z - 1;
    // Its width is convex along it.
    mNarrow = fits(plane(mFirst & ~7), plane((mFirst & ~7) + 8)) && fits(plane(mLast & ~7), plane((mLast & ~7) + 8));
  }

  /// Whether slab by slab is the way: no ray crosses more than one face of another axis in a slab, and all rays fit
  /// into a window.
  [[nodiscard]] VOLCAUSTIC_HD bool narrow() const { return mNarrow; }
  [[nodiscard]] VOLCAUSTIC_HD bool forward() const { return mForward; }

  /// Calls visit(window) for each slab with bends, in the order of the light, until visit returns false.
  template <class Visit>
  VOLCAUSTIC_HD void forEachSlab(const Visit& visit) const {
    const std::int32_t step = mForward ? 1 : -1, end = mForward ? mLast + 1 : mFirst - 1;
    for (std::int32_t w = mForward ? mFirst : mLast; w != end;) {
      const std::int32_t behind = (mForward ? smaller(w | 7, mLast) : larger(w & ~7, mFirst)) + step;
      Layer layer;
      if (!load(layer, w >> 3)) {
        w = behind;
        continue;
      }
      SlabWindow window(layer.inside.u0, layer.inside.v0 & ~7);
      for (; w != behind; w += step)
        if ((layer.bends & slabBits(w)) != 0 && fill(window, layer, w) && !visit(window)) return;
    }
  }

  /// The beam's axis first, the others as they come.
  template <class T>
  VOLCAUSTIC_HD Vec3<T> sorted(const Vec3<T>& v) const {
    return mAxis == 0 ? v : mAxis == 1 ? Vec3<T>(v.y, v.x, v.z) : Vec3<T>(v.z, v.x, v.y);
  }

private:
  static constexpr float kSlack = 1e-2f; ///< voxels; rounding must not hide a voxel

  struct Rectangle {
    std::int32_t u0, u1, v0, v1; ///< voxels, both ends included
    VOLCAUSTIC_HD bool empty() const { return u1 < u0 || v1 < v0; }
  };
  /// What the beam's rays keep to in a plane.
  struct Plane {
    float u0 = 1e30f, u1 = -1e30f, v0 = 1e30f, v1 = -1e30f;
  };
  /// The beam in a layer of bricks, and their bends bit by bit: a word for each x, a byte for each y.
  struct Layer {
    static constexpr std::int32_t kHigh = SlabWindow::kRows / 8 + 1, kWide = SlabWindow::kColumns / 8 + 2;
    Plane low, high;
    Rectangle inside;
    std::uint64_t bends; ///< slabBits(w) of it are zero where a slab has none
    std::uint64_t words[kHigh][kWide][8];
  };

  VOLCAUSTIC_HD static int dominant(const Float3& d) {
    const Float3 a(absOf(d.x), absOf(d.y), absOf(d.z));
    return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  }
  VOLCAUSTIC_HD Int3 unsorted(std::int32_t w, std::int32_t u, std::int32_t v) const {
    return mAxis == 0 ? Int3(w, u, v) : mAxis == 1 ? Int3(u, w, v) : Int3(u, v, w);
  }
  /// The bits of a slab's voxels in a word; for axis 0 each word is a slab, and has its byte in Layer::bends.
  VOLCAUSTIC_HD std::uint64_t slabBits(std::int32_t w) const {
    return mAxis == 2 ? std::uint64_t{0x0101010101010101} << (w & 7) : std::uint64_t{0xff} << (8 * (w & 7));
  }
  /// Whether the beam between two planes fits into a window wherever that begins.
  VOLCAUSTIC_HD static bool fits(const Plane& a, const Plane& b) {
    constexpr float kTouched = 2 + 2 * kSlack, kAlign = 7;
    return larger(a.u1, b.u1) - smaller(a.u0, b.u0) + kTouched < SlabWindow::kRows &&
           larger(a.v1, b.v1) - smaller(a.v0, b.v0) + kTouched + kAlign < SlabWindow::kColumns;
  }

  VOLCAUSTIC_HD Plane plane(std::int32_t at) const {
    const auto w = static_cast<float>(at);
    Plane p;
    for (int i = 0; i < 4; ++i) {
      const float u = mU[i] + mSlopeU[i] * w, v = mV[i] + mSlopeV[i] * w;
      p.u0 = smaller(p.u0, u);
      p.u1 = larger(p.u1, u);
      p.v0 = smaller(p.v0, v);
      p.v1 = larger(p.v1, v);
    }
    return p;
  }
  VOLCAUSTIC_HD Rectangle between(const Plane& a, const Plane& b) const {
    return voxels(smaller(a.u0, b.u0) - kSlack, larger(a.u1, b.u1) + kSlack, smaller(a.v0, b.v0) - kSlack,
                  larger(a.v1, b.v1) + kSlack);
  }
  /// The beam in a slab of a layer. Between two planes what four rays keep to is convex: straight lines enclose it.
  VOLCAUSTIC_HD Rectangle slabOf(const Layer& layer, std::int32_t w) const {
    const auto at = [](float a, float b, float part) { return a + (b - a) * part; };
    const auto plane = [&](float part) -> Plane {
      return {at(layer.low.u0, layer.high.u0, part), at(layer.low.u1, layer.high.u1, part),
              at(layer.low.v0, layer.high.v0, part), at(layer.low.v1, layer.high.v1, part)};
    };
    const float part = static_cast<float>(w & 7) * 0.125f;
    return between(plane(part), plane(part + 0.125f));
  }
  VOLCAUSTIC_HD Rectangle voxels(float u0, float u1, float v0, float v1) const {
    const auto from = [](float a) { return static_cast<std::int32_t>(larger(a, 0.0f)); };
    const auto to = [](float a, std::int32_t last) {
      return a < 0 ? -1 : static_cast<std::int32_t>(smaller(a, static_cast<float>(last)));
    };
    return {from(u0), to(u1, mLastU), from(v0), to(v1, mLastV)};
  }

  VOLCAUSTIC_HD std::int64_t brickOf(const Int3& voxel) const {
    return (static_cast<std::int64_t>(voxel.x >> 3) * mMedium.brickDims.y + (voxel.y >> 3)) * mMedium.brickDims.z +
           (voxel.z >> 3);
  }
  /// False where no voxel of its bricks bends.
  VOLCAUSTIC_HD bool load(Layer& layer, std::int32_t number) const {
    layer.low = plane(8 * number);
    layer.high = plane(8 * number + 8);
    const Rectangle& r = layer.inside = between(layer.low, layer.high);
    layer.bends = 0;
    if (r.empty()) return false;
    for (std::int32_t u = r.u0 >> 3; u <= r.u1 >> 3; ++u)
      for (std::int32_t v = r.v0 >> 3; v <= r.v1 >> 3; ++v) {
        const std::int64_t brick = brickOf(unsorted(8 * number, 8 * u, 8 * v));
        std::uint64_t(&words)[8] = layer.words[u - (r.u0 >> 3)][v - (r.v0 >> 3)];
        const bool some = mMedium.bends[brick];
        const std::int32_t slot = some ? mMedium.stepSlots[brick] : 0;
        const std::uint8_t* bytes = mMedium.steps + static_cast<std::int64_t>(larger(slot, 0)) * kStepVoxels;
        const std::int32_t first = mAxis == 0 ? 0 : larger(r.u0 - 8 * u, 0),
                           last = mAxis == 0 ? 7 : smaller(r.u1 - 8 * u, 7);
        for (std::int32_t i = first; i <= last; ++i) {
          words[i] = slot > 0 ? highBits(F(0), bytes + 64 * i) : some ? ~std::uint64_t{0} : 0;
          layer.bends |= mAxis == 0 ? static_cast<std::uint64_t>(words[i] != 0) << (8 * i) : words[i];
        }
      }
    return layer.bends != 0;
  }

  /// Bends of eight voxels along v.
  VOLCAUSTIC_HD std::uint64_t eight(const std::uint64_t (&words)[8], std::int32_t w, std::int32_t u) const {
    if (mAxis == 0) return words[w] >> (8 * u) & 0xff;
    if (mAxis == 1) return words[u] >> (8 * w) & 0xff;
    return ((words[u] >> w & 0x0101010101010101u) * 0x0102040810204080u) >> 56; // a bit of each byte, side by side
  }

  /// False where no voxel of the beam in the slab bends.
  VOLCAUSTIC_HD bool fill(SlabWindow& window, const Layer& layer, std::int32_t w) const {
    const Rectangle& r = layer.inside;
    const std::int32_t bricks = (r.v1 >> 3) - (r.v0 >> 3);
    std::int32_t all = 0;
    for (std::int32_t u = r.u0; u <= r.u1; ++u) {
      const std::uint64_t(&brick)[Layer::kWide][8] = layer.words[(u >> 3) - (r.u0 >> 3)];
      std::uint64_t row = 0;
      for (std::int32_t v = 0; v <= bricks; ++v) row |= eight(brick[v], w & 7, u & 7) << (8 * v);
      all |= window.rows[u - r.u0] = static_cast<std::int32_t>(row);
    }
    if (all == 0) return false;
    window.low = w;
    const Rectangle here = slabOf(layer, w);
    if (here.empty()) return false;
    const auto columns = static_cast<std::int32_t>((2u << (here.v1 - window.v0)) - (1u << (here.v0 - window.v0)));
    all = 0;
    for (std::int32_t u = larger(here.u0, r.u0); u <= smaller(here.u1, r.u1); ++u) all |= window.rows[u - r.u0];
    return (all & columns) != 0;
  }

  const FlatMedium& mMedium;
  const int mAxis;
  bool mForward = true, mNarrow = false;
  float mU[4], mV[4], mSlopeU[4], mSlopeV[4]; ///< where the rays are in a plane
  std::int32_t mFirst = 0, mLast = -1, mLastU = 0, mLastV = 0;
};

/// Rays of a narrow beam.
template <class F>
class SlabSearch {
public:
  using I = IntOf<F>;
  using M = MaskOf<F>;

  SlabSearch() = default;
  VOLCAUSTIC_HD SlabSearch(const Beam<F>& beam, const GridRay<F>& ray, F from, F to, const M& on)
      : mFrom(from), mTo(select(on, to, from)), mFound(F(kNeverBends)) {
    const Vec3<F> at = beam.sorted(ray.at), direction = beam.sorted(ray.direction), inverse = beam.sorted(ray.inverse);
    mAtW = at.x;
    mInverseW = inverse.x;
    mU = {at.y, direction.y, inverse.y};
    mV = {at.z, direction.z, inverse.z};
  }

  /// Distance to the bend; kNeverBends where none has been found.
  [[nodiscard]] VOLCAUSTIC_HD F found() const { return mFound; }

  /// Looks at the voxels that the rays cross in a slab, at most three each. False when no ray goes on behind it.
  VOLCAUSTIC_HD bool look(const SlabWindow& window, bool forward) {
    const F low = (F(static_cast<float>(window.low)) - mAtW) * mInverseW,
            high = (F(static_cast<float>(window.low + 1)) - mAtW) * mInverseW;
    const F in = larger(forward ? low : high, mFrom), behind = forward ? high : low, out = smaller(behind, mTo);
    const M on = in < out;
    if (any(on)) {
      I u0, u1, v0, v1;
      const F throughU = mU.through(in, out, u0, u1), throughV = mV.through(in, out, v0, v1);
      const M uFirst = throughU < throughV;
      const M first = both(on, bends(window, u0, v0)),
              second = both(on, bends(window, select(uFirst, u1, u0), select(uFirst, v0, v1))),
              third = both(on, bends(window, u1, v1));
      const F at = select(first, in, select(second, smaller(throughU, throughV), larger(throughU, throughV)));
      const M some = either(first, either(second, third));
      mFound = select(some, at, mFound);
      mTo = select(some, F(-kNeverBends), mTo);
    }
    return any(mTo > behind);
  }

private:
  /// One of the axes across.
  struct Across {
    F at, direction, inverse;

    /// Voxels at both ends of [in, out], and where between them the ray passes from one to the other (`out` when it
    /// does not).
    VOLCAUSTIC_HD F through(F in, F out, I& from, I& to) const {
      from = toInt(at + direction * in);
      to = clampTo(toInt(at + direction * out), from - I(1), from + I(1));
      const F face = (toFloat(larger(from, to)) - at) * inverse;
      return select(from == to, out, clampTo(face, in, out));
    }
  };

  VOLCAUSTIC_HD static M bends(const SlabWindow& window, I u, I v) {
    const I row = lookUp(window.rows, clampTo(u - I(window.u0), I(0), I(SlabWindow::kRows - 1)));
    return (row & powerOfTwo(clampTo(v - I(window.v0), I(0), I(SlabWindow::kColumns - 1)))) != I(0);
  }

  F mFrom, mTo, mFound, mAtW, mInverseW;
  Across mU, mV;
};

} // namespace volcaustic::kernels
