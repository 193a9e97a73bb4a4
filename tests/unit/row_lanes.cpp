// Crossings of rows with triangles and winding numbers along rows: every instruction set against the reference, and the
// reference against arithmetic that cannot round.
#include "backends/lanes.h"
#include "backends/row_pages.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace volcaustic::test {
namespace {

using kernels::Crossing;
using kernels::kFixedOne;
using kernels::stagger;

/// Triangles and one column of bricks that they are voxelised in.
struct Scene {
  int log2 = 2;
  int bricks = 3;
  bool reversed = false;
  std::vector<double> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  void add(const std::array<std::array<double, 3>, 3>& corners) {
    const auto first = static_cast<std::uint32_t>(points.size() / 3);
    for (const auto& corner : corners)
      for (const double x : corner) points.push_back(std::round(x * kFixedOne));
    triangles.push_back({first, first + 1, first + 2});
  }
  [[nodiscard]] int edge() const { return 8 << log2; }
  /// The second column along x, the third along y.
  [[nodiscard]] RowsTask task(const std::vector<std::uint32_t>& ids) const {
    const int n = edge();
    const kernels::RowRect rows{n, 2 * n, 2 * n - 1, 3 * n - 1};
    return {points.data(),
            triangles.data(),
            ids.data(),
            static_cast<std::int64_t>(ids.size()),
            {rows.x0, rows.y0, log2, bricks * n},
            rows,
            reversed};
  }
  [[nodiscard]] std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> all(triangles.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    return all;
  }
};

/// Everything that pages hold, in an order of its own.
template <class Word>
std::vector<std::uint64_t> contents(const Scene& scene, RowPages& pages) {
  std::vector<std::uint64_t> all;
  pages.sortExtra();
  for (int brick = 0; brick < scene.bricks; ++brick) {
    all.push_back(pages.touched(brick));
    if (!pages.touched(brick)) continue;
    const Word* words = pages.page<Word>(brick);
    all.insert(all.end(), words, words + 2 * std::size_t(scene.edge()) * scene.edge());
  }
  all.insert(all.end(), pages.extra().begin(), pages.extra().end());
  return all;
}
std::vector<std::uint64_t> crossings(const Scene& scene, const LaneSet& lanes) {
  RowPages pages(scene.bricks, scene.log2);
  const std::vector<std::uint32_t> ids = scene.ids();
  lanes.crossRows(scene.task(ids), pages);
  return scene.log2 > 2 ? contents<std::uint64_t>(scene, pages) : contents<std::uint32_t>(scene, pages);
}

/// Triangles of every size around the column, some through it from far away, some flat, some on samples.
Scene soup(int log2, int seed) {
  Scene scene;
  scene.log2 = log2;
  scene.reversed = seed % 2 == 1;
  const double n = scene.edge();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 400 - seed; ++i) { // no whole number of registers
    const double size = n * std::exp2(-8 + 12.0 * (i % 40) / 40) * (i % 50 == 7 ? 0x1p12 : i % 50 == 9 ? 0x1p24 : 1);
    const std::array<double, 3> middle{1.5 * n + n * unit(random), 2.5 * n + n * unit(random),
                                       2 * n * (1 + unit(random))};
    std::array<std::array<double, 3>, 3> t;
    for (auto& corner : t)
      for (int a = 0; a < 3; ++a) corner[a] = middle[a] + size * unit(random);
    if (i % 17 == 3) // corners and edges on samples
      for (auto& corner : t)
        for (double& x : corner) x = std::round(x) + 0.5 / (1 << log2);
    if (i % 23 == 5) t[2] = t[1];
    if (i % 29 == 11) t[0][0] = t[1][0] = t[2][0];
    scene.add(t);
  }
  return scene;
}

TEST(RowLanes, CrossWhatTheReferenceCrosses) {
  for (int log2 = 0; log2 <= 3; ++log2)
    for (int seed = 1; seed <= 3; ++seed) {
      const Scene scene = soup(log2, seed);
      const auto expected = crossings(scene, laneSet("scalar"));
      for (const LaneSet& lanes : laneSets())
        EXPECT_EQ(crossings(scene, lanes), expected) << lanes.name << ", " << log2 << ", " << seed;
    }
}

