#include "support/shared_data.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"
#include "volcaustic/view.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <iterator>

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

TEST(ImageExr, EveryCodecAndLayout) {
  const TemporaryFolder folder;
  const Image written = layers(100, 70);
  constexpr std::pair<ExrCompression, Imf::Compression> kCodecs[] = {{ExrCompression::None, Imf::NO_COMPRESSION},
                                                                     {ExrCompression::Zips, Imf::ZIPS_COMPRESSION},
                                                                     {ExrCompression::Zip, Imf::ZIP_COMPRESSION},
                                                                     {ExrCompression::Piz, Imf::PIZ_COMPRESSION},
                                                                     {ExrCompression::Dwaa, Imf::DWAA_COMPRESSION}};
  for (const int tiles : {0, 32})
    for (const auto& [compression, theirs] : kCodecs) {
      ImageWriteOptions options;
      options.half = false;
      options.compression = compression;
      options.tiles = tiles;
      writeImage(folder / "a.exr", written, options);
      const Imf::InputFile file((folder / "a.exr").c_str());
      EXPECT_EQ(file.header().compression(), theirs);
      ASSERT_EQ(file.header().hasTileDescription(), tiles > 0);
      if (tiles > 0) {
        EXPECT_EQ(file.header().tileDescription().xSize, 32u);
        EXPECT_EQ(file.header().tileDescription().mode, Imf::ONE_LEVEL);
      }
      const Image read = readImage(folder / "a.exr");
      for (const std::string& name : written.channels) {
        const auto &a = written.planes[written.find(name)], &b = read.planes[read.find(name)];
        if (compression != ExrCompression::Dwaa || name == "depth.Z") {
          EXPECT_EQ(a, b) << name << ' ' << tiles;
        }
      }
    }
}

TEST(ImageExr, AttributesThatOtherProgramsKnow) {
  const TemporaryFolder folder;
  Image image = layers();
  const Camera camera{
      .position = {3, -4, 2}, .target = {0.5, 0, 1}, .up = {0, 0, 1}, .fieldOfView = 40, .resolution = {37, 21}};
  image.metadata.merge(cameraMetadata(camera));
  image.metadata["software"] = "another program";
  writeImage(folder / "a.exr", image);
  const Imf::InputFile file((folder / "a.exr").c_str());
  const Imf::Header& header = file.header();
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("software").value().substr(0, 11), "volcaustic ");
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("colorInteropID").value(), "lin_rec709_scene");
  EXPECT_EQ(Imf::chromaticities(header).white, Imath::V2f(0.3127F, 0.3290F));
  const double halfHeight = std::tan(20 * 3.14159265358979 / 180);
  EXPECT_NEAR(header.screenWindowWidth(), 2 * halfHeight * 37 / 21, 1e-6);

  const Imath::M44f &toCamera = Imf::worldToCamera(header), &toPicture = Imf::worldToNDC(header);
  const Imath::V3f target(0.5F, 0, 1), eye(3, -4, 2), above(0.5F, 0, 1.1F);
  const float distance = (target - eye).length();
  EXPECT_LT((target * toCamera - Imath::V3f(0, 0, distance)).length(), 1e-5F);
  EXPECT_GT((above * toCamera).y, 0.05F);
  EXPECT_NEAR((above * toCamera).x, 0, 1e-6);
  const Imath::V3f middle = target * toPicture; // divides by w
  EXPECT_NEAR(middle.x, 0.5, 1e-5);
  EXPECT_NEAR(middle.y, 0.5, 1e-5);
  EXPECT_LT((above * toPicture).y, 0.5F) << "y points down";
  const Imath::V3f right = (target - eye).cross(Imath::V3f(0, 0, 1)).normalized();
  const auto halfWidth = static_cast<float>(halfHeight * 37 / 21);
  EXPECT_NEAR(((target + right * (distance * halfWidth)) * toPicture).x, 1, 1e-5);
}

TEST(ImageExr, MetadataSurvivesAConversion) {
  const TemporaryFolder folder;
  Image image = layers();
  image.metadata.merge(cameraMetadata({}));
  writeImage(folder / "a.exr", image);
  writeImage(folder / "b.exr", readImage(folder / "a.exr"));
  const Imf::InputFile a((folder / "a.exr").c_str()), b((folder / "b.exr").c_str());
  EXPECT_EQ(Imf::worldToNDC(a.header()), Imf::worldToNDC(b.header()));
  EXPECT_EQ(a.header().screenWindowWidth(), b.header().screenWindowWidth());
  EXPECT_EQ(readImage(folder / "a.exr").metadata, readImage(folder / "b.exr").metadata);
}

TEST(ImageExr, LayersByNameAndByPattern) {
  const TemporaryFolder folder;
  const auto written = [&](std::vector<std::string> names) {
    ImageWriteOptions options;
    options.layers = std::move(names);
    writeImage(folder / "a.exr", layers(), options);
    std::vector<std::string> channels = readImage(folder / "a.exr").channels;
    std::sort(channels.begin(), channels.end());
    return channels;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(written({"R", "G", "B", "A", "caustic.*"}), (Names{"A", "B", "G", "R", "caustic.R"}));
  EXPECT_EQ(written({"*.R"}), (Names{"caustic.R", "transmittance.R"}));
  EXPECT_EQ(written({"depth.Z", "depth.*"}), (Names{"depth.Z"}));
  EXPECT_EQ(written({}).size(), layers().channels.size());
  try {
    (void)written({"R", "caustics.*"});
    FAIL() << "there is no such layer";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("caustic.R"), std::string::npos) << error.what();
  }
}

TEST(ImageExr, SameBytesEveryTime) {
  const TemporaryFolder folder;
  writeImage(folder / "a.exr", layers());
  writeImage(folder / "b.exr", layers());
  EXPECT_TRUE(bytesOf(folder / "a.exr") == bytesOf(folder / "b.exr"));
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

} // namespace
} // namespace volcaustic::test
