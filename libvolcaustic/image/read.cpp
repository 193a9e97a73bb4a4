#include "core/guarded_process.h"
#include "image/colour.h"
#include "image/imageio_module.h"
#include "image/primaries.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <algorithm>
#include <cstdint>
#include <istream>
#include <ostream>

namespace volcaustic {

namespace {

// The guarded child hands the decoded image over in these few primitives; both ends are in this file.
void put(std::ostream& out, std::uint64_t value) { out.write(reinterpret_cast<const char*>(&value), sizeof value); }
void put(std::ostream& out, const std::string& text) {
  put(out, text.size());
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
}
std::uint64_t takeNumber(std::istream& in) {
  std::uint64_t value = 0;
  in.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}
std::string takeText(std::istream& in) {
  std::string text(takeNumber(in), '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
}

void requirePlausible(const ImageFileHeader& header, const std::string& place, std::uint64_t fileBytes,
                      const RunContext& ctx) {
  if (header.deep) throw Error(ErrorKind::Input, place + ": is a deep image; flatten it first");
  const std::string size = std::to_string(header.width) + " x " + std::to_string(header.height) + " pixels";
  if (header.width < 1 || header.height < 1 || header.depth > 1 || header.channels.empty())
    throw Error(ErrorKind::Input,
                place + ": damaged: it claims " + size + " of " + std::to_string(header.channels.size()) + " channels");
  const std::uint64_t pixels = std::uint64_t(header.width) * std::uint64_t(header.height);
  ctx.requireMemory(pixels > UINT64_MAX / 4096 ? UINT64_MAX : pixels * header.channels.size() * sizeof(float), place);
  if (header.uncompressedBytes > fileBytes)
    throw Error(ErrorKind::Input, place + ": damaged: " + std::to_string(fileBytes) + " bytes cannot hold the " + size +
                                      " that it claims");
}

/// sRGB to linear, then alpha multiplied in, for formats that store display values and straight alpha.
void linearise(std::vector<float>& pixels, const ImageFileHeader& header) {
  const std::size_t channels = header.channels.size();
  const bool straight = header.straightAlpha && header.alphaChannel >= 0;
  if (header.floatingPoint && !straight) return;
  for (std::size_t i = 0; i < pixels.size(); i += channels) {
    const float alpha = straight ? pixels[i + std::size_t(header.alphaChannel)] : 1;
    for (std::size_t c = 0; c < channels; ++c) {
      if (static_cast<int>(c) == header.alphaChannel) continue;
      const float linear = header.floatingPoint ? pixels[i + c] : linearFromSrgb(pixels[i + c]);
      pixels[i + c] = linear * alpha;
    }
  }
}

/// Colours of other primaries become Rec. 709: every layer's R, G and B.
void toRec709(std::vector<float>& pixels, const ImageFileHeader& header) {
  const auto conversion = rec709From(header.chromaticities);
  if (!conversion) return;
  const auto indexOf = [&](const std::string& name) {
    return std::find(header.channels.begin(), header.channels.end(), name) - header.channels.begin();
  };
  const auto channels = std::ssize(header.channels);
  for (const std::string& red : header.channels) {
    if (red != "R" && !red.ends_with(".R")) continue;
    const std::string layer = red.substr(0, red.size() - 1);
    const std::ptrdiff_t r = indexOf(red), g = indexOf(layer + "G"), b = indexOf(layer + "B");
    if (g == channels || b == channels) continue;
    for (std::size_t i = 0; i < pixels.size(); i += header.channels.size()) {
      float* pixel = pixels.data() + i;
      const Colour colour = *conversion * Colour{pixel[r], pixel[g], pixel[b]};
      pixel[r] = colour[0];
      pixel[g] = colour[1];
      pixel[b] = colour[2];
    }
  }
}

/// Decodes the first picture of the file. Only for the guarded child, whose copy of OpenImageIO's settings is its own.
void decode(const ImageIo& io, const std::string& place, std::uint64_t fileBytes, const RunContext& ctx,
            std::ostream& out) {
  ImageFileHeader header;
  std::vector<float> pixels = io.read(place, [&](const ImageFileHeader& claimed) {
    requirePlausible(claimed, place, fileBytes, ctx);
    header = claimed;
  });
  linearise(pixels, header);
  toRec709(pixels, header);
  header.metadata["colorInteropID"] = header.floatingPoint ? kLinearColours : kDisplayColours;

  const std::size_t channels = header.channels.size();
  put(out, static_cast<std::uint64_t>(header.width));
  put(out, static_cast<std::uint64_t>(header.height));
  put(out, channels);
  std::vector<float> plane(pixels.size() / channels);
  for (std::size_t c = 0; c < channels; ++c) {
    put(out, header.channels[c]);
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = pixels[i * channels + c];
    out.write(reinterpret_cast<const char*>(plane.data()), static_cast<std::streamsize>(plane.size() * sizeof(float)));
  }
  for (const auto& [key, value] : header.metadata) {
    put(out, key);
    put(out, value);
  }
}

} // namespace

Image readImage(const std::filesystem::path& path, const RunContext& ctx) {
  const std::string place = path.string();
  const std::uint64_t fileBytes = readableFileSize(place);
  ctx.throwIfCancelled();
  const ImageIo& io = imageIo(place); // loaded here: the child's memory is for the image
  const GuardedBytes decoded = runGuarded(place, GuardLimits::forFile(fileBytes, ctx), ctx,
                                          [&](std::ostream& out) { decode(io, place, fileBytes, ctx, out); });
  MemoryBuffer buffer(decoded.bytes());
  std::istream in(&buffer);
  Image image;
  image.width = static_cast<int>(takeNumber(in));
  image.height = static_cast<int>(takeNumber(in));
  for (std::uint64_t channels = takeNumber(in); channels > 0; --channels) {
    std::vector<float>& plane = image.add(takeText(in));
    in.read(reinterpret_cast<char*>(plane.data()), static_cast<std::streamsize>(plane.size() * sizeof(float)));
  }
  while (in.peek() != std::istream::traits_type::eof()) {
    const std::string key = takeText(in);
    image.metadata[key] = takeText(in);
  }
  return image;
}

} // namespace volcaustic
