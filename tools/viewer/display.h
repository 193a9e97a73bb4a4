// Numbers to what a screen shows: layers of a picture, slices of volumes, histograms.
#pragma once

#include <volcaustic/image.h>
#include <volcaustic/slice.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace volcaustic::viewer {

/// Bytes for a screen, sRGB, rows from the top.
struct Pixels {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

/// The layers of a picture, by the names of their channels before the dot: "picture" for R, G, B, A.
std::vector<std::string> layersOf(const Image& image);
/// A layer: light with an exposure in stops, depth and steps from black (least) to white (greatest).
Pixels displayed(const Image& image, const std::string& layer, double exposure);

struct SliceLook {
  double exposure = 0;      ///< stops, of light, over whiteOf() the slice
  bool colours = true;      ///< numbers as colours from blue (least) over green to red, else grey
  std::uint8_t alpha = 255; ///< of all
};
bool isLight(VolumeLayer layer);
/// Of light, what is shown as white at exposure 0: a fiftieth of the voxels that are lit have more; 1 in the dark.
float whiteOf(const VolumeSlice& slice);
Pixels displayed(const VolumeSlice& slice, VolumeLayer layer, const SliceLook& look);

/// From dark blue over green to yellow: t from 0 to 1, brighter for more (a cubic fit in the manner of viridis).
std::array<double, 3> colourOf(double t);

/// Counts of values, by decades for light: bins from least to greatest, both above 0; what is 0 is left out.
struct Histogram {
  std::vector<float> counts;
  float least = 0, greatest = 0;
  bool logarithmic = false;
};
Histogram histogramOf(const std::vector<float>& values, bool logarithmic, int bins = 96);

} // namespace volcaustic::viewer
