#include "display.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic::viewer {

namespace {

std::uint8_t byteOf(double v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 1.0) * 255)); }

double srgb(double linear) {
  linear = std::clamp(linear, 0.0, 1.0);
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

void put(Pixels& pixels, std::size_t i, const std::array<double, 3>& rgb, std::uint8_t alpha) {
  for (std::size_t c = 0; c < 3; ++c) pixels.rgba[4 * i + c] = byteOf(rgb[c]);
  pixels.rgba[4 * i + 3] = alpha;
}

Pixels blank(int width, int height) {
  return {width, height, std::vector<std::uint8_t>(std::size_t(width) * static_cast<std::size_t>(height) * 4)};
}

} // namespace

std::vector<std::string> layersOf(const Image& image) {
  std::vector<std::string> layers;
  for (const std::string& channel : image.channels) {
    const std::size_t dot = channel.rfind('.');
    const std::string layer = dot == std::string::npos ? "picture" : channel.substr(0, dot);
    if (std::find(layers.begin(), layers.end(), layer) == layers.end()) layers.push_back(layer);
  }
  return layers;
}

Pixels displayed(const Image& image, const std::string& layer, double exposure) {
  const std::string prefix = layer == "picture" ? "" : layer + ".";
  int planes[3] = {image.find(prefix + "R"), image.find(prefix + "G"), image.find(prefix + "B")};
  Pixels pixels = blank(image.width, image.height);
  const std::size_t count = pixels.rgba.size() / 4;
  if (planes[0] >= 0) {
    const double scale = std::exp2(exposure);
    for (std::size_t i = 0; i < count; ++i)
      put(pixels, i,
          {srgb(scale * image.planes[planes[0]][i]), srgb(scale * image.planes[planes[1]][i]),
           srgb(scale * image.planes[planes[2]][i])},
          255);
    return pixels;
  }
  int plane = std::max(image.find(prefix + "Z"), image.find(prefix + "Y"));
  if (plane < 0) return pixels;
  float least = std::numeric_limits<float>::max(), greatest = std::numeric_limits<float>::lowest();
  for (const float v : image.planes[plane])
    if (std::isfinite(v) && v < 1e30f) {
      least = std::min(least, v);
      greatest = std::max(greatest, v);
    }
  const double range = greatest > least ? greatest - least : 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = std::clamp((image.planes[plane][i] - least) / range, 0.0, 1.0);
    put(pixels, i, {t, t, t}, 255);
  }
  return pixels;
}

bool isLight(VolumeLayer layer) {
  return layer == VolumeLayer::Radiance || layer == VolumeLayer::Caustic || layer == VolumeLayer::Direct ||
         layer == VolumeLayer::Energy;
}

float whiteOf(const VolumeSlice& slice) {
  std::vector<float> lit;
  for (const Vec3f& v : slice.values)
    if (const float most = *std::max_element(v.begin(), v.end()); most > 0) lit.push_back(most);
  if (lit.empty()) return 1;
  const auto white = lit.begin() + static_cast<std::ptrdiff_t>(.98 * static_cast<double>(lit.size() - 1));
  std::nth_element(lit.begin(), white, lit.end());
  return *white;
}

Pixels displayed(const VolumeSlice& slice, VolumeLayer layer, const SliceLook& look) {
  Pixels pixels = blank(slice.columns, slice.rows);
  const double scale = std::exp2(look.exposure) / whiteOf(slice);
  const double range = slice.greatest > slice.least ? slice.greatest - slice.least : 1;
  for (std::size_t i = 0; i < slice.values.size(); ++i) {
    const Vec3f& v = slice.values[i];
    std::array<double, 3> rgb;
    if (isLight(layer)) {
      for (int c = 0; c < 3; ++c) rgb[c] = srgb(scale * v[c]);
    } else if (layer == VolumeLayer::Direction) {
      for (int c = 0; c < 3; ++c) rgb[c] = .5 + .5 * v[c]; // as normals are shown
    } else {
      const double t = (v[0] - slice.least) / range;
      rgb = look.colours ? colourOf(t) : std::array<double, 3>{t, t, t};
    }
    put(pixels, i, rgb, look.alpha);
  }
  return pixels;
}

std::array<double, 3> colourOf(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return {.27 - .25 * t - .95 * t * t + 1.92 * t * t * t, .01 + 1.40 * t - .50 * t * t,
          .33 + 1.05 * t - 2.9 * t * t + 1.65 * t * t * t};
}

Histogram histogramOf(const std::vector<float>& values, bool logarithmic, int bins) {
  Histogram h{std::vector<float>(static_cast<std::size_t>(bins)), 0, 0, logarithmic};
  bool any = false;
  const auto counts = [&](float v) { return std::isfinite(v) && v < 1e30f && (!logarithmic || v > 0); };
  for (const float v : values)
    if (counts(v)) {
      h.least = any ? std::min(h.least, v) : v;
      h.greatest = any ? std::max(h.greatest, v) : v;
      any = true;
    }
  if (!any) return h;
  const auto place = [&](double v) { return logarithmic ? std::log10(v) : v; };
  const double first = place(h.least), range = place(h.greatest) - first;
  for (const float v : values)
    if (counts(v)) {
      const double t = range > 0 ? (place(v) - first) / range : 0;
      h.counts[static_cast<std::size_t>(std::min(static_cast<int>(t * bins), bins - 1))] += 1;
    }
  return h;
}

} // namespace volcaustic::viewer
