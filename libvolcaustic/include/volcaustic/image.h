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

/// Codecs of OpenEXR files. Dwaa, the only one that loses something (little), is for previews: it makes 16-bit floats
/// of everything but depth.
enum class ExrCompression { None, Zips, Zip, Piz, Dwaa };

/// How light becomes a display value in integer formats, before the sRGB curve.
enum class ToneCurve {
  Plain, ///< clamped to 0..1
  Aces,  ///< shoulder, toe and highlights that fade to white: S. Hill's fit of the ACES 1.0 reference rendering
};

struct ImageWriteOptions {
  /// Channels to write, by name or as "caustic.*"; empty takes all. Formats other than OpenEXR take R, G and B of the
  /// first layer among them, or a single channel as grey.
  std::vector<std::string> layers;
  // OpenEXR
  bool half = true; ///< 16-bit floats; depth and step counts stay 32-bit
  ExrCompression compression = ExrCompression::Zip;
  int tiles = 0; ///< edge of a tile in pixels, 8 to 4096; 0 writes scan lines
  // Other formats
  double exposure = 0;               ///< stops, in integer formats
  ToneCurve tone = ToneCurve::Plain; ///< in integer formats
  int bits = 0; ///< of a channel: 8, 16, 32 (linear floats); 0: 32 in .hdr, .pfm, .tif, .fits, else 8
  /// Alpha, and colours without the light of the background (layer `background`), to be laid over another picture. An
  /// image that has no such layer keeps its alpha in any case, where the format has one.
  bool alpha = false;
};

/// Writes by extension: .exr keeps the channels as they are; everything else that OpenImageIO writes gets a picture,
/// for the display (sRGB) in integer formats, of 8 bits with an ordered dither, so that gradients do not band. Written
/// beside the target and renamed when whole; the bytes depend on image and options only.
///
/// The metadata `worldToCamera` and `worldToNDC` (16 numbers each), `screenWindowWidth` and `pixelAspectRatio` become
/// OpenEXR's attributes of these names (cameraMetadata in view.h makes them), all others text. `software` and
/// `colorInteropID` are the writer's.
/// \throws Error(File), Error(Usage) for an extension nobody writes, layers that are not there or are no picture.
VOLCAUSTIC_API void writeImage(const std::filesystem::path& path, const Image& image,
                               const ImageWriteOptions& options = {}, const RunContext& ctx = {});

/// What writeImage to `path` would say of ImageWriteOptions::layers for an image of these channels.
/// \throws Error(Usage).
VOLCAUSTIC_API void checkLayers(const std::filesystem::path& path, const std::vector<std::string>& channels,
                                const std::vector<std::string>& layers);

/// Reads any image that OpenImageIO opens, every channel, as linear floats: integer formats are decoded from sRGB,
/// straight alpha is multiplied in, colours of other primaries (OpenEXR's `chromaticities`) are converted. The metadata
/// `colorInteropID` says what the file holds: kLinearColours or kDisplayColours.
/// Dimensions are checked against the context's memory limit before anything is allocated.
/// \throws Error(File), Error(Input).
VOLCAUSTIC_API Image readImage(const std::filesystem::path& path, const RunContext& ctx = {});

/// Names of the Color Interop Forum.
inline constexpr const char* kLinearColours = "lin_rec709_scene";
inline constexpr const char* kDisplayColours = "srgb_rec709_display";

/// Difference of one channel or grid that both sides have.
struct Difference {
  std::string name;
  double meanAbsolute = 0, rootMeanSquare = 0, maximum = 0;
  double meanOfA = 0, meanOfB = 0;
};
/// \throws Error(Input) when sizes or channel names differ.
VOLCAUSTIC_API std::vector<Difference> compareImages(const Image& a, const Image& b);

struct FlipOptions {
  double pixelsPerDegree = 67; ///< of visual angle: a 0.7 m wide display of 3840 pixels seen from 0.7 m
  /// Linear light of any brightness, compared at all exposures that the reference can be looked at; else display
  /// values, linear, 0 to 1, compared as they are.
  bool highDynamicRange = true;
};
struct FlipDifference {
  std::vector<float> map; ///< 0 (no difference is seen) to 1, one for each pixel
  double mean = 0, maximum = 0;
  std::vector<double> exposures; ///< stops that the map is the maximum over; empty for display values
};
/// How different two pictures look when one flips between them: contrast sensitivity of the eye, colours in a uniform
/// space, edges and points (Andersson et al., FLIP: A Difference Evaluator for Alternating Images, 2020; for high
/// dynamic range Andersson et al., Visualizing Errors in Rendered High Dynamic Range Images, 2021). Takes R, G and B,
/// or an only channel as grey; what is not finite on one side only differs by 1. \throws Error(Input) when sizes differ
/// or there is no colour, Error(Usage) for options out of range.
VOLCAUSTIC_API FlipDifference flipDifference(const Image& reference, const Image& test, const FlipOptions& options = {},
                                             const RunContext& ctx = {});
/// A map of differences, 0 to 1, as a picture: black, purple, red, yellow, white (the colours "magma").
VOLCAUSTIC_API Image differencePicture(int width, int height, const std::vector<float>& map);

} // namespace volcaustic