/// Rows, sampled exactly as documented, that a triangle crosses below their last sample, by arithmetic on 128 bits.
std::vector<Crossing> byDefinition(const Scene& scene, int t) {
  using Wide = __int128;
  const auto ids = scene.ids();
  const RowsTask task = scene.task(ids);
  const int n = scene.edge(), s = 1 << scene.log2;
  std::array<std::array<Wide, 3>, 3> c;
  for (int k = 0; k < 3; ++k)
    for (int a = 0; a < 3; ++a) c[k][a] = static_cast<Wide>(scene.points[3 * scene.triangles[t][k] + a]);
  std::vector<Crossing> found;
  for (int i = task.box.x0; i <= task.box.x1; ++i)
    for (int j = task.box.y0; j <= task.box.y1; ++j) {
      const int p = i % s, q = j % s;
      const Wide x = Wide(i) * 65536 + (2 * q + 1) * 32768 / s, y = Wide(j) * 65536 + (2 * p + 1) * 32768 / s;
      // The sample is (x + eps, y + eps^2): signs of areas to first order, then to second.
      const auto side = [&](int k) {
        const auto &a = c[k], &b = c[(k + 1) % 3];
        const Wide value = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        const Wide first = -(b[1] - a[1]), second = b[0] - a[0];
        const auto sign = [](Wide v) { return (v > 0) - (v < 0); };
        return value != 0 ? sign(value) : first != 0 ? sign(first) : sign(second);
      };
      const int turn = side(0);
      if (turn == 0 || side(1) != turn || side(2) != turn) continue;
      // The plane's height over the sample: compared with each sample in whole numbers.
      const Wide ux = c[1][0] - c[0][0], uy = c[1][1] - c[0][1], vx = c[2][0] - c[0][0], vy = c[2][1] - c[0][1];
      const Wide area = ux * vy - uy * vx;
      if (area == 0) continue;
      const long double wb = (long double)((x - c[0][0]) * vy - (y - c[0][1]) * vx) / (long double)area,
                        wc = (long double)(ux * (y - c[0][1]) - uy * (x - c[0][0])) / (long double)area;
      const long double z =
          (long double)c[0][2] + wb * (long double)(c[1][2] - c[0][2]) + wc * (long double)(c[2][2] - c[0][2]);
      const long double k = std::ceil((z - (2 * (p * s + q) + 1) * 32768.0L / (s * s)) / 65536);
      const int sample = static_cast<int>(std::clamp<long double>(k, 0, scene.bricks * n));
      if (sample < scene.bricks * n)
        found.push_back(kernels::packCrossing(sample, 3 + scene.log2, (i - task.box.x0) * n + j - task.box.y0,
                                              (turn < 0) != scene.reversed));
    }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(RowLanes, TheReferenceIsTheDefinition) {
  for (const int log2 : {0, 2, 3}) {
    Scene scene = soup(log2, 5 + log2);
    int different = 0, all = 0;
    for (int t = 0; t < static_cast<int>(scene.triangles.size()); ++t) {
      const auto expected = byDefinition(scene, t);
      RowPages pages(scene.bricks, log2);
      const std::vector<std::uint32_t> one{static_cast<std::uint32_t>(t)};
      laneSet("scalar").crossRows(scene.task(one), pages);
      std::vector<Crossing> found;
      for (int brick = 0; brick < scene.bricks; ++brick) {
        if (!pages.touched(brick)) continue;
        const int rows = scene.edge() * scene.edge();
        for (int row = 0; row < 2 * rows; ++row) {
          const std::uint64_t word =
              log2 > 2 ? pages.page<std::uint64_t>(brick)[row] : pages.page<std::uint32_t>(brick)[row];
          for (int k = 0; k < 64; ++k)
            if (word >> k & 1)
              found.push_back(kernels::packCrossing(brick * scene.edge() + k, 3 + log2, row % rows, row < rows));
        }
      }
      std::sort(found.begin(), found.end());
      // Which rows are crossed is exact; the height of a steep or huge triangle may round to the next sample.
      ASSERT_EQ(found.size(), expected.size()) << t;
      for (std::size_t i = 0; i < found.size(); ++i) {
        ++all;
        different += found[i] != expected[i];
      }
    }
    EXPECT_GT(all, 1000);
    EXPECT_LE(different, all / 1000) << log2;
  }
}

TEST(RowLanes, EdgeFunctionsAreSumsOfTheirParts) {
  std::mt19937_64 random(3);
  for (const double size : {0x1p12, 0x1p20, kernels::kExactInDoubles / 4}) {
    std::uniform_real_distribution<double> any(-size, size);
    const auto whole = [&] { return std::round(any(random)); };
    for (int i = 0; i < 200; ++i) {
      const auto corner = [&] { return kernels::Vec3<double>(whole(), whole(), whole()); };
      const auto a = corner(), b = corner(), c = corner();
      const kernels::RowTriangle<double> triangle(a, b, c);
      const double x = whole(), y = whole(), dx = stagger(i & 3, 2), dy = stagger(i >> 2 & 3, 2);
      const auto at = triangle.valuesAt(x + dx, y + dy), line = triangle.valuesOfLine(x, dy),
                 across = triangle.valuesAcross(dx, y);
      EXPECT_EQ(line.a + across.a, at.a);
      EXPECT_EQ(line.b + across.b, at.b);
      EXPECT_EQ(line.c + across.c, at.c);
    }
  }
}

/// Rows through a brick: mostly as of a closed surface, some of them not.
template <class Word>
struct Rows {
  static constexpr int kRows = 256;
  std::vector<Word> rises, falls, inside;
  std::vector<std::make_signed_t<Word>> winding;
  std::vector<std::uint16_t> irregular;
  int samples, offset;

  Rows(int seed, int samples_, int offset_)
      : rises(kRows)
      , falls(kRows)
      , inside(kRows)
      , winding(kRows)
      , irregular(kRows)
      , samples(samples_)
      , offset(offset_) {
    std::mt19937 random(seed);
    for (int row = 0; row < kRows; ++row) {
      int w = static_cast<int>(random() % 2);
      winding[row] = static_cast<std::make_signed_t<Word>>(w - offset);
      for (int k = 0; k < samples; ++k) {
        if (random() % 8 != 0) continue;
        (w == 0 ? rises : falls)[row] |= Word{1} << k;
        w = 1 - w;
      }
      if (row % 13 == 4) rises[row] |= Word{1} << random() % samples;
      if (row % 31 == 7) winding[row] += static_cast<int>(random() % 5) - 2;
    }
  }
  int sweep(int (*run)(const RowSweep<Word>&)) {
    const int count =
        run({rises.data(), falls.data(), winding.data(), inside.data(), irregular.data(), kRows, samples, offset});
    irregular.resize(count);
    for (const std::uint16_t row : irregular) inside[row] = 0; // left to whoever walks them
    return count;
  }
};

template <class Word>
void compareSweeps(int (*run)(const RowSweep<Word>&), std::string_view name, int samples) {
  for (int seed = 0; seed < 20; ++seed) {
    const int offset = seed % 3 - 1;
    const Rows<Word> before(seed, samples, offset);
    Rows<Word> reference = before, lanes = before;
    const int count = reference.sweep(sweepRowsOneByOne);
    EXPECT_GT(count, 0);
    EXPECT_LT(count, Rows<Word>::kRows / 3);
    lanes.sweep(run);
    EXPECT_EQ(lanes.irregular, reference.irregular) << name;
    EXPECT_EQ(lanes.inside, reference.inside) << name;
    EXPECT_EQ(lanes.winding, reference.winding) << name;
    // What was swept is what a walk along the row finds; what was not kept its winding number.
    for (int row = 0; row < Rows<Word>::kRows; ++row) {
      auto winding = static_cast<std::int32_t>(before.winding[row]);
      const Word inside = kernels::insideBits<Word>({before.rises[row], before.falls[row]}, nullptr, 0, nullptr, offset,
                                                    samples, winding);
      if (std::binary_search(reference.irregular.begin(), reference.irregular.end(), row)) {
        EXPECT_EQ(reference.winding[row], before.winding[row]);
      } else {
        EXPECT_EQ(reference.inside[row], inside);
        EXPECT_EQ(reference.winding[row], winding);
      }
    }
  }
}

TEST(RowLanes, SweepAsTheReferenceAndAWalkDo) {
  for (const LaneSet& lanes : laneSets()) {
    for (const int samples : {8, 16, 32}) compareSweeps<std::uint32_t>(lanes.sweepRows32, lanes.name, samples);
    compareSweeps<std::uint64_t>(lanes.sweepRows64, lanes.name, 64);
  }
}

} // namespace
} // namespace volcaustic::test
