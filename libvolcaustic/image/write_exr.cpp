#include "image/image_file.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cfloat>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

namespace volcaustic {

namespace {

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

Imf::Header headerOf(const Image& image, const ImageWriteOptions& options) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::addChromaticities(header, Imf::Chromaticities()); // OpenEXR's default primaries are Rec. 709's
  for (const std::string& name : image.channels)
    header.channels().insert(name, Imf::Channel(options.half && !keepsFloat(name) ? Imf::HALF : Imf::FLOAT));
  for (const auto& [key, value] : image.metadata) {
    const std::string name =
        header.find(key) == header.end() ? key : "volcaustic:" + key; // OpenEXR's own names are taken
    header.insert(name, Imf::StringAttribute(value));
  }
  return header;
}

} // namespace

void writeExr(const std::filesystem::path& target, const Image& image, const ImageWriteOptions& options) {
  std::vector<std::vector<half>> halves;
  halves.reserve(image.planes.size());
  const Imf::Header header = headerOf(image, options);
  Imf::FrameBuffer frame;
  const auto insert = [&](const std::string& name, Imf::PixelType type, const void* data, std::size_t bytes) {
    frame.insert(
        name, Imf::Slice(type, static_cast<char*>(const_cast<void*>(data)), bytes, bytes * std::size_t(image.width)));
  };
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    const std::string& name = image.channels[c];
    if (header.channels()[name].type == Imf::HALF)
      insert(name, Imf::HALF, halves.emplace_back(toHalf(image.planes[c])).data(), sizeof(half));
    else
      insert(name, Imf::FLOAT, image.planes[c].data(), sizeof(float));
  }
  constexpr int kNoThreads = 0;
  Imf::OutputFile file(target.c_str(), header, kNoThreads);
  file.setFrameBuffer(frame);
  file.writePixels(image.height);
}

} // namespace volcaustic
