#include "core/atomic_file.h"
#include "image/image_file.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <OpenImageIO/imageio.h>

namespace volcaustic {

namespace {

using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

std::string extensionOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

bool prefersFloat(const std::string& extension) {
  constexpr std::array kFloatFormats{".hdr", ".rgbe", ".pfm", ".tif", ".tiff", ".fits"};
  return std::find(kFloatFormats.begin(), kFloatFormats.end(), extension) != kFloatFormats.end();
}

void requireSound(const std::filesystem::path& path, const Image& image) {
  const std::size_t pixels =
      static_cast<std::size_t>(std::max(image.width, 0)) * static_cast<std::size_t>(std::max(image.height, 0));
  const bool sound =
      pixels > 0 && !image.channels.empty() && image.channels.size() == image.planes.size() &&
      std::all_of(image.planes.begin(), image.planes.end(), [&](const auto& p) { return p.size() == pixels; });
  if (!sound)
    throw Error(ErrorKind::Usage, path.string() + ": the image has no pixels, or channels of different sizes");
}

std::vector<float> interleaved(const Image& image, const std::array<int, 3>& channels) {
  const std::size_t pixels = image.planes.front().size();
  std::vector<float> result(pixels * channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c)
    for (std::size_t i = 0; i < pixels; ++i) result[i * channels.size() + c] = image.planes[channels[c]][i];
  return result;
}

/// Exposure, then the sRGB curve, clamped to 0..1.
void encodeForDisplay(std::vector<float>& pixels, double exposure) {
  const auto gain = static_cast<float>(std::exp2(exposure));
  const auto clamped = [](float v) { return v > 0 ? std::min(v, 1.0F) : 0.0F; }; // NaN becomes 0
  for (float& v : pixels) v = clamped(srgbFromLinear(clamped(v * gain)));
}

void writeThroughOiio(const std::filesystem::path& path, const std::filesystem::path& temporary, const Image& image,
                      const ImageWriteOptions& options) {
  const auto output = ImageOutput::create(path.string());
  if (!output) {
    (void)OIIO::geterror(); // taken, so that it is not reported elsewhere
    throw Error(ErrorKind::Usage,
                path.string() + ": no image format of this extension can be written; use .exr or .png");
  }
  // No alpha: the picture's background is part of R, G and B already.
  const std::array channels{image.find("R"), image.find("G"), image.find("B")};
  if (std::find(channels.begin(), channels.end(), -1) != channels.end())
    throw Error(ErrorKind::Usage, path.string() + ": the image has no channels R, G and B; write an .exr");

  const bool wantFloat = prefersFloat(extensionOf(path));
  ImageSpec spec(image.width, image.height, static_cast<int>(channels.size()),
                 wantFloat ? TypeDesc::FLOAT : TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", wantFloat ? "Linear" : "sRGB");
  for (const auto& [key, value] : image.metadata) spec.attribute(key, value);
  output->threads(1);
  bool good = output->open(temporary.string(), spec);
  if (good) {
    std::vector<float> pixels = interleaved(image, channels);
    if (!output->spec().format.is_floating_point()) encodeForDisplay(pixels, options.exposure);
    good = output->write_image(TypeDesc::FLOAT, pixels.data()) && output->close();
  }
  if (!good) throw Error(ErrorKind::File, path.string() + ": cannot be written: " + output->geterror());
}

} // namespace

void writeImage(const std::filesystem::path& path, const Image& image, const ImageWriteOptions& options,
                const RunContext& ctx) {
  requireSound(path, image);
  ctx.throwIfCancelled();
  AtomicFile file(path);
  if (extensionOf(path) == ".exr") {
    try {
      writeExr(file.path(), image, options);
    } catch (const std::exception& error) {
      throw Error(ErrorKind::File, path.string() + ": cannot be written: " + error.what());
    }
  } else {
    writeThroughOiio(path, file.path(), image, options);
  }
  file.commit();
}

} // namespace volcaustic
