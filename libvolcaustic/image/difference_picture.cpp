#include "image/colour.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace volcaustic {

namespace {

/// Every sixteenth colour of "magma", sRGB (N. Smith, S. van der Walt, 2015; CC0), whose lightness rises evenly.
/// Straight lines between them stay within 3/255 of all 256.
constexpr std::array<std::array<std::uint8_t, 3>, 17> kMagma{{{0, 0, 4},
                                                              {10, 8, 34},
                                                              {29, 17, 70},
                                                              {54, 16, 106},
                                                              {80, 18, 124},
                                                              {105, 28, 129},
                                                              {130, 38, 129},
                                                              {156, 46, 127},
                                                              {182, 55, 121},
                                                              {207, 65, 112},
                                                              {230, 81, 99},
                                                              {245, 105, 92},
                                                              {251, 135, 97},
                                                              {254, 165, 113},
                                                              {254, 195, 135},
                                                              {253, 224, 162},
                                                              {252, 253, 191}}};

} // namespace

Image differencePicture(int width, int height, const std::vector<float>& map) {
  Image image;
  image.width = width;
  image.height = height;
  for (const char* channel : {"R", "G", "B"}) image.add(channel);
  if (map.size() != image.planes[0].size())
    throw Error(ErrorKind::Usage, "differencePicture: the map has another number of pixels than the picture");
  for (std::size_t i = 0; i < map.size(); ++i) {
    const float place = std::clamp(map[i], 0.0F, 1.0F) * (kMagma.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(place), kMagma.size() - 2);
    for (std::size_t c = 0; c < 3; ++c) {
      const float code = std::lerp(float(kMagma[below][c]), float(kMagma[below + 1][c]), place - float(below));
      image.planes[c][i] = linearFromSrgb(code / 255);
    }
  }
  return image;
}

} // namespace volcaustic
