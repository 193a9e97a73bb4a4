// From scene-linear light to the integers of display formats.
#include "image/colour.h"
#include "image/image_file.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

float clamped(float v) { return v > 0 ? std::min(v, 1.0F) : 0.0F; } // NaN becomes 0

/// S. Hill's fit of the ACES 1.0 reference rendering and sRGB output transforms (2016; published in M. Pettineo,
/// BakingLab, ACES.hlsl): into the primaries of the rendering transform with its desaturation, one rational curve for
/// each channel, and back. 18 % grey comes out at 10.6 %, as ACES has it on a display; white is reached from about 16
/// on.
Colour acesFilmic(const Colour& light) {
  constexpr ColourMatrix kIn{
      {{0.59719F, 0.35458F, 0.04823F}, {0.07600F, 0.90834F, 0.01566F}, {0.02840F, 0.13383F, 0.83777F}}};
  constexpr ColourMatrix kOut{
      {{1.60475F, -0.53108F, -0.07367F}, {-0.10208F, 1.10813F, -0.00605F}, {-0.00327F, -0.07276F, 1.07602F}}};
  Colour v = kIn * light;
  for (float& x : v) x = (x * (x + 0.0245786F) - 0.000090537F) / (x * (0.983729F * x + 0.4329510F) + 0.238081F);
  return kOut * v;
}

/// What is added to a value between two codes before it is cut off, above 0 and below 1: neighbours differ as much as
/// possible, so that the eye, and any filter, sees the mean. The rank-1 lattice of M. Roberts, The unreasonable
/// effectiveness of quasirandom sequences (2018), on the plastic number; its values are multiples of 2^-8, so that a
/// value that is a code stays one.
float dither(std::size_t x, std::size_t y) {
  constexpr std::uint32_t kAcross = 3242174889U, kDown = 2447445414U; // 2^32 over the plastic number, and its square
  const std::uint32_t place = static_cast<std::uint32_t>(x) * kAcross + static_cast<std::uint32_t>(y) * kDown;
  return (static_cast<float>(place >> 24U) + 0.5F) / 256;
}

/// Clamped, toned and sRGB-encoded.
void encode(float* colour, std::size_t count, float gain, ToneCurve tone) {
  constexpr float kBrightest = 1e6F; // the curve is flat long before; its squares must stay finite
  for (std::size_t c = 0; c < count; ++c) colour[c] = colour[c] > 0 ? std::min(colour[c] * gain, kBrightest) : 0.0F;
  if (tone == ToneCurve::Aces) {
    const Colour light = count == 3 ? Colour{colour[0], colour[1], colour[2]} : Colour{colour[0], colour[0], colour[0]};
    const Colour toned = acesFilmic(light);
    std::copy_n(toned.begin(), count, colour);
  }
  for (std::size_t c = 0; c < count; ++c) colour[c] = clamped(srgbFromLinear(clamped(colour[c])));
}

} // namespace

void encodeForDisplay(std::vector<float>& pixels, std::size_t width, std::size_t colours, bool alpha, int bits,
                      const ImageWriteOptions& options) {
  const auto gain = static_cast<float>(std::exp2(options.exposure));
  const std::size_t channels = colours + (alpha ? 1 : 0);
  for (std::size_t i = 0; i * channels < pixels.size(); ++i) {
    float* pixel = pixels.data() + i * channels;
    if (alpha) {
      float& opacity = pixel[colours];
      opacity = clamped(opacity);
      for (std::size_t c = 0; c < colours; ++c) pixel[c] = opacity > 0 ? pixel[c] / opacity : 0.0F;
    }
    encode(pixel, colours, gain, options.tone);
    if (bits != 8) continue;
    const float offset = dither(i % width, i / width);
    for (std::size_t c = 0; c < channels; ++c) pixel[c] = std::min(std::floor(pixel[c] * 255 + offset), 255.0F) / 255;
  }
}

} // namespace volcaustic
