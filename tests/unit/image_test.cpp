#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

namespace volcaustic::test {
namespace {

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Image layers(int width = 37, int height = 21) {
  Image image;
  image.width = width;
  image.height = height;
  for (const char* name :
       {"R", "G", "B", "A", "caustic.R", "direct.G", "background.B", "transmittance.R", "depth.Z", "steps.Y"}) {
    std::vector<float>& plane = image.add(name);
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane[i] = static_cast<float>(std::exp(std::sin(double(i) * 0.7 + double(image.channels.size())) * 6));
  }
  image.metadata = {{"scene_hash", "abc"}, {"channels", "a name that OpenEXR uses itself"}};
  return image;
}

Image grey(float value) {
  Image image;
  image.width = 8;
  image.height = 4;
  for (const char* name : {"R", "G", "B"})
    for (float& v : image.add(name)) v = value;
  return image;
}

TEST(ImageExr, FloatsComeBackExactly) {
  const TemporaryFolder folder;
  ImageWriteOptions options;
  options.half = false;
  const Image written = layers();
  writeImage(folder / "a.exr", written, options);
  const Image read = readImage(folder / "a.exr");
  ASSERT_EQ(read.channels.size(), written.channels.size());
  for (const std::string& name : written.channels) {
    ASSERT_GE(read.find(name), 0) << name;
    EXPECT_EQ(read.planes[read.find(name)], written.planes[written.find(name)]) << name;
  }
  EXPECT_EQ(read.metadata.at("scene_hash"), "abc");
}

TEST(ImageExr, HalvesKeepElevenBitsAndDepthAllOfThem) {
  const TemporaryFolder folder;
  Image written = layers();
  written.planes[0][5] = 1e9F;
  writeImage(folder / "a.exr", written);
  const Image read = readImage(folder / "a.exr");
  for (const std::string& name : written.channels) {
    const auto &a = written.planes[written.find(name)], &b = read.planes[read.find(name)];
    if (name == "depth.Z" || name == "steps.Y") {
      EXPECT_EQ(a, b);
    }
    for (std::size_t i = 0; i < a.size(); ++i)
      if (a[i] < 65504) {
        ASSERT_NEAR(a[i], b[i], std::max(a[i] / 2048, 6e-8F)) << name;
      }
  }
  EXPECT_EQ(read.planes[read.find("R")][5], 65504) << "too bright for a half, but not infinite";
}

TEST(ImageExr, SameBytesEveryTime) {
  const TemporaryFolder folder;
  writeImage(folder / "a.exr", layers());
  writeImage(folder / "b.exr", layers());
  EXPECT_TRUE(bytesOf(folder / "a.exr") == bytesOf(folder / "b.exr"));
}

TEST(ImagePng, EncodesSrgbAfterExposureAndDecodesIt) {
  const TemporaryFolder folder;
  ImageWriteOptions options;
  for (const auto& [value, stops] : {std::pair{0.5F, 0.0}, std::pair{0.125F, 2.0}}) {
    options.exposure = stops;
    writeImage(folder / "a.png", grey(value), options);
    const Image read = readImage(folder / "a.png");
    ASSERT_EQ(read.channels.size(), 3u);
    const double code = 188 / 255.0; // the byte that half of white is
    EXPECT_NEAR(read.planes[0][0], std::pow((code + 0.055) / 1.055, 2.4), 1e-6);
  }
  writeImage(folder / "a.png", grey(7));
  EXPECT_EQ(readImage(folder / "a.png").planes[1][3], 1);
  writeImage(folder / "a.png", grey(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_EQ(readImage(folder / "a.png").planes[1][3], 0);
}

TEST(ImagePng, HasNoAlphaBecauseTheBackgroundIsInThePicture) {
  const TemporaryFolder folder;
  Image image = grey(0.25F);
  for (float& a : image.add("A")) a = 0.5F;
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

TEST(Image, UnknownNamesAndUnsoundImagesAreErrors) {
  const TemporaryFolder folder;
  const auto kindOf = [](const std::function<void()>& f) {
    try {
      f();
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::Internal;
  };
  EXPECT_EQ(kindOf([&] { writeImage(folder / "a.xyz", grey(1)); }), ErrorKind::Usage);
  EXPECT_EQ(kindOf([&] { writeImage(folder / "a.exr", Image{}); }), ErrorKind::Usage);
  EXPECT_EQ(kindOf([&] { writeImage(folder / "absent" / "a.exr", grey(1)); }), ErrorKind::File);
  EXPECT_EQ(kindOf([&] { (void)readImage(folder / "absent.exr"); }), ErrorKind::File);
  RunContext small;
  small.memoryLimit = 1 << 10;
  writeImage(folder / "a.exr", layers());
  EXPECT_EQ(kindOf([&] { (void)readImage(folder / "a.exr", small); }), ErrorKind::Input);
}

TEST(Image, CompareMeasuresAKnownDifference) {
  const Image a = grey(1);
  Image b = grey(1);
  b.planes[1][0] = 3;
  const auto differences = compareImages(a, b);
  EXPECT_EQ(differences[0].maximum, 0);
  EXPECT_EQ(differences[1].maximum, 2);
  EXPECT_DOUBLE_EQ(differences[1].meanAbsolute, 2.0 / 32);
  EXPECT_DOUBLE_EQ(differences[1].rootMeanSquare, std::sqrt(4.0 / 32));
  EXPECT_THROW((void)compareImages(a, layers(8, 4)), Error);
  EXPECT_THROW((void)compareImages(a, layers()), Error);
}

TEST(ImageFiles, RealEnvironmentsAreRead) {
  const auto folder = sharedPath("data/env");
  VOLCAUSTIC_NEED_SHARED(folder);
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().filename() ==
        "tiled.exr") { // its tiles claim levels that do not exist; OpenEXR's own tools fail on it
      EXPECT_THROW((void)readImage(file.path()), Error);
      continue;
    }
    const Image image = readImage(file.path());
    EXPECT_GT(image.width * image.height, 0) << file.path();
    if (file.path().filename() == "StinsonBeach.hdr") {
      EXPECT_EQ(image.width, 1024);
    }
  }
}

TEST(ImageFiles, DamagedOnesAreErrorsOrPictures) {
  const auto folder = sharedPath("data/env_bad");
  VOLCAUSTIC_NEED_SHARED(folder);
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
    if (!file.is_regular_file()) continue;
    const TemporaryFolder copy; // without an extension OpenImageIO would not know them
    const auto path = file.path().extension() == ".hdr" ? copy / "bad.hdr" : copy / "bad.exr";
    std::filesystem::copy_file(file.path(), path);
    try {
      const Image image = readImage(path);
      EXPECT_EQ(image.planes.size(), image.channels.size());
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Input) << file.path() << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

} // namespace
} // namespace volcaustic::test
