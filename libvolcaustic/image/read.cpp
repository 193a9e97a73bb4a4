#include "core/guarded_process.h"
#include "image/image_file.h"
#include "volcaustic/error.h"

#include <cstdint>
#include <istream>
#include <OpenImageIO/imageio.h>
#include <ostream>

namespace volcaustic {

namespace {

using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

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

void requirePlausible(const ImageSpec& spec, const std::string& place, std::uint64_t fileBytes, const RunContext& ctx) {
  if (spec.deep) throw Error(ErrorKind::Input, place + ": is a deep image; flatten it first");
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1)
    throw Error(ErrorKind::Input, place + ": damaged: it claims " + std::to_string(spec.width) + " x " +
                                      std::to_string(spec.height) + " pixels of " + std::to_string(spec.nchannels) +
                                      " channels");
  const std::uint64_t values = std::uint64_t(spec.width) * std::uint64_t(spec.height);
  ctx.requireMemory(values > UINT64_MAX / 4096 ? UINT64_MAX : values * std::uint64_t(spec.nchannels) * sizeof(float),
                    place);
  if (spec.get_string_attribute("compression") == "none" && spec.image_bytes(true) > fileBytes)
    throw Error(ErrorKind::Input, place + ": damaged: " + std::to_string(fileBytes) + " bytes cannot hold the " +
                                      std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                                      " pixels that it claims");
}

/// sRGB to linear, then alpha multiplied in, for formats that store display values and straight alpha.
void linearise(std::vector<float>& pixels, const ImageSpec& spec) {
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  const bool straight = spec.get_int_attribute("oiio:UnassociatedAlpha") != 0 && spec.alpha_channel >= 0;
  for (std::size_t i = 0; i < pixels.size(); i += channels) {
    const float alpha = straight ? pixels[i + std::size_t(spec.alpha_channel)] : 1;
    for (std::size_t c = 0; c < channels; ++c)
      if (static_cast<int>(c) != spec.alpha_channel) pixels[i + c] = linearFromSrgb(pixels[i + c]) * alpha;
  }
}

/// Decodes the first picture of the file. Only for the guarded child, whose copy of OpenImageIO's settings is its own.
void decode(const std::string& place, std::uint64_t fileBytes, const RunContext& ctx, std::ostream& out) {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", 1);
  OIIO::attribute("openexr:core", 1); // the OpenEXR reader that keeps no pool of threads
  ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = ImageInput::open(place, &wanted);
  if (!input) throw Error(ErrorKind::Input, place + ": cannot be read as an image: " + OIIO::geterror());
  const ImageSpec spec = input->spec();
  requirePlausible(spec, place, fileBytes, ctx);

  const auto channels = static_cast<std::size_t>(spec.nchannels);
  const std::size_t pixelCount = std::size_t(spec.width) * std::size_t(spec.height);
  std::vector<float> pixels(pixelCount * channels);
  if (!input->read_image(0, 0, 0, spec.nchannels, TypeDesc::FLOAT, pixels.data()))
    throw Error(ErrorKind::Input, place + ": damaged: " + input->geterror());
  if (!spec.format.is_floating_point()) linearise(pixels, spec);

  put(out, static_cast<std::uint64_t>(spec.width));
  put(out, static_cast<std::uint64_t>(spec.height));
  put(out, channels);
  std::vector<float> plane(pixelCount);
  for (std::size_t c = 0; c < channels; ++c) {
    put(out, spec.channel_name(static_cast<int>(c)));
    for (std::size_t i = 0; i < pixelCount; ++i) plane[i] = pixels[i * channels + c];
    out.write(reinterpret_cast<const char*>(plane.data()), static_cast<std::streamsize>(pixelCount * sizeof(float)));
  }
  for (const auto& attribute : spec.extra_attribs) {
    if (attribute.type() != OIIO::TypeString) continue;
    put(out, attribute.name().string());
    put(out, attribute.get_string());
  }
}

} // namespace

Image readImage(const std::filesystem::path& path, const RunContext& ctx) {
  const std::string place = path.string();
  const std::uint64_t fileBytes = readableFileSize(place);
  ctx.throwIfCancelled();
  const GuardedBytes decoded = runGuarded(place, GuardLimits::forFile(fileBytes, ctx), ctx,
                                          [&](std::ostream& out) { decode(place, fileBytes, ctx, out); });
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
