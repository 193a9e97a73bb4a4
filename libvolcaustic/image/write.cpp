#include "core/atomic_file.h"
#include "image/image_file.h"
#include "image/imageio_module.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace volcaustic {

namespace {

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
  // No alpha: the picture's background is part of R, G and B already.
  const std::array channels{image.find("R"), image.find("G"), image.find("B")};
  if (std::find(channels.begin(), channels.end(), -1) != channels.end())
    throw Error(ErrorKind::Usage, path.string() + ": the image has no channels R, G and B; write an .exr");
  const ImageFileTarget target{.path = path.string(),
                               .temporary = temporary.string(),
                               .width = image.width,
                               .height = image.height,
                               .prefersFloat = prefersFloat(extensionOf(path)),
                               .metadata = image.metadata};
  imageIo(target.path).write(target, [&](bool floatingPoint) {
    std::vector<float> pixels = interleaved(image, channels);
    if (!floatingPoint) encodeForDisplay(pixels, options.exposure);
    return pixels;
  });
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
