#include "image/image_file.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cfloat>
#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledOutputFile.h>
#include <optional>
#include <sstream>

namespace volcaustic {

namespace {

constexpr int kNoThreads = 0;

/// Distances and step counts need more than eleven bits.
bool keepsFloat(const std::string& channel) {
  const auto endsWith = [&](std::string_view suffix) { return std::string_view(channel).ends_with(suffix); };
  return channel == "Z" || endsWith(".Z") || channel == "steps" || channel.starts_with("steps.");
}

/// Finite values stay finite: beyond half's range they become its largest.
std::vector<half> toHalf(const std::vector<float>& plane) {
  std::vector<half> result(plane.size());
  std::transform(plane.begin(), plane.end(), result.begin(),
                 [](float v) { return half(std::isfinite(v) ? std::clamp(v, -float(HALF_MAX), float(HALF_MAX)) : v); });
  return result;
}

Imf::Compression codec(ExrCompression compression) {
  switch (compression) {
  case ExrCompression::None:
    return Imf::NO_COMPRESSION;
  case ExrCompression::Zips:
    return Imf::ZIPS_COMPRESSION;
  case ExrCompression::Piz:
    return Imf::PIZ_COMPRESSION;
  case ExrCompression::Dwaa:
    return Imf::DWAA_COMPRESSION;
  case ExrCompression::Zip:
    break;
  }
  return Imf::ZIP_COMPRESSION;
}

/// As many finite numbers as asked for and nothing else, or nothing.
std::optional<std::vector<float>> numbersIn(const std::string& text, std::size_t count) {
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  std::vector<float> numbers;
  for (float number; words >> number;) numbers.push_back(number);
  const bool good = words.eof() && numbers.size() == count &&
                    std::all_of(numbers.begin(), numbers.end(), [](float v) { return std::isfinite(v); });
  return good ? std::optional(numbers) : std::nullopt;
}

/// Sets the attribute of OpenEXR's own that metadata may hold as text.
bool insertStandard(Imf::Header& header, const std::string& key, const std::string& text) {
  if (key == "worldToCamera" || key == "worldToNDC") {
    const auto n = numbersIn(text, 16);
    if (!n) return false;
    Imath::M44f matrix;
    std::copy(n->begin(), n->end(), &matrix[0][0]);
    header.insert(key, Imf::M44fAttribute(matrix));
    return true;
  }
  const auto number = numbersIn(text, 1);
  if (!number || !((*number)[0] > 0)) return false;
  if (key == "screenWindowWidth")
    header.screenWindowWidth() = (*number)[0];
  else if (key == "pixelAspectRatio")
    header.pixelAspectRatio() = (*number)[0];
  else
    return false;
  return true;
}

Imf::Header headerOf(const Image& image, const std::vector<std::size_t>& channels, const ImageWriteOptions& options) {
  Imf::Header header(image.width, image.height);
  header.compression() = codec(options.compression);
  if (options.tiles > 0)
    header.setTileDescription(
        Imf::TileDescription(static_cast<unsigned>(options.tiles), static_cast<unsigned>(options.tiles)));
  Imf::addChromaticities(header, Imf::Chromaticities()); // OpenEXR's default primaries are Rec. 709's
  header.insert("software", Imf::StringAttribute("volcaustic " VOLCAUSTIC_VERSION));
  header.insert("colorInteropID", Imf::StringAttribute(kLinearColours));
  for (const std::size_t i : channels) {
    const std::string& name = image.channels[i];
    header.channels().insert(name, Imf::Channel(options.half && !keepsFloat(name) ? Imf::HALF : Imf::FLOAT));
  }
  for (const auto& [key, value] : image.metadata) {
    if (key == "software" || key == "colorInteropID" || insertStandard(header, key, value)) continue;
    const std::string name =
        header.find(key) == header.end() ? key : "volcaustic:" + key; // OpenEXR's own names are taken
    header.insert(name, Imf::StringAttribute(value));
  }
  return header;
}

} // namespace

void writeExr(const std::filesystem::path& target, const Image& image, const std::vector<std::size_t>& channels,
              const ImageWriteOptions& options) {
  std::vector<std::vector<half>> halves;
  halves.reserve(channels.size());
  const Imf::Header header = headerOf(image, channels, options);
  Imf::FrameBuffer frame;
  const auto insert = [&](const std::string& name, Imf::PixelType type, const void* data, std::size_t bytes) {
    frame.insert(
        name, Imf::Slice(type, static_cast<char*>(const_cast<void*>(data)), bytes, bytes * std::size_t(image.width)));
  };
  for (const std::size_t i : channels) {
    const std::string& name = image.channels[i];
    if (header.channels()[name].type == Imf::HALF)
      insert(name, Imf::HALF, halves.emplace_back(toHalf(image.planes[i])).data(), sizeof(half));
    else
      insert(name, Imf::FLOAT, image.planes[i].data(), sizeof(float));
  }
  if (options.tiles > 0) {
    Imf::TiledOutputFile file(target.c_str(), header, kNoThreads);
    file.setFrameBuffer(frame);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(target.c_str(), header, kNoThreads);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  }
}

} // namespace volcaustic
