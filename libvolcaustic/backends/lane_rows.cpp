// Crossings of rows with triangles in lanes, and the winding numbers along the rows. Compiled once for each instruction
// set of lanes.h.
//
// Small triangles, which is nearly all of them, go a register of them at a time through the rows of their rectangles,
// side by side; a large one goes alone, through a register of rows at a time. Either way the edge functions of a row
// are one addition each (RowTriangle::valuesOfLine), and the rows that cross are set aside and get their heights a full
// register at a time.

#include "backends/highway_lanes.h"
#include "backends/row_pages.h"

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace {

using kernels::Crossing;
using kernels::RowColumn;
using kernels::RowPlane;
using kernels::RowTriangle;
using kernels::Vec3;

using Tag = Real::Tag;
using WideTag = hn::RebindToSigned<Tag>;
using CodeTag = hn::Rebind<std::int32_t, Tag>;
using Codes = hn::Vec<CodeTag>;

/// Rows along an axis that a triangle may meet so that it still goes side by side with others.
constexpr int kSideBySide = 8;
/// Rows of a column along an axis, at most; a power of two.
constexpr int kMostRows = 64, kMostRowsLog2 = 6;
static_assert(kSideBySide * kRealLanes <= kMostRows);
constexpr int kLanesLog2 = kRealLanes == 8 ? 3 : 2;
static_assert(1 << kLanesLog2 == kRealLanes);
/// Less than any edge function, and no row with it crosses.
constexpr double kOutside = -0x1p60;

VOLCAUSTIC_HD inline Codes toCodes(Real a) { return hn::DemoteTo(CodeTag(), a.v); }
VOLCAUSTIC_HD inline Codes codes(std::int32_t a) { return hn::Set(CodeTag(), a); }
VOLCAUSTIC_HD inline Real ceilOf(Real a) { return Real(hn::Ceil(a.v)); }
VOLCAUSTIC_HD inline Real floorOf(Real a) { return Real(hn::Floor(a.v)); }
VOLCAUSTIC_HD inline Real load(const double* p) { return Real(hn::Load(Tag(), p)); }
VOLCAUSTIC_HD inline void store(Real a, double* p) { hn::Store(a.v, Tag(), p); }
VOLCAUSTIC_HD inline Real gather(const double* p, Codes at) {
  return Real(hn::GatherIndex(Tag(), p, hn::PromoteTo(WideTag(), at)));
}

/// Writes the codes of the lanes that are on, one after another, and up to a register of anything after them.
/// \return how many there are
VOLCAUSTIC_HD inline int compress(const RealMask& on, Codes code, std::int32_t* out) {
#if HWY_TARGET == HWY_AVX2
  // Highway's table of lane orders would be copied to the stack on every call (highway_lanes.h).
  alignas(16) std::int32_t all[kRealLanes];
  hn::Store(code, CodeTag(), all);
  std::uint8_t bits = 0;
  hn::StoreMaskBits(Tag(), on.m, &bits);
  int size = 0;
  for (unsigned left = bits; left != 0; left &= left - 1) out[size++] = all[__builtin_ctz(left)];
  return size;
#else
  const hn::Mask<CodeTag> of{on.m.raw};
  hn::StoreU(hn::Compress(code, of), CodeTag(), out);
  return static_cast<int>(hn::CountTrue(CodeTag(), of));
#endif
}

class Crosser {
public:
  Crosser(const RowsTask& task, RowPages& pages) : mTask(task), mColumn(task.column), mPages(pages) {
    const double s = 1 << mColumn.log2;
    mInset = kernels::stagger(0, mColumn.log2);
    mSub = s;
    mPart = 1 / s;
    mStep = kernels::kFixedOne / s;
  }
  ~Crosser() { flush(); }

  /// Corners are on their way from memory while the triangles before them are looked at.
  void run() {
    if (mTask.count == 0) return;
    Indices next = indicesFrom(0);
    for (std::int64_t i = 0; i < mTask.count; i += kRealLanes) {
      const Indices present = next;
      if (i + kRealLanes < mTask.count) {
        next = indicesFrom(i + kRealLanes);
        prefetch(next);
        prefetchTriangles(i + 3 * kRealLanes);
      }
      packet(i, present);
    }
  }

private:
  struct Rects {
    Real x0, y0, x1, y1;
  };
  /// Edge functions along one side of a rectangle of rows. Side by side: of line i and lane l at i kRealLanes + l.
  struct alignas(64) Side {
    double a[kMostRows], b[kMostRows], c[kMostRows];
  };
  using Values = RowTriangle<Real>::Values;
  /// Where the triangles' corners begin among the points' numbers.
  struct Indices {
    hn::Vec<WideTag> a, b, c;
  };

  /// The triangles from number `first` on, as many as there are lanes; where there are fewer, any.
  [[nodiscard]] VOLCAUSTIC_HD Indices indicesFrom(std::int64_t first) const {
    const hn::Rebind<std::uint32_t, Tag> narrow;
    const hn::RebindToUnsigned<WideTag> wide;
    const auto lanes = hn::FirstN(narrow, static_cast<std::size_t>(mTask.count - first));
    const auto id = hn::PromoteTo(wide, hn::MaskedLoad(lanes, narrow, mTask.ids + first));
    static_assert(sizeof(mTask.triangles[0]) == 8 + 4);
    const auto at = hn::BitCast(WideTag(), hn::Add(hn::ShiftLeft<3>(id), hn::ShiftLeft<2>(id)));
    // Two corners at a time: the first and the second, then the second and the third.
    const auto* const base = reinterpret_cast<const std::int64_t*>(mTask.triangles);
    const auto ab = hn::GatherOffset(WideTag(), base, at),
               bc = hn::GatherOffset(WideTag(), base, hn::Add(at, hn::Set(WideTag(), sizeof(std::uint32_t))));
    const auto low = hn::Set(WideTag(), 0xffffffff);
    const auto thrice = [](hn::Vec<WideTag> v) __attribute__((always_inline)) { return hn::Add(hn::Add(v, v), v); };
    return {thrice(hn::And(ab, low)), thrice(hn::And(bc, low)), thrice(upperHalves(bc))};
  }
  VOLCAUSTIC_HD void prefetch(const Indices& indices) const {
    alignas(64) std::int64_t all[3 * kRealLanes];
    hn::Store(indices.a, WideTag(), all);
    hn::Store(indices.b, WideTag(), all + kRealLanes);
    hn::Store(indices.c, WideTag(), all + 2 * kRealLanes);
    for (const std::int64_t i : all) __builtin_prefetch(mTask.points + i);
  }
  VOLCAUSTIC_HD void prefetchTriangles(std::int64_t first) const {
    for (std::int64_t i = first; i < mTask.count && i < first + kRealLanes; ++i)
      __builtin_prefetch(mTask.triangles + mTask.ids[i]);
  }

  void packet(std::int64_t first, const Indices& indices) {
    const std::int64_t left = mTask.count - first;
    const Vec3<Real> a = corners(indices.a), b = corners(indices.b), c = corners(indices.c);
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

  [[nodiscard]] VOLCAUSTIC_HD static hn::Vec<WideTag> upperHalves(hn::Vec<WideTag> v) {
    const hn::RebindToUnsigned<WideTag> bits;
    return hn::BitCast(WideTag(), hn::ShiftRight<32>(hn::BitCast(bits, v)));
  }
  [[nodiscard]] VOLCAUSTIC_HD Vec3<Real> corners(hn::Vec<WideTag> at) const {
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

  /// Each lane one triangle: row by row of the largest rectangle.
  void sideBySide(const RowTriangle<Real>& triangles, const Rects& rects, const RealMask& on) {
    const Real one(1.0), unit(kernels::kFixedOne);
    int lines = 0, across = 0;
    for (Real row = rects.x0;; row = row + one, ++lines) {
      const RealMask in = both(on, row <= rects.x1);
      if (!any(in)) break;
      place(triangles.valuesOfLine(row * unit, offsetOf(phase(row))), in, mLine, lines * kRealLanes);
    }
    for (Real row = rects.y0;; row = row + one, ++across) {
      const RealMask in = both(on, row <= rects.y1);
      if (!any(in)) break;
      place(triangles.valuesAcross(offsetOf(phase(row)), row * unit), in, mAcross, across * kRealLanes);
    }
    const Codes each = hn::Mul(hn::Iota(CodeTag(), 0), codes(kMostRows + 1));
    int hits = 0;
    for (int i = 0; i < lines * kRealLanes; i += kRealLanes) {
      const Values line{load(mLine.a + i), load(mLine.b + i), load(mLine.c + i)};
      for (int j = 0; j < across * kRealLanes; j += kRealLanes) hits = findHits(line, i, j, each, hits);
    }
    const Codes starts = startsOf(rects.x0, rects.y0, triangles.rises());
    emit(
        hits, [&](Codes line, Codes atAcross) __attribute__((always_inline)) {
          const Codes lane = hn::And(line, codes(kRealLanes - 1));
          return Hit{planesOf(triangles.plane(), lane),
                     hn::TableLookupLanes(starts, hn::IndicesFromVec(CodeTag(), lane)),
                     hn::ShiftRight<kLanesLog2>(line), hn::ShiftRight<kLanesLog2>(atAcross)};
        });
  }

  /// Each lane one row.
  void alone(std::int64_t number, const Rects& rects, int lane) {
    alignas(64) double x0[kRealLanes], y0[kRealLanes], x1[kRealLanes], y1[kRealLanes];
    store(rects.x0, x0), store(rects.y0, y0), store(rects.x1, x1), store(rects.y1, y1);
    const auto& t = mTask.triangles[mTask.ids[number]];
    const auto corner = [&](int c) __attribute__((always_inline)) {
      const double* p = mTask.points + 3 * std::size_t(t[c]);
      return Vec3<Real>(Real(p[0]), Real(p[1]), Real(p[2]));
    };
    const RowTriangle<Real> triangle(corner(0), corner(1), corner(2));
    const Real unit(kernels::kFixedOne), iota(hn::Iota(Tag(), 0.0));
    const auto lines = static_cast<int>(x1[lane] - x0[lane]) + 1, across = static_cast<int>(y1[lane] - y0[lane]) + 1;
    for (int i = 0; i < lines; i += kRealLanes) {
      const Real row = Real(x0[lane] + i) + iota;
      place(triangle.valuesOfLine(row * unit, offsetOf(phase(row))), row <= Real(x1[lane]), mLine, i);
    }
    for (int j = 0; j < across; j += kRealLanes) {
      const Real row = Real(y0[lane] + j) + iota;
      place(triangle.valuesAcross(offsetOf(phase(row)), row * unit), row <= Real(y1[lane]), mAcross, j);
    }
    int hits = 0;
    for (int i = 0; i < lines; ++i) {
      const Values line{Real(mLine.a[i]), Real(mLine.b[i]), Real(mLine.c[i])};
      for (int j = 0; j < across; j += kRealLanes) hits = findHits(line, i, j, hn::Iota(CodeTag(), 0), hits);
    }
    const Codes start = startsOf(Real(x0[lane]), Real(y0[lane]), triangle.rises());
    emit(
        hits, [&](Codes line, Codes atAcross) __attribute__((always_inline)) {
          return Hit{triangle.plane(), start, line, atAcross};
        });
  }

  VOLCAUSTIC_HD static void place(const Values& v, const RealMask& in, Side& side, int at) {
    store(select(in, v.a, Real(kOutside)), side.a + at);
    store(v.b, side.b + at);
    store(v.c, side.c + at);
  }
  /// Adds to the hits which of a register of rows cross: places in mLine and mAcross, line << kMostRowsLog2 | across.
  /// \return the number of hits
  VOLCAUSTIC_HD int findHits(const Values& line, int i, int j, Codes each, int hits) {
    const RealMask crossed =
        triangleCrosses({line.a + load(mAcross.a + j), line.b + load(mAcross.b + j), line.c + load(mAcross.c + j)});
    return hits + compress(crossed, hn::Add(codes(i << kMostRowsLog2 | j), each), mHits + hits);
  }
  VOLCAUSTIC_HD static RealMask triangleCrosses(const Values& v) {
    const Real none(0.0);
    return both(both(v.a >= none, v.b >= none), v.c >= none);
  }

  /// A register of rows that cross: the planes of their triangles, codes of their rectangles, and where in these.
  struct Hit {
    RowPlane<Real> plane;
    Codes start, i, j;
  };
  /// The code of a rectangle's first row: that of a crossing at no sample.
  [[nodiscard]] VOLCAUSTIC_HD Codes startsOf(Real x0, Real y0, const RealMask& rises) const {
    const Codes row = toCodes((x0 - Real(mColumn.firstX)) * Real(mColumn.edge()) + (y0 - Real(mColumn.firstY)));
    const Real up = select(rises, Real(mTask.reversed ? 0.0 : 1.0), Real(mTask.reversed ? 1.0 : 0.0));
    return hn::Or(hn::ShiftLeft<7>(row), toCodes(up));
  }
  [[nodiscard]] VOLCAUSTIC_HD static RowPlane<Real> planesOf(const RowPlane<Real>& planes, Codes lane) {
    const auto at = hn::IndicesFromVec(Tag(), hn::PromoteTo(WideTag(), lane));
    const auto of = [&](Real v) __attribute__((always_inline)) { return Real(hn::TableLookupLanes(v.v, at)); };
    return {of(planes.biasB), of(planes.biasC), of(planes.area), of(planes.z), of(planes.riseB), of(planes.riseC)};
  }

  /// Turns the hits into crossings, those before the rows' last sample.
  template <class HitAt>
  VOLCAUSTIC_HD void emit(int hits, HitAt&& hitAt) {
    hn::StoreU(hn::Zero(CodeTag()), CodeTag(), mHits + hits);
    for (int k = 0; k < hits; k += kRealLanes) {
      const Codes code = hn::LoadU(CodeTag(), mHits + k);
      const Codes line = hn::ShiftRight<kMostRowsLog2>(code), across = hn::And(code, codes(kMostRows - 1));
      const Hit hit = hitAt(line, across);
      const Real z = hit.plane.height(gather(mLine.b, line) + gather(mAcross.b, across),
                                      gather(mLine.c, line) + gather(mAcross.c, across));
      const Codes start =
          hn::Add(hit.start, hn::ShiftLeft<7>(hn::Add(hn::ShiftLeftSame(hit.i, mColumn.brickLog2()), hit.j)));
      append(RealMask{hn::FirstN(Tag(), static_cast<std::size_t>(hits - k))}, start, z);
    }
  }

  /// kernels::firstSampleFrom on lanes.
  VOLCAUSTIC_HD void append(const RealMask& on, Codes start, Real z) {
    const int brickLog2 = mColumn.brickLog2(), log2 = mColumn.log2;
    const Codes mask = codes((1 << log2) - 1), row = hn::ShiftRight<7>(start);
    const Codes p = hn::And(hn::ShiftRightSame(row, brickLog2), mask), q = hn::And(row, mask);
    const Codes odd = hn::Or(hn::ShiftLeft<1>(hn::Or(hn::ShiftLeftSame(p, log2), q)), codes(1));
    const Real offset(hn::PromoteTo(Tag(), hn::ShiftRightSame(hn::ShiftLeft<kernels::kFixedBits - 1>(odd), 2 * log2)));
    const Real samples(mColumn.samples);
    const Real k = ceilOf(smaller(larger((z - offset) * Real(1.0 / kernels::kFixedOne), Real(0.0)), samples));
    const Codes sample = toCodes(k), inBrick = hn::And(sample, codes((1 << brickLog2) - 1));
    const Codes code =
        hn::Or(hn::ShiftLeft<19>(hn::ShiftRightSame(sample, brickLog2)), hn::Or(hn::ShiftLeft<1>(inBrick), start));
    if (mSize + kRealLanes > kCapacity) flush();
    mSize += compress(both(on, k < samples), code, mCrossings + mSize);
  }
  void flush() {
    mPages.add(reinterpret_cast<const Crossing*>(mCrossings), mSize);
    mSize = 0;
  }

  /// Of row numbers, which are not negative: the number within a voxel.
  [[nodiscard]] VOLCAUSTIC_HD Real phase(Real row) const { return row - floorOf(row * Real(mPart)) * Real(mSub); }
  /// kernels::stagger of the phase.
  [[nodiscard]] VOLCAUSTIC_HD Real offsetOf(Real phases) const { return Real(mInset) + phases * Real(mStep); }

  static constexpr int kCapacity = 1024;

  const RowsTask& mTask;
  RowColumn mColumn;
  RowPages& mPages;
  double mInset;      // least stagger
  double mSub, mPart; // rows along a voxel, and 1 of them in voxels
  double mStep;       // from one stagger to the next
  Side mLine, mAcross;
  int mSize = 0;
  alignas(64) std::int32_t mHits[kMostRows * kMostRows + kRealLanes];
  alignas(64) std::int32_t mCrossings[kCapacity + kRealLanes];
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
