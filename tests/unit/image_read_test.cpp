// Real images against other readers of them, and damaged ones.
#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <half.h>
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <iterator>

namespace volcaustic::test {
namespace {

/// One channel of an .exr by OpenEXR itself.
std::vector<float> planeOf(Imf::InputFile& file, const std::string& channel, int width, int height) {
  std::vector<float> plane(std::size_t(width) * height);
  const Imath::Box2i box = file.header().dataWindow();
  Imf::FrameBuffer frame;
  const std::ptrdiff_t first = box.min.x + std::ptrdiff_t{box.min.y} * width;
  frame.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(plane.data() - first), sizeof(float),
                                   sizeof(float) * std::size_t(width)));
  file.setFrameBuffer(frame);
  file.readPixels(box.min.y, box.max.y);
  return plane;
}

/// A Radiance picture, R G B of each pixel: G. Ward, Real pixels, Graphics Gems II, 1991, with run lengths by channel.
std::vector<float> radiancePicture(const std::filesystem::path& path, int& width, int& height) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  while (std::getline(file, line) && line.rfind("-Y ", 0) != 0) {
  }
  if (std::sscanf(line.c_str(), "-Y %d +X %d", &height, &width) != 2) return {};
  std::vector<float> pixels;
  std::vector<std::uint8_t> row(4 * std::size_t(width));
  for (int y = 0; y < height; ++y) {
    std::uint8_t start[4];
    file.read(reinterpret_cast<char*>(start), 4);
    if (start[0] != 2 || start[1] != 2 || start[2] * 256 + start[3] != width) return {};
    for (int c = 0; c < 4; ++c)
      for (int x = 0; x < width;) {
        const int count = file.get(), run = count > 128 ? count - 128 : count;
        for (int i = 0, value = count > 128 ? file.get() : 0; i < run && x < width; ++i)
          row[4 * std::size_t(x++) + c] = static_cast<std::uint8_t>(count > 128 ? value : file.get());
      }
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const std::uint8_t* p = row.data() + 4 * std::size_t(x);
        pixels.push_back(p[3] == 0 ? 0 : std::ldexp(float(p[c]), p[3] - 136));
      }
  }
  return file ? pixels : std::vector<float>{};
}

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST(ImageRead, ExrFilesAsOpenExrReadsThem) {
  const auto folder = sharedPath("data/env");
  VOLCAUSTIC_NEED_SHARED(folder);
  // Carrots.exr has other primaries, below.
  for (const char* name : {"StageEnvLatLong.exr", "WavyLinesLatLong.exr", "uffizi_latlong_128.exr", "comp_piz.exr",
                           "Garden.exr", "AllHalfValues.exr", "BrightRingsNanInf.exr"}) {
    const Image image = readImage(folder / name);
    Imf::InputFile file((folder / name).c_str());
    const Imath::Box2i box = file.header().dataWindow();
    ASSERT_EQ(image.width, box.max.x - box.min.x + 1) << name;
    ASSERT_EQ(image.height, box.max.y - box.min.y + 1) << name;
    for (std::size_t c = 0; c < image.channels.size(); ++c) {
      const std::vector<float> theirs = planeOf(file, image.channels[c], image.width, image.height);
      EXPECT_TRUE(std::equal(theirs.begin(), theirs.end(), image.planes[c].begin(), same)) << name << image.channels[c];
    }
    EXPECT_EQ(image.metadata.at("colorInteropID"), kLinearColours);
  }
}

TEST(ImageRead, RadianceFilesAsWardWritesThem) {
  const auto folder = sharedPath("data/env");
  VOLCAUSTIC_NEED_SHARED(folder);
  for (const char* name : {"StinsonBeach.hdr", "rooftop_small.hdr"}) {
    int width = 0, height = 0;
    const std::vector<float> theirs = radiancePicture(folder / name, width, height);
    const Image image = readImage(folder / name);
    ASSERT_EQ(image.width, width);
    ASSERT_EQ(image.height, height);
    ASSERT_EQ(theirs.size(), 3 * image.planes[0].size());
    for (std::size_t i = 0; i < theirs.size(); ++i) ASSERT_EQ(image.planes[i % 3][i / 3], theirs[i]) << name << i;
  }
}

TEST(ImageRead, OtherPrimariesBecomeRec709) {
  const TemporaryFolder folder;
  constexpr std::array<std::array<float, 3>, 4> kColours{{{1, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0.2F, 0.3F, 0.4F}}};
  Imf::Header header(4, 1);
  Imf::addChromaticities(header,
                         Imf::Chromaticities({0.7347F, 0.2653F}, {0, 1}, {0.0001F, -0.077F}, {0.32168F, 0.33767F}));
  Imf::FrameBuffer frame;
  for (int c = 0; c < 3; ++c) {
    const std::string name(1, "RGB"[c]);
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(&kColours[0][c])),
                                  3 * sizeof(float), 0));
  }
  {
    Imf::OutputFile file((folder / "aces.exr").c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(1);
  }
  const Image image = readImage(folder / "aces.exr");
  // ACES 2065-1 to linear sRGB with Bradford's adaptation, as published with OpenColorIO's ACES configurations.
  constexpr double kMatrix[3][3] = {
      {2.521686, -1.134131, -0.387555}, {-0.276480, 1.372719, -0.096239}, {-0.015378, -0.152975, 1.168353}};
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 4; ++i) {
      const double wanted =
          kMatrix[c][0] * kColours[i][0] + kMatrix[c][1] * kColours[i][1] + kMatrix[c][2] * kColours[i][2];
      EXPECT_NEAR(image.planes[image.find(std::string(1, "RGB"[c]))][i], wanted, 2e-4) << c << i;
    }
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
