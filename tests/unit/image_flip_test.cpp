// FLIP: what must hold of any such measure, and the numbers of its published implementation.
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <limits>

namespace volcaustic::test {
namespace {

constexpr int kWidth = 96, kHeight = 64;
const FlipOptions kDisplay{.highDynamicRange = false};

Image picture(const std::function<std::array<double, 3>(int x, int y)>& colour, int width = kWidth,
              int height = kHeight) {
  Image image;
  image.width = width;
  image.height = height;
  for (const char* name : {"R", "G", "B"}) image.add(name);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto c = colour(x, y);
      for (std::size_t i = 0; i < 3; ++i) image.planes[i][std::size_t(y) * width + x] = static_cast<float>(c[i]);
    }
  return image;
}

Image plain(double r, double g, double b) {
  return picture([&](int, int) { return std::array{r, g, b}; });
}

/// Smooth waves of colour, and the same with a fine pattern in red, darker blue and a box.
std::array<double, 3> waves(double x, double y) {
  return {0.5 + 0.4 * std::sin(0.21 * x + 0.13 * y), 0.5 + 0.4 * std::cos(0.17 * x - 0.11 * y),
          0.5 + 0.4 * std::sin(0.045 * x + 0.23 * y)};
}
std::array<double, 3> disturbed(double x, double y) {
  auto c = waves(x, y);
  c[0] += 0.15 * std::sin(1.9 * x) * std::cos(1.3 * y);
  c[2] *= 0.8;
  if (x >= 40 && x < 60 && y >= 20 && y < 30) c = {0.25, 0.25, 0.25};
  for (double& v : c) v = std::clamp(v, 0.0, 1.0);
  return c;
}

/// 0 to 1, from place and number alone.
double noise(int x, int y, int c) {
  std::uint32_t h = static_cast<std::uint32_t>(x * 73856093) ^ static_cast<std::uint32_t>(y * 19349663) ^
                    static_cast<std::uint32_t>(c * 83492791);
  h = (h ^ (h >> 15U)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12U)) * 0x297a2d39U;
  return ((h ^ (h >> 15U)) >> 8U) / double(1U << 24U);
}

Image scaled(Image image, float factor, float power = 1) {
  for (auto& plane : image.planes)
    for (float& v : plane) v = factor * std::pow(v, power);
  return image;
}

TEST(Flip, NothingDiffersFromItself) {
  const Image a = picture(waves);
  for (const bool high : {false, true}) {
    const FlipDifference d = flipDifference(a, a, {.highDynamicRange = high});
    EXPECT_EQ(d.mean, 0);
    EXPECT_EQ(d.maximum, 0);
    EXPECT_EQ(d.map.size(), a.planes[0].size());
  }
}

TEST(Flip, BlackAndWhiteAndTheFarthestColours) {
  // HyAB of black and white is 100, of green and blue the largest that the scale knows.
  EXPECT_NEAR(flipDifference(plain(0, 0, 0), plain(1, 1, 1), kDisplay).mean, 0.9677, 1e-3);
  EXPECT_NEAR(flipDifference(plain(0, 1, 0), plain(0, 0, 1), kDisplay).mean, 1, 1e-4);
}

TEST(Flip, SymmetricForDisplayValues) {
  const Image a = picture(waves), b = picture(disturbed);
  EXPECT_EQ(flipDifference(a, b, kDisplay).map, flipDifference(b, a, kDisplay).map);
}

TEST(Flip, GrowsWithTheDisturbance) {
  const Image a = picture(waves);
  for (const bool high : {false, true}) {
    double before = 0;
    for (const double amount : {0.01, 0.03, 0.1, 0.3}) {
      const Image b = picture([&](int x, int y) {
        auto c = waves(x, y);
        for (int i = 0; i < 3; ++i) c[i] = std::clamp(c[i] + amount * (noise(x, y, i) - 0.5), 0.0, 1.0);
        return c;
      });
      const double mean = flipDifference(a, b, {.highDynamicRange = high}).mean;
      EXPECT_GT(mean, before * 1.3) << amount;
      before = mean;
    }
    EXPECT_LT(before, 1);
  }
}

TEST(Flip, MovesWithThePictures) {
  // Grey around, so that nothing depends on the border.
  const auto at = [](int dx, int dy, bool changed) {
    return picture([=](int x, int y) {
      const int u = x - dx - 30, v = y - dy - 22;
      const bool inside = u >= 0 && u < 24 && v >= 0 && v < 12;
      return inside ? (changed ? disturbed(u + 40, v + 20) : waves(u, v)) : std::array{0.4, 0.4, 0.4};
    });
  };
  const auto still = flipDifference(at(0, 0, false), at(0, 0, true), kDisplay);
  const auto moved = flipDifference(at(9, 5, false), at(9, 5, true), kDisplay);
  EXPECT_NEAR(still.mean, moved.mean, 1e-6);
  EXPECT_GT(still.maximum, 0.1);
  for (int y = 0; y + 5 < kHeight; ++y)
    for (int x = 0; x + 9 < kWidth; ++x)
      ASSERT_NEAR(still.map[y * kWidth + x], moved.map[(y + 5) * kWidth + x + 9], 1e-5) << x << ' ' << y;
}

TEST(Flip, FinePatternsFadeWithDistance) {
  const Image grey = plain(0.3, 0.3, 0.3);
  const Image checks = picture([](int x, int y) {
    const double v = 0.3 + ((x + y) % 2 ? 0.1 : -0.1);
    return std::array{v, v, v};
  });
  const auto mean = [&](double pixelsPerDegree) {
    return flipDifference(grey, checks, {.pixelsPerDegree = pixelsPerDegree, .highDynamicRange = false}).mean;
  };
  EXPECT_GT(mean(20), 2 * mean(134));
  EXPECT_GT(mean(67), mean(134));
}

