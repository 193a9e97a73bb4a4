// Pictures in formats for the display: exposure, tone, dither, alpha, bits.
#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <cmath>
#include <limits>

namespace volcaustic::test {
namespace {

Image filled(const std::vector<std::pair<const char*, float>>& channels, int width = 8, int height = 4) {
  Image image;
  image.width = width;
  image.height = height;
  for (const auto& [name, value] : channels)
    for (float& v : image.add(name)) v = value;
  return image;
}

Image grey(float value) { return filled({{"R", value}, {"G", value}, {"B", value}}); }

float linear(double code) {
  return static_cast<float>(code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4));
}
double encoded(double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055; }

/// What a display shows of the first pixel, sRGB values 0..1.
std::array<double, 3> shown(const Image& image, const ImageWriteOptions& options) {
  const TemporaryFolder folder;
  ImageWriteOptions fine = options;
  fine.bits = 16;
  writeImage(folder / "a.png", image, fine);
  const Image read = readImage(folder / "a.png");
  return {encoded(read.planes[0][0]), encoded(read.planes[1][0]), encoded(read.planes[2][0])};
}

TEST(ImagePng, EncodesSrgbAfterExposureAndDecodesIt) {
  const TemporaryFolder folder;
  ImageWriteOptions options;
  options.bits = 16;
  for (const auto& [value, stops] : {std::pair{0.5F, 0.0}, std::pair{0.125F, 2.0}}) {
    options.exposure = stops;
    writeImage(folder / "a.png", grey(value), options);
    const Image read = readImage(folder / "a.png");
    ASSERT_EQ(read.channels.size(), 3u);
    EXPECT_NEAR(encoded(read.planes[0][0]), 0.735357, 1.0 / 65535) << "187.5 of 255";
  }
  writeImage(folder / "a.png", grey(7));
  EXPECT_EQ(readImage(folder / "a.png").planes[1][3], 1);
  writeImage(folder / "a.png", grey(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_EQ(readImage(folder / "a.png").planes[1][3], 0);
}

TEST(ImagePng, HasNoAlphaWhereTheBackgroundIsInThePicture) {
  const TemporaryFolder folder;
  Image image = grey(0.25F);
  for (float& a : image.add("A")) a = 0.5F;
  for (const char* name : {"background.R", "background.G", "background.B"}) image.add(name);
  writeImage(folder / "a.png", image);
  const Image read = readImage(folder / "a.png");
  ASSERT_EQ(read.channels.size(), 3u);
  EXPECT_NEAR(read.planes[0][0], 0.25, 0.005);
}

TEST(ImageHdr, StaysLinearAndIgnoresExposure) {
  const TemporaryFolder folder;
  ImageWriteOptions options;
  options.exposure = 3;
  writeImage(folder / "a.hdr", grey(4.5F), options);
  EXPECT_NEAR(readImage(folder / "a.hdr").planes[2][9], 4.5, 4.5 / 128);
}

TEST(ImagePng, GradientsDoNotBand) {
  const TemporaryFolder folder;
  Image image = filled({{"R", 0}, {"G", 0}, {"B", 0}}, 512, 64);
  // Over six codes of 255: steps of 85 pixels without a dither.
  const auto code = [](int x) { return 60 + 6.0 * x / 512; };
  for (auto& plane : image.planes)
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = linear(code(static_cast<int>(i % 512)) / 255);
  writeImage(folder / "a.png", image);
  const Image read = readImage(folder / "a.png");
  for (int x = 0; x + 8 <= 512; x += 4)
    for (int y = 0; y + 8 <= 64; y += 4) {
      double mean = 0;
      for (int i = 0; i < 64; ++i) mean += 255 * encoded(read.planes[0][(y + i / 8) * 512 + x + i % 8]) / 64;
      ASSERT_NEAR(mean, code(x) + 3.5 * 6 / 512, 0.08) << x << ' ' << y;
    }
  for (std::size_t i = 0; i < read.planes[0].size(); ++i) {
    ASSERT_LT(std::abs(255 * encoded(read.planes[0][i]) - code(static_cast<int>(i % 512))), 1.001);
    ASSERT_EQ(read.planes[0][i], read.planes[2][i]) << "grey stays grey";
  }
}

TEST(ImagePng, EveryCodeStaysItself) {
  const TemporaryFolder folder;
  Image image = filled({{"R", 0}, {"G", 0}, {"B", 0}}, 256, 40);
  for (auto& plane : image.planes)
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = linear(static_cast<double>(i % 256) / 255);
  writeImage(folder / "a.png", image);
  const Image read = readImage(folder / "a.png");
  for (std::size_t i = 0; i < read.planes[0].size(); ++i) {
    ASSERT_NEAR(255 * encoded(read.planes[0][i]), static_cast<double>(i % 256), 0.01) << i;
  }
  writeImage(folder / "b.png", read);
  EXPECT_EQ(compareImages(read, readImage(folder / "b.png"))[0].maximum, 0);
}

TEST(ImageBits, SixteenInPngAndTiffAndWhatTheFormatHasElsewhere) {
  const TemporaryFolder folder;
  ImageWriteOptions options;
  options.bits = 16;
  for (const char* name : {"a.png", "a.tif"}) {
    writeImage(folder / name, grey(0.123456F), options);
    const Image read = readImage(folder / name);
    EXPECT_NEAR(encoded(read.planes[0][0]), encoded(0.123456), 1.0 / 65535) << name;
    EXPECT_EQ(read.metadata.at("colorInteropID"), kDisplayColours);
  }
  writeImage(folder / "a.tif", grey(7.25F));
  EXPECT_EQ(readImage(folder / "a.tif").planes[0][0], 7.25F) << "linear floats where nothing is asked for";
  options.bits = 8;
  writeImage(folder / "a.tif", grey(7.25F), options);
  EXPECT_EQ(readImage(folder / "a.tif").planes[0][0], 1);

  std::vector<std::string> warnings;
  RunContext ctx;
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    if (level == LogLevel::Warning) warnings.emplace_back(line);
  };
  options.bits = 16;
  writeImage(folder / "a.jpg", grey(0.5F), options, ctx);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("a.jpg: "), std::string::npos);
  EXPECT_NEAR(encoded(readImage(folder / "a.jpg").planes[1][7]), encoded(0.5), 2.5 / 255);
}

TEST(ImageTone, AcesHasItsGreyItsShoulderAndItsWhite) {
  ImageWriteOptions aces;
  aces.tone = ToneCurve::Aces;
  EXPECT_NEAR(shown(grey(0.18F), aces)[0], encoded(0.1056), 0.002);
  double before = -1;
  for (const float v : {0.0F, 0.01F, 0.05F, 0.2F, 0.5F, 1.0F, 2.0F, 5.0F, 12.0F}) {
    const auto c = shown(grey(v), aces);
    EXPECT_GT(c[0], before) << v;
    EXPECT_NEAR(c[0], c[1], 2e-4) << "grey stays grey";
    before = c[0];
  }
  EXPECT_LT(shown(grey(1), aces)[0], 0.95) << "light above 1 still has room";
  EXPECT_GT(shown(grey(100), aces)[2], 0.999);
  // Bright saturated light fades to white as film does; with the plain curve it stays as saturated as it was.
  const Image red = filled({{"R", 40}, {"G", 0.2F}, {"B", 0.2F}});
  EXPECT_GT(shown(red, aces)[1], 0.6);
  EXPECT_LT(shown(red, {})[1], 0.5);
  ImageWriteOptions brighter = aces;
  brighter.exposure = 3;
  EXPECT_NEAR(shown(grey(0.1F), brighter)[0], shown(grey(0.8F), aces)[0], 1e-4);
  EXPECT_NEAR(shown(grey(std::numeric_limits<float>::infinity()), aces)[0], 1, 1e-6);
}

TEST(ImageAlpha, IsStraightInPngAndMultipliedInWhenRead) {
  const TemporaryFolder folder;
  const Image image = filled({{"R", 0.4F}, {"G", 0.1F}, {"B", 0.0F}, {"A", 0.5F}});
  ImageWriteOptions options;
  for (const char* name : {"a.png", "a.tif"}) {
    options.bits = 16;
    writeImage(folder / name, image, options);
    const Image read = readImage(folder / name);
    ASSERT_EQ(read.channels.size(), 4u) << name;
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(read.planes[c][5], image.planes[c][5], 2e-5) << name << c;
  }
  options.bits = 0;
  writeImage(folder / "a.tif", image, options);
  EXPECT_EQ(readImage(folder / "a.tif").planes[0][3], 0.4F);
  options.layers = {"R", "G", "B"};
  writeImage(folder / "a.png", image, options);
  EXPECT_EQ(readImage(folder / "a.png").channels.size(), 3u);
}

TEST(ImageAlpha, ThatWasNeverFilledInHidesNothing) {
  const TemporaryFolder folder;
  writeImage(folder / "a.png", filled({{"R", 0.4F}, {"G", 0.1F}, {"B", 0.0F}, {"A", 0.0F}}));
  const Image read = readImage(folder / "a.png");
  ASSERT_EQ(read.channels.size(), 3u);
  EXPECT_NEAR(read.planes[0][0], 0.4, 0.005);
}

TEST(ImageAlpha, LeavesTheBackgroundOutWhenAskedFor) {
  const TemporaryFolder folder;
  const Image image = filled({{"R", 0.5F},
                              {"G", 0.5F},
                              {"B", 0.5F},
                              {"A", 0.5F},
                              {"background.R", 0.3F},
                              {"background.G", 0.4F},
                              {"background.B", 0.5F}});
  ImageWriteOptions options;
  options.alpha = true;
  options.bits = 16;
  writeImage(folder / "a.png", image, options);
  const Image read = readImage(folder / "a.png");
  EXPECT_NEAR(read.planes[0][0], 0.2, 2e-5);
  EXPECT_NEAR(read.planes[1][0], 0.1, 2e-5);
  EXPECT_NEAR(read.planes[2][0], 0.0, 2e-5);
  EXPECT_NEAR(read.planes[3][0], 0.5, 1e-5);
  EXPECT_THROW(writeImage(folder / "a.png", grey(1), options), Error);
}

TEST(ImagePicture, OneLayerOrOneChannelAlone) {
  const TemporaryFolder folder;
  const Image image = filled({{"R", 0.5F},
                              {"G", 0.5F},
                              {"B", 0.5F},
                              {"caustic.R", 0.1F},
                              {"caustic.G", 0.2F},
                              {"caustic.B", 0.3F},
                              {"depth.Z", 0.7F}});
  ImageWriteOptions options;
  options.bits = 16;
  options.layers = {"caustic.*"};
  writeImage(folder / "a.png", image, options);
  EXPECT_NEAR(readImage(folder / "a.png").planes[2][0], 0.3, 1e-4);
  options.layers = {"depth.Z"};
  writeImage(folder / "a.png", image, options);
  const Image depth = readImage(folder / "a.png");
  EXPECT_EQ(depth.channels.size(), 1u);
  EXPECT_NEAR(depth.planes[0][0], 0.7, 1e-4);
  options.layers = {"caustic.R", "depth.Z"};
  EXPECT_THROW(writeImage(folder / "a.png", image, options), Error);
}

} // namespace
} // namespace volcaustic::test
