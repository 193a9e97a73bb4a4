// The camera pass: sets up the pinhole in grid space and the picture's layers, and has them filled
// (docs/algorithms/view.md).

#include "volcaustic/view.h"

#include "backends/cpu_view.h"
#include "backends/devices.h"
#include "core/parallel.h"
#include "transport/emission.h"
#include "transport/passes.h"
#include "volcaustic/error.h"
#include "volume/radiance_bricks.h"

#include <cmath>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::Float3;

constexpr double kDegree = 3.14159265358979323846 / 180;

Double3 vec(const Vec3d& v) { return {v[0], v[1], v[2]}; }
Float3 rgb(const Rgb& c) { return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])}; }

void check(const Camera& c, const ViewOptions& o) {
  if (c.resolution[0] < 1 || c.resolution[1] < 1 || c.resolution[0] > 32768 || c.resolution[1] > 32768)
    throw Error(ErrorKind::Usage, "camera.resolution: width and height must be from 1 to 32768 pixels");
  if (!(c.fieldOfView > 0 && c.fieldOfView < 180))
    throw Error(ErrorKind::Usage, "camera.fieldOfView: must be above 0 and below 180 degrees");
  const Double3 forward = vec(c.target) - vec(c.position);
  if (!(kernels::length(forward) > 0))
    throw Error(ErrorKind::Usage, "camera.target: is the camera's position; look somewhere else");
  if (!(kernels::length(kernels::cross(forward, vec(c.up))) > 1e-9 * kernels::length(forward)))
    throw Error(ErrorKind::Usage, "camera.up: is parallel to the viewing direction; choose another");
  if (!(o.step > 0)) throw Error(ErrorKind::Usage, "view.step: must be above 0");
  if (o.samples < 1 || o.samples > 16) throw Error(ErrorKind::Usage, "view.samples: must be from 1 to 16");
  if (o.maxSteps < 1) throw Error(ErrorKind::Usage, "view.maxSteps: must be at least 1");
}

kernels::CameraFrame cameraFrame(const Camera& c, const Domain& domain) {
  const Double3 forward = kernels::normalize(vec(c.target) - vec(c.position));
  const Double3 right = kernels::normalize(kernels::cross(forward, vec(c.up)));
  const Double3 up = kernels::cross(right, forward);
  const double halfHeight = std::tan(0.5 * c.fieldOfView * kDegree);
  const double halfWidth = halfHeight * c.resolution[0] / c.resolution[1];
  return {toGrid(domain, c.position),
          forward - right * halfWidth + up * halfHeight,
          right * (2 * halfWidth),
          up * (-2 * halfHeight),
          c.resolution[0],
          c.resolution[1]};
}

kernels::ViewRules viewRules(const Camera& c, const Background& b, const ViewOptions& o, double cameraIndex,
                             double ambientIndex) {
  kernels::ViewRules r;
  r.step = static_cast<float>(o.step);
  r.samples = o.samples;
  r.maxSteps = o.maxSteps;
  r.cameraIndex = static_cast<float>(cameraIndex);
  r.ambientIndex = static_cast<float>(ambientIndex);
  r.up = Float3(kernels::normalize(vec(c.up)));
  r.top = rgb(b.top);
  r.bottom = rgb(b.bottom);
  return r;
}

/// A picture of kernels::PixelPlanes' planes, all zero; most of what that costs is memory's first touch.
Image emptyImage(const Camera& camera, const RunContext& ctx) {
  Image image;
  image.width = camera.resolution[0];
  image.height = camera.resolution[1];
  image.channels = {"R", "G", "B", "A"};
  for (const char* layer : {"caustic", "direct", "background", "transmittance"})
    for (const char* channel : {".R", ".G", ".B"}) image.channels.push_back(std::string(layer) + channel);
  image.channels.insert(image.channels.end(), {"depth.Z", "steps.Y"});
  image.planes.resize(image.channels.size());
  parallelFor(static_cast<std::int64_t>(image.planes.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      image.planes[i].resize(static_cast<std::size_t>(image.width) * image.height);
  });
  return image;
}

kernels::PixelPlanes planesOf(Image& image, double voxelSize) {
  kernels::PixelPlanes planes;
  for (int i = 0; i < kernels::kPixelPlanes; ++i) planes.of[i] = image.planes[i].data();
  planes.voxelSize = static_cast<float>(voxelSize);
  return planes;
}

} // namespace

ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const RadianceVolume& radiance,
                      const Camera& camera, const Background& background, const ViewOptions& options,
                      const RunContext& ctx) {
  check(camera, options);
  ctx.requireMemory(std::uint64_t{kernels::kPixelPlanes} * camera.resolution[0] * camera.resolution[1] * sizeof(float),
                    "camera.resolution");
  const LaneSet& lanes = laneSet(parseDevice(ctx.device).lanes);
  const kernels::CameraFrame frame = cameraFrame(camera, medium.domain());
  const double ambient = medium.ambient().index;
  const Float3 eye(frame.origin);
  const double cameraIndex = kernels::insideBox(flat.dims, eye) ? kernels::sampleField(flat.view(), eye).n : ambient;
  const RadianceBricks& light = radiance.bricks();
  const kernels::ViewScene scene{flat.view(), light.direct.view(), light.caustic.view(), frame,
                                 viewRules(camera, background, options, cameraIndex, ambient)};

  ViewResult result;
  result.image = emptyImage(camera, ctx);
  const ViewCounts counts = viewOnCpu(scene, planesOf(result.image, medium.domain().voxelSize), lanes, ctx);
  result.steps = counts.steps;
  result.raysNotFinite = counts.notFinite;
  result.raysAtStepLimit = counts.stepLimit;
  return result;
}

ViewResult renderView(const Medium& medium, const RadianceVolume& radiance, const Camera& camera,
                      const Background& background, const StepFieldOptions& stepField, const ViewOptions& options,
                      const RunContext& ctx) {
  return renderView(medium, flattenMedium(medium, stepField, ctx), radiance, camera, background, options, ctx);
}

} // namespace volcaustic
