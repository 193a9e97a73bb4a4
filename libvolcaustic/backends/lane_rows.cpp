// Crossings of rows with triangles in lanes, and the winding numbers along the rows. Compiled once for each instruction
// set of lanes.h.
//
// Small triangles, which is nearly all of them, go a register of them at a time through the rows of their rectangles,
// side by side; a large one goes alone, through a register of rows at a time.

#include "backends/highway_lanes.h"
#include "backends/row_pages.h"

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace {

using kernels::Crossing;
using kernels::RowColumn;
using kernels::RowTriangle;
using kernels::Vec3;

using Tag = Real::Tag;
using CodeTag = hn::RebindToSigned<hn::Rebind<std::int32_t, Tag>>;
using Codes = hn::Vec<CodeTag>;

/// Rows that a triangle may meet so that it still goes side by side with others.
constexpr int kSideBySide = 8;

VOLCAUSTIC_HD inline Codes toCodes(Real a) { return hn::DemoteTo(CodeTag(), a.v); }
VOLCAUSTIC_HD inline Real ceilOf(Real a) { return Real(hn::Ceil(a.v)); }
VOLCAUSTIC_HD inline Real floorOf(Real a) { return Real(hn::Floor(a.v)); }

/// Crossings on their way to the pages.
class Batch {
public:
  Batch(RowPages& pages, const RowColumn& column)
      : mPages(pages), mSamples(column.samples), mShift(column.brickLog2()), mMask((1 << column.brickLog2()) - 1) {}
  ~Batch() { flush(); }

  /// Of the lanes that are on: where they are sampled, what stands at the heights z.
  VOLCAUSTIC_HD void append(const RealMask& on, Codes rows, Codes signs, Real z, Real offset) {
    const Real samples(mSamples);
    const Real k = ceilOf(smaller(larger((z - offset) * Real(1.0 / kernels::kFixedOne), Real(0.0)), samples));
    const RealMask kept = both(on, k < samples);
    const Codes sample = toCodes(k), inBrick = hn::And(sample, hn::Set(CodeTag(), mMask));
    const Codes code = hn::Or(hn::Or(hn::ShiftLeft<19>(hn::ShiftRightSame(sample, mShift)), hn::ShiftLeft<7>(rows)),
                              hn::Or(hn::ShiftLeft<1>(inBrick), signs));
    if (mSize + kRealLanes > kCapacity) flush();
    compress(kept, code);
  }

private:
  static constexpr int kCapacity = 1024;

  VOLCAUSTIC_HD void compress(const RealMask& kept, Codes code) {
#if HWY_TARGET == HWY_AVX2
    // Highway's table of lane orders would be copied to the stack on every call (highway_lanes.h).
    alignas(16) std::int32_t codes[kRealLanes];
    hn::Store(code, CodeTag(), codes);
    std::uint8_t bits = 0;
    hn::StoreMaskBits(Tag(), kept.m, &bits);
    for (unsigned left = bits; left != 0; left &= left - 1)
      mCrossings[mSize++] = static_cast<Crossing>(codes[__builtin_ctz(left)]);
#else
    const hn::Mask<CodeTag> of{kept.m.raw};
    mSize +=
        static_cast<int>(hn::CompressStore(code, of, CodeTag(), reinterpret_cast<std::int32_t*>(mCrossings + mSize)));
#endif
  }
  void flush() {
    mPages.add(mCrossings, mSize);
    mSize = 0;
  }

  RowPages& mPages;
  double mSamples;
  int mShift;
  std::int32_t mMask;
  int mSize = 0;
  alignas(64) Crossing mCrossings[kCapacity + kRealLanes];
};

class Crosser {
public:
  Crosser(const RowsTask& task, RowPages& pages)
      : mTask(task), mColumn(task.column), mPages(pages), mBatch(pages, task.column) {
    const double s = 1 << mColumn.log2;
    mInset = kernels::stagger(0, mColumn.log2);
    mInsetZ = kernels::stagger(0, 2 * mColumn.log2);
    mSub = s;
    mPart = 1 / s;
    mStep = kernels::kFixedOne / s;
    mStepZ = kernels::kFixedOne / (s * s);
  }

  void run() {
    for (std::int64_t i = 0; i < mTask.count; i += kRealLanes) packet(i);
  }

private:
  struct Rects {
    Real x0, y0, x1, y1;
  };

  /// The triangles from number `first` on, as many as there are lanes; the last one is repeated where there are fewer.
  void packet(std::int64_t first) {
    const std::int64_t left = mTask.count - first;
    alignas(64) std::int64_t vertices[3][kRealLanes];
    for (int lane = 0; lane < kRealLanes; ++lane) {
      const auto& t = mTask.triangles[mTask.ids[first + (lane < left ? lane : left - 1)]];
      for (int corner = 0; corner < 3; ++corner) vertices[corner][lane] = 3 * std::int64_t{t[corner]};
    }
    const Vec3<Real> a = corners(vertices[0]), b = corners(vertices[1]), c = corners(vertices[2]);
    const Real lowX = smaller(smaller(a.x, b.x), c.x), highX = larger(larger(a.x, b.x), c.x),
               lowY = smaller(smaller(a.y, b.y), c.y), highY = larger(larger(a.y, b.y), c.y);
    const Rects rects = rectsOf(lowX, lowY, highX, highY);
    const RowTriangle<Real> triangles(a, b, c);
    RealMask on{hn::FirstN(Tag(), static_cast<std::size_t>(left < kRealLanes ? left : kRealLanes))};
    on = both(both(on, RealMask{hn::Not(triangles.flat().m)}), both(rects.x0 <= rects.x1, rects.y0 <= rects.y1));
    if (!any(on)) return;
    const Real side(kSideBySide - 1), limit(kernels::kExactInDoubles);
    const RealMask exact = both(highX - lowX < limit, highY - lowY < limit);
    const RealMask small = both(both(on, exact), both(rects.x1 - rects.x0 <= side, rects.y1 - rects.y0 <= side));
    if (any(small)) sideBySide(triangles, rects, small);
    std::uint8_t bits = 0;
    hn::StoreMaskBits(Tag(), hn::And(on.m, hn::Not(small.m)), &bits);
    if (bits == 0) return;
    std::uint8_t isExact = 0;
    hn::StoreMaskBits(Tag(), exact.m, &isExact);
    for (unsigned rest = bits; rest != 0; rest &= rest - 1) {
      const int lane = __builtin_ctz(rest);
      if (isExact >> lane & 1)
        alone(first + lane, rects, lane);
      else
        crossRowsOf(mTask, first + lane, mPages);
    }
  }

  [[nodiscard]] VOLCAUSTIC_HD Vec3<Real> corners(const std::int64_t* vertices) const {
    const hn::RebindToSigned<Tag> wide;
    const auto at = hn::Load(wide, vertices);
    return {Real(hn::GatherIndex(Tag(), mTask.points, at)), Real(hn::GatherIndex(Tag(), mTask.points + 1, at)),
            Real(hn::GatherIndex(Tag(), mTask.points + 2, at))};
  }

  /// kernels::rowRange on lanes.
  [[nodiscard]] VOLCAUSTIC_HD Rects rectsOf(Real lowX, Real lowY, Real highX, Real highY) const {
    const Real inset(mInset), unit(1 / kernels::kFixedOne), one(1.0);
    const auto first = [&](Real least, std::int32_t low, std::int32_t high) __attribute__((always_inline)) {
      return smaller(larger(ceilOf((least + inset) * unit) - one, Real(low)), Real(high + 1.0));
    };
    const auto last = [&](Real greatest, std::int32_t low, std::int32_t high) __attribute__((always_inline)) {
      return smaller(larger(floorOf((greatest - inset) * unit), Real(low - 1.0)), Real(high));
    };
    const kernels::RowRect& box = mTask.box;
    return {first(lowX, box.x0, box.x1), first(lowY, box.y0, box.y1), last(highX, box.x0, box.x1),
            last(highY, box.y0, box.y1)};
  }

  /// 1 where crossings count up.
  [[nodiscard]] VOLCAUSTIC_HD Codes signsOf(const RealMask& rises) const {
    const auto up =
        hn::IfThenElse(rises.m, hn::Set(Tag(), mTask.reversed ? 0.0 : 1.0), hn::Set(Tag(), mTask.reversed ? 1.0 : 0.0));
    return toCodes(Real(up));
  }

  /// Rows of rectangles along one axis, in the lanes of their triangles.
  struct Along {
    Real at;     ///< row number, in lattice units
    Real offset; ///< of what is sampled along the other axis
    Real phase;  ///< of the voxel's rows
    Real place;  ///< in the column's numbers of rows
    RealMask in;
  };
  VOLCAUSTIC_HD int rowsAlong(Real first, Real last, std::int32_t columnFirst, double stride, const RealMask& on,
                              Along (&rows)[kSideBySide]) const {
    const Real one(1.0), unit(kernels::kFixedOne), origin(columnFirst), scale(stride);
    int count = 0;
    for (Real row = first;; row = row + one) {
      const RealMask in = both(on, row <= last);
      if (!any(in)) return count;
      const Real p = phase(row);
      rows[count++] = {row * unit, offsetOf(p), p, (row - origin) * scale, in};
    }
  }

  /// Each lane one triangle: row by row of the largest rectangle.
  void sideBySide(const RowTriangle<Real>& triangles, const Rects& rects, const RealMask& on) {
    const Codes signs = signsOf(triangles.rises());
    Along alongX[kSideBySide], alongY[kSideBySide];
    const int countX = rowsAlong(rects.x0, rects.x1, mColumn.firstX, mColumn.edge(), on, alongX);
    const int countY = rowsAlong(rects.y0, rects.y1, mColumn.firstY, 1, on, alongY);
    for (int i = 0; i < countX; ++i)
      for (int j = 0; j < countY; ++j) {
        const Along &x = alongX[i], &y = alongY[j];
        const auto values = triangles.valuesAt(x.at + y.offset, y.at + x.offset);
        const RealMask crossed = both(both(x.in, y.in), triangles.crosses(values));
        if (!any(crossed)) continue;
        mBatch.append(crossed, toCodes(x.place + y.place), signs, triangles.height(values), offsetZ(x.phase, y.phase));
      }
  }

  /// Each lane one row.
  void alone(std::int64_t number, const Rects& rects, int lane) {
    alignas(64) double x0[kRealLanes], y0[kRealLanes], x1[kRealLanes], y1[kRealLanes];
    hn::Store(rects.x0.v, Tag(), x0);
    hn::Store(rects.y0.v, Tag(), y0);
    hn::Store(rects.x1.v, Tag(), x1);
    hn::Store(rects.y1.v, Tag(), y1);
    const auto& t = mTask.triangles[mTask.ids[number]];
    const auto corner = [&](int c) __attribute__((always_inline)) {
      const double* p = mTask.points + 3 * std::size_t(t[c]);
      return Vec3<Real>(Real(p[0]), Real(p[1]), Real(p[2]));
    };
    const RowTriangle<Real> triangle(corner(0), corner(1), corner(2));
    const Codes signs = signsOf(triangle.rises());
    const Real unit(kernels::kFixedOne), last(y1[lane]);
    const Real lanes(hn::Iota(Tag(), 0.0f));
    for (double x = x0[lane]; x <= x1[lane]; x += 1) {
      const Real i(x), alongY = phase(i), rowX((x - mColumn.firstX) * mColumn.edge());
      for (double y = y0[lane]; y <= y1[lane]; y += kRealLanes) {
        const Real j = Real(y) + lanes, alongX = phase(j);
        const auto values = triangle.valuesAt(i * unit + offsetOf(alongX), j * unit + offsetOf(alongY));
        const RealMask crossed = both(j <= last, triangle.crosses(values));
        if (!any(crossed)) continue;
        const Codes rows = toCodes(rowX + (j - Real(mColumn.firstY)));
        mBatch.append(crossed, rows, signs, triangle.height(values), offsetZ(alongY, alongX));
      }
    }
  }

  /// Of row numbers, which are not negative: the number within a voxel.
  [[nodiscard]] VOLCAUSTIC_HD Real phase(Real row) const { return row - floorOf(row * Real(mPart)) * Real(mSub); }
  /// kernels::stagger of the phase, and of the phases p s + q along z.
  [[nodiscard]] VOLCAUSTIC_HD Real offsetOf(Real phases) const { return Real(mInset) + phases * Real(mStep); }
  [[nodiscard]] VOLCAUSTIC_HD Real offsetZ(Real p, Real q) const {
    return Real(mInsetZ) + (p * Real(mSub) + q) * Real(mStepZ);
  }

  const RowsTask& mTask;
  RowColumn mColumn;
  RowPages& mPages;
  Batch mBatch;
  double mInset, mInsetZ; // least staggers
  double mSub, mPart;     // rows along a voxel, and 1 of them in voxels
  double mStep, mStepZ;   // from one stagger to the next
};

template <class Word>
VOLCAUSTIC_HD inline int sweep(const RowSweep<Word>& s) {
  const hn::ScalableTag<Word> d;
  const hn::RebindToSigned<decltype(d)> di;
  constexpr int kBits = 8 * sizeof(Word);
  const auto samples = hn::Set(d, static_cast<Word>(~Word{0} >> (kBits - s.samples)));
  const auto offset = hn::Set(di, static_cast<std::make_signed_t<Word>>(s.offset));
  int irregular = 0;
  for (int row = 0; row < s.rows; row += static_cast<int>(hn::Lanes(d))) {
    const auto rises = hn::LoadU(d, s.rises + row), falls = hn::LoadU(d, s.falls + row);
    const auto winding = hn::LoadU(di, s.winding + row);
    const auto carry = hn::BitCast(d, hn::Add(winding, offset));
    const auto changes = hn::Xor(rises, falls);
    auto after = changes;
    after = hn::Xor(after, hn::ShiftLeft<1>(after));
    after = hn::Xor(after, hn::ShiftLeft<2>(after));
    after = hn::Xor(after, hn::ShiftLeft<4>(after));
    after = hn::Xor(after, hn::ShiftLeft<8>(after));
    after = hn::Xor(after, hn::ShiftLeft<16>(after));
    if constexpr (kBits == 64) after = hn::Xor(after, hn::ShiftLeft<32>(after));
    after = hn::Xor(after, hn::Sub(hn::Zero(d), carry));
    // Samples at which the number changes and is not 1 after a rise, or not 0 after a fall.
    const auto wrong = hn::AndNot(hn::Xor(after, falls), changes);
    const auto regular = hn::And(hn::Eq(wrong, hn::Zero(d)), hn::Eq(hn::ShiftRight<1>(carry), hn::Zero(d)));
    hn::StoreU(hn::And(after, samples), d, s.inside + row);
    const auto next = hn::Sub(hn::BitCast(di, hn::ShiftRight<kBits - 1>(after)), offset);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(di, regular), next, winding), di, s.winding + row);
    if (hn::AllTrue(d, regular)) continue;
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(regular), bits);
    for (int lane = 0; lane < static_cast<int>(hn::Lanes(d)); ++lane)
      if (bits[lane / 8] >> lane % 8 & 1) s.irregular[irregular++] = static_cast<std::uint16_t>(row + lane);
  }
  return irregular;
}

} // namespace

void crossRows(const RowsTask& task, RowPages& pages) { Crosser(task, pages).run(); }
int sweepRows32(const RowSweep<std::uint32_t>& s) { return sweep(s); }
int sweepRows64(const RowSweep<std::uint64_t>& s) { return sweep(s); }

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
