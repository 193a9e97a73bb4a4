#include "backends/row_pages.h"

#include <algorithm>
#include <utility>

namespace volcaustic {

namespace {

using kernels::Crossing;
using kernels::RowRect;
using kernels::RowTriangle;
using kernels::Vec3;

template <class N>
Vec3<N> corner(const RowsTask& task, std::uint32_t vertex) {
  const double* p = task.points + 3 * std::size_t(vertex);
  return {static_cast<N>(p[0]), static_cast<N>(p[1]), static_cast<N>(p[2])};
}

template <class N>
void crossAs(const RowsTask& task, std::int64_t i, const RowRect& rect, RowPages& pages) {
  const auto& t = task.triangles[task.ids[i]];
  const RowTriangle<N> triangle(corner<N>(task, t[0]), corner<N>(task, t[1]), corner<N>(task, t[2]));
  if (triangle.flat()) return;
  kernels::forEachCrossing(triangle, rect, task.column, [&](Crossing c) {
    const Crossing counted = c ^ Crossing(task.reversed);
    pages.add(&counted, 1);
  });
}

/// The longer side of the rectangle around a triangle, as rows see it.
double extent(const RowsTask& task, std::int64_t i) {
  const auto& t = task.triangles[task.ids[i]];
  double longest = 0;
  for (int axis = 0; axis < 2; ++axis) {
    const auto [low, high] =
        std::minmax({task.points[3 * std::size_t(t[0]) + axis], task.points[3 * std::size_t(t[1]) + axis],
                     task.points[3 * std::size_t(t[2]) + axis]});
    longest = std::max(longest, high - low);
  }
  return longest;
}

template <class Word>
int sweepOneByOne(const RowSweep<Word>& s) {
  constexpr int kBits = 8 * sizeof(Word);
  const Word samples = ~Word{0} >> (kBits - s.samples);
  int irregular = 0;
  for (int row = 0; row < s.rows; ++row) {
    Word after;
    const bool regular =
        kernels::sweepRow<Word>({s.rises[row], s.falls[row]}, static_cast<Word>(s.winding[row] + s.offset), after);
    s.inside[row] = after & samples;
    if (regular)
      s.winding[row] = static_cast<std::make_signed_t<Word>>((after >> (kBits - 1)) - static_cast<Word>(s.offset));
    else
      s.irregular[irregular++] = static_cast<std::uint16_t>(row);
  }
  return irregular;
}

} // namespace

RowPages::RowPages(int bricks, int log2)
    : mWide(log2 > 2)
    , mRows((8 << log2) * (8 << log2))
    , mPageWords(std::size_t(mRows) * (mWide ? 2 : 1))
    , mPages(std::size_t(bricks), -1) {}

std::int32_t RowPages::touch(int brick) {
  if (mWords.size() < mUsedWords + mPageWords) mWords.resize(mUsedWords + mPageWords, 0);
  const std::size_t first = std::exchange(mUsedWords, mUsedWords + mPageWords);
  return mPages[brick] = static_cast<std::int32_t>(first / kPageUnit);
}

template <class Word>
void RowPages::addAs(const Crossing* crossings, int count) {
  // Held here: writes to the pages' words might be writes to these, for all that the compiler knows.
  const std::int32_t* const pages = mPages.data();
  const int rows = mRows;
  std::uint64_t* words = mWords.data();
  for (int i = 0; i < count; ++i) {
    const Crossing c = crossings[i];
    const int brick = kernels::crossingBrick(c);
    std::int32_t page = pages[brick];
    if (page < 0) [[unlikely]] {
      page = touch(brick);
      words = mWords.data();
    }
    Word& word = reinterpret_cast<Word*>(
        words + std::size_t(page) * kPageUnit)[kernels::crossingRow(c) + (kernels::crossingRises(c) ? 0 : rows)];
    const Word before = word, bit = Word{1} << kernels::crossingSample(c);
    word = before | bit;
    if (before & bit) [[unlikely]]
      mExtra.push_back(c);
  }
}

void RowPages::add(const Crossing* crossings, int count) {
  if (mWide)
    addAs<std::uint64_t>(crossings, count);
  else
    addAs<std::uint32_t>(crossings, count);
}

void RowPages::sortExtra() { std::sort(mExtra.begin(), mExtra.end()); }

void RowPages::clear() {
  std::fill(mWords.begin(), mWords.begin() + static_cast<std::ptrdiff_t>(mUsedWords), 0);
  std::fill(mPages.begin(), mPages.end(), -1);
  mExtra.clear();
  mUsedWords = 0;
}

RowRect rowsAround(const RowsTask& task, std::int64_t i) {
  const auto& t = task.triangles[task.ids[i]];
  const double* points = task.points;
  const std::int32_t inset = kernels::stagger(0, task.column.log2);
  const auto range = [&](int axis, std::int32_t low, std::int32_t high) {
    const auto [least, greatest] =
        std::minmax({points[3 * std::size_t(t[0]) + axis], points[3 * std::size_t(t[1]) + axis],
                     points[3 * std::size_t(t[2]) + axis]});
    return kernels::rowRange(least, greatest, inset, low, high);
  };
  const auto x = range(0, task.box.x0, task.box.x1), y = range(1, task.box.y0, task.box.y1);
  return {x.first, y.first, x.last, y.last};
}

void crossRowsOf(const RowsTask& task, std::int64_t i, RowPages& pages) {
  const RowRect rect = rowsAround(task, i);
  if (rect.empty()) return;
  const double longest = extent(task, i);
  if (longest < kernels::kExactInDoubles)
    crossAs<double>(task, i, rect, pages);
  else if (longest < kernels::kExactInInt64)
    crossAs<std::int64_t>(task, i, rect, pages);
  else
    crossAs<__int128>(task, i, rect, pages);
}

void crossRowsOneByOne(const RowsTask& task, RowPages& pages) {
  for (std::int64_t i = 0; i < task.count; ++i) crossRowsOf(task, i, pages);
}

int sweepRowsOneByOne(const RowSweep<std::uint32_t>& sweep) { return sweepOneByOne(sweep); }
int sweepRowsOneByOne(const RowSweep<std::uint64_t>& sweep) { return sweepOneByOne(sweep); }

} // namespace volcaustic
