// Exact rasterisation of a chord, slab by slab: the voxels that a straight segment crosses, and the lengths inside
// them.
//
// Cut into slabs of one voxel across its dominant axis w, a chord crosses at most one face of each other axis in a
// slab, so at most three voxels. A slab is a fixed piece of arithmetic without a loop that depends on another one:
// lanes take sixteen chords at once, or sixteen slabs of one chord, and a thread of a GPU takes them one by one.
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

/// A cell crossed, the length inside it (zero where there is nothing to add), and where along the chord the middle of
/// that length is.
template <class F, class Address>
struct CrossedCell {
  Address at;
  F length, middle;
};
template <class F, class Address>
struct SlabCrossing {
  CrossedCell<F, Address> first, second, third;
};

/// Voxels of the domain, addressed by brick and offset in the brick.
struct BrickCells {
  Int3 dims, brickDims;

  template <class F>
  struct Address {
    IntOf<F> brick, offset;
    VOLCAUSTIC_HD friend Address operator+(const Address& a, const Address& b) {
      return {a.brick + b.brick, a.offset + b.offset};
    }
    VOLCAUSTIC_HD friend Address select(const MaskOf<F>& mask, const Address& a, const Address& b) {
      return {select(mask, a.brick, b.brick), select(mask, a.offset, b.offset)};
    }
  };
  /// Strides of the chord's axes. An address is the sum of what the cell's three coordinates give.
  template <class F>
  struct Strides {
    IntOf<F> brickW, brickU, brickV, offsetW, offsetU, offsetV;
    VOLCAUSTIC_HD Address<F> alongW(IntOf<F> w) const { return along(w, brickW, offsetW); }
    VOLCAUSTIC_HD Address<F> alongU(IntOf<F> u) const { return along(u, brickU, offsetU); }
    VOLCAUSTIC_HD Address<F> alongV(IntOf<F> v) const { return along(v, brickV, offsetV); }

  private:
    VOLCAUSTIC_HD static Address<F> along(IntOf<F> c, IntOf<F> brick, IntOf<F> offset) {
      return {(c >> 3) * brick, (c & IntOf<F>(7)) * offset};
    }
  };
  template <class F, class Sorted>
  VOLCAUSTIC_HD Strides<F> strides(const Sorted& sorted) const {
    using I = IntOf<F>;
    Strides<F> s;
    sorted(I(brickDims.y * brickDims.z), I(brickDims.z), I(1), s.brickW, s.brickU, s.brickV);
    sorted(I(64), I(8), I(1), s.offsetW, s.offsetU, s.offsetV);
    return s;
  }
};

/// Cells of a dense array, z fastest, addressed by number.
struct DenseCells {
  Int3 dims;

  template <class F>
  using Address = IntOf<F>;
  template <class F>
  struct Strides {
    IntOf<F> w, u, v;
    VOLCAUSTIC_HD IntOf<F> alongW(IntOf<F> c) const { return c * w; }
    VOLCAUSTIC_HD IntOf<F> alongU(IntOf<F> c) const { return c * u; }
    VOLCAUSTIC_HD IntOf<F> alongV(IntOf<F> c) const { return c * v; }
  };
  template <class F, class Sorted>
  VOLCAUSTIC_HD Strides<F> strides(const Sorted& sorted) const {
    using I = IntOf<F>;
    Strides<F> s;
    sorted(I(dims.y * dims.z), I(dims.z), I(1), s.w, s.u, s.v);
    return s;
  }
};

/// A chord from `start` along the unit vector `direction` through cells of edge 1, its axes sorted into w (dominant),
/// u, v. What lies outside the cells is counted to the outermost ones.
template <class F, class Cells>
class SlabChord {
public:
  using I = IntOf<F>;
  using M = MaskOf<F>;
  using Address = typename Cells::template Address<F>;

