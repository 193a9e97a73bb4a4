/// \file view.h
/// The camera pass: curved rays through the medium, gathering the light that the photons left.
#pragma once

#include "volcaustic/background.h"
#include "volcaustic/export.h"
#include "volcaustic/image.h"
#include "volcaustic/medium.h"
#include "volcaustic/photons.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace volcaustic {

struct Camera {
  Vec3d position{0, -4, 1}; ///< world space
  Vec3d target{0, 0, 0};    ///< looked at, world space
  Vec3d up{0, 0, 1};
  double fieldOfView = 40;                  ///< vertical, degrees
  std::array<int, 2> resolution{1024, 768}; ///< pixels
};

/// Image::metadata that says where a picture was taken from, in OpenEXR's terms: `worldToCamera` and `worldToNDC` (16
/// numbers by rows; points are rows, x right, y up, z forward), `screenWindowWidth` (at distance 1).
VOLCAUSTIC_API std::map<std::string, std::string> cameraMetadata(const Camera& camera);

/// What weighs the samples of a pixel; each reaches as far from its centre as it says.
enum class PixelFilter {
  Box,            ///< 0.5 pixels: the pixel's own square
  Tent,           ///< 1 pixel
  Gaussian,       ///< 1.5 pixels, deviation 0.5
  BlackmanHarris, ///< 1.5 pixels
};

struct ViewOptions {
  double step = 1; ///< step where the medium bends or scatters, in voxels
  int samples = 1; ///< rays for each pixel along one axis: samples^2 in all
  PixelFilter filter = PixelFilter::Gaussian;
  /// Tiles of the picture are finished when the standard error of their pixels is below this part of their mean
  /// luminance; 0 takes all samples everywhere.
  double noise = 0;
  int maxSteps = 20000;
  bool fresnel = false; ///< split rays where the index changes within a few voxels, as PhotonOptions::fresnel
  double exposure = 0;  ///< stops, for tone-mapped files
};

struct ViewResult {
  Image image; ///< R G B A, caustic.*, direct.*, background.*, receiver.*, transmittance.*, depth.Z, steps.Y
  std::int64_t steps = 0;
  std::int64_t raysNotFinite = 0;
  std::int64_t raysAtStepLimit = 0;
  std::int64_t samples = 0; ///< rays from the camera
  int passes = 0;
};

/// Is handed the picture after each pass, the first of which has one sample a pixel, each other one as many as all
/// before it. Called on the thread that renders.
using ViewObserver = std::function<void(const ViewResult& soFar)>;

/// Renders what the camera sees: single scattering of the radiance volume (Henyey-Greenstein with asymmetry g|d| about
/// the mean direction d) along rays bent by the medium, over the background. Along a ray L/n^2 is what stays constant,
/// so light scattered at index n reaches a camera at index n_c multiplied by (n_c/n)^2. A background's map must be read
/// already (readEnvironment). \throws Error(Usage) for a camera, background or options out of range, Error(Cancelled).
VOLCAUSTIC_API ViewResult renderView(const Medium& medium, const RadianceVolume& radiance, const Camera& camera,
                                     const Background& background = {}, const StepFieldOptions& stepField = {},
                                     const ViewOptions& options = {}, const RunContext& ctx = {},
                                     const ViewObserver& observer = {}, const LitReceivers& receivers = {});

} // namespace volcaustic
