// The search for the first voxel along a ray where light bends: bricks in one stride, voxels where a brick's step bytes
// differ (Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987, over two sizes of
// cells).
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

inline constexpr float kNeverBends = 3.0e38f;

/// A straight ray at distance t: at + t direction. Directions along a plane of the grid lean by a billionth.
///
/// Rays and searches use additions, products, quotients and roots only, each rounded by itself, so that all machines
/// which do not fuse find the same bits.
template <class F>
struct GridRay {
  Vec3<F> at, direction, inverse;

  GridRay() = default;
  VOLCAUSTIC_HD GridRay(const Vec3<F>& at_, const Vec3<F>& direction_)
      : at(at_)
      , direction(direction_)
      , inverse(inverseOf(direction_.x), inverseOf(direction_.y), inverseOf(direction_.z)) {}

  [[nodiscard]] VOLCAUSTIC_HD Vec3<F> point(F t) const { return at + direction * t; }

private:
  VOLCAUSTIC_HD static F inverseOf(F d) { return quotient(F(1), select(absOf(d) > F(1e-9f), d, F(1e-9f))); }
};

template <class F>
struct RaySpan {
  F entry, exit;
};

/// The part of a ray inside the box [0, dims]; exit <= entry where there is none.
template <class F>
VOLCAUSTIC_HD inline RaySpan<F> spanInBox(const Int3& dims, const GridRay<F>& ray) {
  const auto axis = [](F at, F inverse, int dim, F& in, F& out) {
    const F low = (F(0) - at) * inverse, high = (F(static_cast<float>(dim)) - at) * inverse;
    in = smaller(low, high);
    out = larger(low, high);
  };
  Vec3<F> in, out;
  axis(ray.at.x, ray.inverse.x, dims.x, in.x, out.x);
  axis(ray.at.y, ray.inverse.y, dims.y, in.y, out.y);
  axis(ray.at.z, ray.inverse.z, dims.z, in.z, out.z);
  return {larger(in.x, larger(in.y, in.z)), smaller(out.x, smaller(out.y, out.z))};
}

/// Steps along a ray from `from` to `to`, both inside its span in the box, cell by cell until the first voxel whose
/// step byte says that light bends.
///
/// Faces are met at distances computed as spanInBox does, so a walk ends before it leaves the tables.
template <class F>
class BendSearch {
public:
  using I = IntOf<F>;
  using M = MaskOf<F>;

  BendSearch() = default;
  VOLCAUSTIC_HD BendSearch(const FlatMedium& m, const GridRay<F>& ray, F from, F to, const M& on)
      : mAt(from), mTo(to), mOn(both(on, from < to)), mVoxel(m.voxelOf(ray.point(from))) {}

  [[nodiscard]] VOLCAUSTIC_HD bool goesOn() const { return any(mOn); }
  /// Distance to the bend; kNeverBends where none has been found.
  [[nodiscard]] VOLCAUSTIC_HD F found() const { return mFound; }

  /// Looks at the cell, and goes to the next one unless it bends.
  VOLCAUSTIC_HD void step(const FlatMedium& m, const GridRay<F>& ray) {
    const I slot = gather(m.stepSlots, brickNumber(m));
    const M mixed = slot > I(0);
    const I byte = gatherByte(m.steps, (larger(slot, I(0)) << 9) + FlatMedium::voxelOffset(mVoxel));
    const M bends = both(mOn, (select(slot < I(0), ~slot, byte) & I(kStepBendsBit)) != I(0));
    mFound = select(bends, mAt, mFound);

    // A cell of one voxel, or the brick.
    const I inside = select(mixed, I(0), I(7));
    const Cell x(mVoxel.x, inside, ray.at.x, ray.inverse.x), y(mVoxel.y, inside, ray.at.y, ray.inverse.y),
        z(mVoxel.z, inside, ray.at.z, ray.inverse.z);
    const F out = smaller(x.out, smaller(y.out, z.out));
    const M throughX = x.out <= out, throughY = both(negate(throughX), y.out <= out),
            throughZ = negate(either(throughX, throughY));
    mOn = both(mOn, both(negate(bends), out < mTo));
    mAt = larger(mAt, out);
    const Vec3<F> p = ray.point(mAt);
    mVoxel = {select(mOn, x.next(p.x, throughX), mVoxel.x), select(mOn, y.next(p.y, throughY), mVoxel.y),
              select(mOn, z.next(p.z, throughZ), mVoxel.z)};
  }

private:
  /// A cell along one axis: `low` to `high` are its voxels, `out` is the distance at which the ray leaves it.
  struct Cell {
    I low, high;
    M forward;
    F out;

    VOLCAUSTIC_HD Cell(I voxel, I inside, F at, F inverse)
        : low(voxel & ~inside), high(voxel | inside), forward(inverse > F(0)) {
      out = (toFloat(select(forward, high + I(1), low)) - at) * inverse;
    }
    /// The voxel behind the face, or the one that holds p.
    [[nodiscard]] VOLCAUSTIC_HD I next(F p, const M& through) const {
      return select(through, select(forward, high + I(1), low - I(1)), clampTo(toInt(p), low, high));
    }
  };

  VOLCAUSTIC_HD I brickNumber(const FlatMedium& m) const {
    // Two products side by side, where FlatMedium::brickIndex has one wait for the other.
    return (mVoxel.x >> 3) * I(m.brickDims.y * m.brickDims.z) + (mVoxel.y >> 3) * I(m.brickDims.z) + (mVoxel.z >> 3);
  }

  F mAt{}, mTo{}, mFound = F(kNeverBends);
  M mOn{};
  Vec3<I> mVoxel;
};

} // namespace volcaustic::kernels
