/// \file image.h
/// Images of named float channels, their files, and how two of them differ.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/run_context.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace volcaustic {

/// Scene-linear Rec. 709 pixels, one plane for each channel, rows from the top, width*height floats a plane.
struct Image {
  int width = 0, height = 0;
  std::vector<std::string> channels;      ///< e.g. "R", "caustic.R", "depth.Z"
  std::vector<std::vector<float>> planes; ///< one for each channel
  std::map<std::string, std::string> metadata;

  /// The plane's index, or -1.
  [[nodiscard]] int find(std::string_view channel) const;
  /// Adds a zeroed channel and returns its plane.
  std::vector<float>& add(std::string name);
};

struct ImageWriteOptions {
  bool half = true;    ///< 16-bit floats in OpenEXR files; depth and step counts stay 32-bit
  double exposure = 0; ///< stops, applied to 8- and 16-bit integer formats only
};

/// Writes by extension: .exr keeps every channel (OpenEXR); everything else that OpenImageIO writes gets R, G and B,
/// sRGB-encoded for integer formats. Written beside the target and renamed when whole.
/// \throws Error(File), Error(Usage) for an extension nobody writes.
VOLCAUSTIC_API void writeImage(const std::filesystem::path& path, const Image& image,
                               const ImageWriteOptions& options = {}, const RunContext& ctx = {});

/// Reads any image that OpenImageIO opens, every channel, as floats; integer formats are decoded from sRGB.
/// Dimensions are checked against the context's memory limit before anything is allocated.
/// \throws Error(File), Error(Input).
VOLCAUSTIC_API Image readImage(const std::filesystem::path& path, const RunContext& ctx = {});

/// Difference of one channel or grid that both sides have.
struct Difference {
  std::string name;
  double meanAbsolute = 0, rootMeanSquare = 0, maximum = 0;
  double meanOfA = 0, meanOfB = 0;
};
/// \throws Error(Input) when sizes or channel names differ.
VOLCAUSTIC_API std::vector<Difference> compareImages(const Image& a, const Image& b);

} // namespace volcaustic