TEST(Flip, SameBitsForEveryNumberOfThreads) {
  const Image a = picture(waves), b = picture(disturbed);
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  const FlipDifference alone = flipDifference(a, b, {}, one), together = flipDifference(a, b, {}, two);
  EXPECT_EQ(alone.map, together.map);
  EXPECT_EQ(alone.mean, together.mean);
}

TEST(Flip, BrightnessOfBothDoesNotMatterToHighDynamicRange) {
  const Image a = picture(waves), b = picture(disturbed);
  const FlipDifference dim = flipDifference(scaled(a, 1 / 1024.0F), scaled(b, 1 / 1024.0F)),
                       bright = flipDifference(scaled(a, 1024), scaled(b, 1024));
  EXPECT_NEAR(dim.mean, bright.mean, 1e-4);
  EXPECT_GT(dim.mean, 0.05);
  EXPECT_NEAR(dim.exposures.front() - bright.exposures.front(), 20, 1e-3);
}

TEST(Flip, HighDynamicRangeSeesWhatAClampedPictureHides) {
  Image a = scaled(picture(waves), 0.2F);
  for (auto& plane : a.planes) plane[kWidth * 30 + 40] = 20;
  Image b = a;
  for (auto& plane : b.planes) plane[kWidth * 30 + 40] = 5;
  EXPECT_EQ(flipDifference(a, b, kDisplay).maximum, 0);
  EXPECT_GT(flipDifference(a, b).maximum, 0.1);
}

/// Mean and maximum of flip-evaluator 1.7 (NVIDIA's own), given linear values.
TEST(Flip, NumbersOfThePublishedImplementation) {
  struct Case {
    bool high;
    double pixelsPerDegree, mean, maximum;
  };
  for (const Case& c : {Case{false, 67, 0.2691092, 0.8948377}, Case{false, 30, 0.2787162, 0.9612162},
                        Case{true, 67, 0.3536792, 0.9845626}, Case{true, 30, 0.3695428, 0.9883769}}) {
    const float factor = c.high ? 20 : 1, power = c.high ? 3 : 1;
    const FlipDifference d = flipDifference(scaled(picture(waves), factor, power),
                                            scaled(picture(disturbed), factor, power), {c.pixelsPerDegree, c.high});
    EXPECT_NEAR(d.mean, c.mean, 1e-4);
    EXPECT_NEAR(d.maximum, c.maximum, 3e-4);
    EXPECT_EQ(d.exposures.size(), c.high ? 3u : 0u);
    if (c.high) {
      EXPECT_NEAR(d.exposures.front(), -2.7818, 1e-3);
      EXPECT_NEAR(d.exposures.back(), -0.6862, 2e-3);
    }
  }
}

TEST(Flip, PixelsThatAreNotFiniteDifferWhollyOrNotAtAll) {
  const Image a = picture(waves);
  Image b = a;
  b.planes[1][100] = std::numeric_limits<float>::quiet_NaN();
  b.planes[2][200] = std::numeric_limits<float>::infinity();
  const FlipDifference d = flipDifference(a, b);
  EXPECT_EQ(d.map[100], 1);
  EXPECT_EQ(d.map[200], 1);
  EXPECT_TRUE(std::all_of(d.map.begin(), d.map.end(), [](float v) { return v >= 0 && v <= 1; }));
  EXPECT_EQ(flipDifference(b, b).maximum, 0);
}

TEST(Flip, BlackReferencesAndGreyPictures) {
  const FlipDifference d = flipDifference(plain(0, 0, 0), plain(1, 1, 1));
  EXPECT_GT(d.mean, 0.9);
  Image grey;
  grey.width = grey.height = 4;
  grey.add("Y");
  Image white = grey;
  std::fill(white.planes[0].begin(), white.planes[0].end(), 1.0F);
  EXPECT_NEAR(flipDifference(grey, white, kDisplay).mean, 0.9677, 1e-3);
}

TEST(Flip, WhatCannotBeCompared) {
  const Image a = picture(waves), small = picture(waves, 8, 8);
  const auto kindOf = [](const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::Internal;
  };
  EXPECT_EQ(kindOf([&] { (void)flipDifference(a, small); }), ErrorKind::Input);
  EXPECT_EQ(kindOf([&] { (void)flipDifference(a, a, {.pixelsPerDegree = 0}); }), ErrorKind::Usage);
  Image layer = a;
  layer.channels = {"direct.R", "direct.G", "direct.B"};
  EXPECT_EQ(kindOf([&] { (void)flipDifference(layer, layer); }), ErrorKind::Input);
}

TEST(DifferencePicture, RunsFromBlackToPaleYellowAndBrightens) {
  std::vector<float> map(256);
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<float>(i) / 255;
  const Image image = differencePicture(256, 1, map);
  double before = -1;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const double luminance = 0.2126 * image.planes[0][i] + 0.7152 * image.planes[1][i] + 0.0722 * image.planes[2][i];
    EXPECT_GT(luminance, before) << i;
    before = luminance;
  }
  EXPECT_LT(image.planes[0][0], 0.001);
  EXPECT_GT(before, 0.9);
  EXPECT_THROW((void)differencePicture(3, 3, map), Error);
}

} // namespace
} // namespace volcaustic::test
