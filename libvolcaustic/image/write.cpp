#include "core/atomic_file.h"
#include "image/image_file.h"
#include "image/imageio_module.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace volcaustic {

namespace {

std::string extensionOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

/// Bits of a channel where nobody asks for other ones.
int usualBits(const std::string& extension) {
  constexpr std::array kFloatFormats{".hdr", ".rgbe", ".pfm", ".tif", ".tiff", ".fits"};
  return std::find(kFloatFormats.begin(), kFloatFormats.end(), extension) != kFloatFormats.end() ? 32 : 8;
}

void requireSound(const std::filesystem::path& path, const Image& image, const ImageWriteOptions& options) {
  const std::size_t pixels =
      static_cast<std::size_t>(std::max(image.width, 0)) * static_cast<std::size_t>(std::max(image.height, 0));
  const bool sound =
      pixels > 0 && !image.channels.empty() && image.channels.size() == image.planes.size() &&
      std::all_of(image.planes.begin(), image.planes.end(), [&](const auto& p) { return p.size() == pixels; });
  const auto refuse = [&](const char* what) { throw Error(ErrorKind::Usage, path.string() + ": " + what); };
  if (!sound) refuse("the image has no pixels, or channels of different sizes");
  if (options.tiles != 0 && (options.tiles < 8 || options.tiles > 4096))
    refuse("tiles must be from 8 to 4096 pixels, or 0 for scan lines");
  if (options.bits != 0 && options.bits != 8 && options.bits != 16 && options.bits != 32)
    refuse("bits must be 8, 16, 32, or 0 for what the format usually has");
  if (!std::isfinite(options.exposure)) refuse("the exposure must be a finite number of stops");
}

void writePicture(const std::filesystem::path& path, const std::filesystem::path& temporary, const Image& image,
                  const std::vector<std::size_t>& channels, const ImageWriteOptions& options, const RunContext& ctx) {
  const std::string place = path.string();
  const ColourPlanes planes = colourPlanes(image, channels, options.alpha, place);
  const ImageFileTarget target{.path = place,
                               .temporary = temporary.string(),
                               .width = image.width,
                               .height = image.height,
                               .colours = static_cast<int>(planes.colours.size()),
                               .alpha = planes.alpha != nullptr,
                               .bits = options.bits != 0 ? options.bits : usualBits(extensionOf(path)),
                               .metadata = image.metadata};
  imageIo(place).write(target, [&](const ImageFileFormat& format) {
    if (options.bits != 0 && format.bits != options.bits)
      ctx.warn(place + ": has " + std::to_string(format.bits) + " bits a channel; the format has none of " +
               std::to_string(options.bits));
    if (options.alpha && !format.alpha) ctx.warn(place + ": has no alpha; the format holds none");
    std::vector<float> pixels = interleaved(planes, format.alpha);
    if (format.bits < 32)
      encodeForDisplay(pixels, static_cast<std::size_t>(image.width), planes.colours.size(), format.alpha, format.bits,
                       options);
    return pixels;
  });
}

} // namespace

void writeImage(const std::filesystem::path& path, const Image& image, const ImageWriteOptions& options,
                const RunContext& ctx) {
  requireSound(path, image, options);
  ctx.throwIfCancelled();
  const std::vector<std::size_t> channels = chosenChannels(image.channels, options.layers, path.string());
  AtomicFile file(path);
  if (extensionOf(path) == ".exr") {
    try {
      writeExr(file.path(), image, channels, options);
    } catch (const std::exception& error) {
      throw Error(ErrorKind::File, path.string() + ": cannot be written: " + error.what());
    }
  } else {
    writePicture(path, file.path(), image, channels, options, ctx);
  }
  file.commit();
}

} // namespace volcaustic
