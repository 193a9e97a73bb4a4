#include "simulation/flow.h"

namespace volcaustic {

namespace {

/// (1 - amount * second difference) x = x, along lines of `count` values `stride` apart: Thomas's algorithm, the
/// factors of which are the same for all lines.
class LineSolver {
public:
  LineSolver(int count, double amount, DiffusionEnds ends)
      : mCount(count)
      , mAmount(static_cast<float>(amount))
      , mHeld(ends == DiffusionEnds::Held)
      , mInverse(count)
      , mUpper(count) {
    double upper = 0;
    for (int i = 0; i < count; ++i) {
      const bool end = i == 0 || i == count - 1;
      const double low = i == 0 || (mHeld && end) ? 0 : amount, high = i == count - 1 || (mHeld && end) ? 0 : amount;
      const double pivot = 1 + low + high - low * upper;
      upper = high / pivot;
      mInverse[i] = static_cast<float>(1 / pivot);
      mUpper[i] = static_cast<float>(upper);
    }
  }

  void operator()(float* x, std::size_t stride) const {
    x[0] *= mInverse[0];
    for (int i = 1; i < mCount; ++i) {
      const float low = mHeld && i == mCount - 1 ? 0 : mAmount;
      x[i * stride] = (x[i * stride] + low * x[(i - 1) * stride]) * mInverse[i];
    }
    for (int i = mCount - 2; i >= 0; --i) x[i * stride] += mUpper[i] * x[(i + 1) * stride];
  }

private:
  int mCount;
  float mAmount;
  bool mHeld;
  std::vector<float> mInverse, mUpper;
};

} // namespace

void diffuse(Lattice& field, double amount, const std::array<DiffusionEnds, 3>& ends, const RunContext& ctx) {
  if (amount <= 0) return;
  for (int axis = 0; axis < 3; ++axis) {
    const LineSolver solve(field.dims()[axis], amount, ends[axis]);
    // Lines along `axis` begin at the nodes of the lattice without it.
    Vec3i starts = field.dims();
    starts[axis] = 1;
    forEachRow(starts, ctx, [&](int j, int k) {
      for (int i = 0; i < starts[0]; ++i) solve(field.values().data() + field.index(i, j, k), field.stride(axis));
    });
  }
}

} // namespace volcaustic