  VOLCAUSTIC_HD SlabChord(const Cells& cells, const Vec3<F>& start, const Vec3<F>& direction, F length)
      : mLength(length) {
    const F dx = absOf(direction.x), dy = absOf(direction.y), dz = absOf(direction.z);
    const M wIsX = both(dx >= dy, dx >= dz), wIsY = both(negate(wIsX), dy >= dz);
    const auto sorted = [&](auto x, auto y, auto z, auto& w, auto& u, auto& v) {
      w = select(wIsX, x, select(wIsY, y, z));
      u = select(wIsX, y, select(wIsY, z, x));
      v = select(wIsX, z, select(wIsY, x, y));
    };
    F dw;
    sorted(start.x, start.y, start.z, mW, mU, mV);
    sorted(direction.x, direction.y, direction.z, dw, mDu, mDv);
    sorted(I(cells.dims.x - 1), I(cells.dims.y - 1), I(cells.dims.z - 1), mLastW, mLastU, mLastV);
    mStrides = cells.template strides<F>(sorted);
    mInverseW = reciprocal(dw);
    mInverseU = reciprocal(mDu);
    mInverseV = reciprocal(mDv);
    mForward = dw > F(0);
    mFirst = cell(mW, mLastW);
    const I last = cell(mulAdd(dw, length, mW), mLastW);
    mSlabs = select(mForward, last - mFirst, mFirst - last) + I(1);
  }

  /// Slabs that the chord reaches into, at least one.
  [[nodiscard]] VOLCAUSTIC_HD I slabs() const { return mSlabs; }

  /// What lies in slab k, 0 <= k < slabs(). Lengths of all slabs add up to the chord's.
  [[nodiscard]] VOLCAUSTIC_HD SlabCrossing<F, Address> crossing(I k) const {
    const I w = mFirst + select(mForward, k, -k);
    const F low = (toFloat(w) - mW) * mInverseW, high = (toFloat(w + I(1)) - mW) * mInverseW;
    const F in = select(k == I(0), F(0), clampTo(smaller(low, high), F(0), mLength));
    const F out = select(k == mSlabs - I(1), mLength, clampTo(larger(low, high), F(0), mLength));

    I u0, u1, v0, v1;
    const F alongU = across(mU, mDu, mInverseU, mLastU, in, out, u0, u1);
    const F alongV = across(mV, mDv, mInverseV, mLastV, in, out, v0, v1);
    const M uFirst = alongU < alongV;
    const F one = smaller(alongU, alongV), two = larger(alongU, alongV);
    const F half(0.5f);
    const Address atW = mStrides.alongW(w), atU0 = mStrides.alongU(u0), atU1 = mStrides.alongU(u1),
                  atV0 = mStrides.alongV(v0), atV1 = mStrides.alongV(v1);
    return {{atW + atU0 + atV0, one - in, half * (one + in)},
            {atW + select(uFirst, atU1 + atV0, atU0 + atV1), two - one, half * (two + one)},
            {atW + atU1 + atV1, out - two, half * (out + two)}};
  }

private:
  VOLCAUSTIC_HD static I cell(F p, I last) { return clampTo(toInt(p), I(0), last); }

  /// Cells at both ends of [in, out] along an axis, and where between them the chord passes from one to the other
  /// (`out` when it does not).
  VOLCAUSTIC_HD static F across(F start, F d, F inverse, I last, F in, F out, I& from, I& to) {
    from = cell(mulAdd(d, in, start), last);
    to = clampTo(cell(mulAdd(d, out, start), last), from - I(1), from + I(1));
    const F face = toFloat(larger(from, to));
    return select(from == to, out, clampTo((face - start) * inverse, in, out));
  }

  F mLength, mW, mU, mV, mDu, mDv, mInverseW, mInverseU, mInverseV;
  I mLastW, mLastU, mLastV, mFirst, mSlabs;
  typename Cells::template Strides<F> mStrides;
  M mForward;
};

} // namespace volcaustic::kernels
