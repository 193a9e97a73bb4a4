// The camera pass: sets up the pinhole in grid space and the picture's layers, and has them filled
// (docs/algorithms/view.md).

#include "volcaustic/view.h"

#include "backends/devices.h"
#include "backends/view_tracer.h"
#include "transport/emission.h"
#include "transport/environment.h"
#include "transport/lit_receivers.h"
#include "transport/passes.h"
#include "transport/picture.h"
#include "transport/pixel_sampler.h"
#include "volcaustic/error.h"
#include "volume/radiance_bricks.h"

#include <cmath>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::Float3;

constexpr double kDegree = 3.14159265358979323846 / 180;

Double3 vec(const Vec3d& v) { return {v[0], v[1], v[2]}; }

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
  if (!(o.noise >= 0 && o.noise <= 1)) throw Error(ErrorKind::Usage, "view.noise: must be from 0 to 1");
  if (o.maxSteps < 1) throw Error(ErrorKind::Usage, "view.maxSteps: must be at least 1");
}

bool sameLattice(const Domain& a, const Domain& b) {
  return a.minCorner == b.minCorner && a.voxelSize == b.voxelSize && a.dims == b.dims;
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

kernels::ViewRules viewRules(const Background& b, const ViewOptions& o, double cameraIndex, double ambientIndex) {
  kernels::ViewRules r;
  r.step = static_cast<float>(o.step);
  r.maxSteps = o.maxSteps;
  r.fresnel = o.fresnel;
  r.cameraIndex = static_cast<float>(cameraIndex);
  r.ambientIndex = static_cast<float>(ambientIndex);
  if (b.visible) r.background = environmentOf(b, "background");
  return r;
}

/// The machine that RunContext::device names. Of two, the GPU: a picture takes it a fraction of what the CPU's share
/// of it would. `there` is the medium where it was built, if that was a GPU.
std::unique_ptr<ViewTracer> makeViewer(const kernels::ViewScene& scene, const ViewTables& tables,
                                       const std::shared_ptr<const DeviceFlatMedium>& there,
                                       const kernels::PixelPlanes& planes, const RunContext& ctx) {
  RunContext silent = ctx; // the photon pass has told what "auto" chose
  silent.onLog = {};
  const DeviceChoice choice = chooseDevice(silent);
  if (choice.cudaOrdinal < 0) return makeCpuViewer(scene, planes, laneSet(choice.lanes), ctx);
  try {
    return makeCudaViewer(scene, tables, there, planes, ctx, choice.cudaOrdinal);
  } catch (const Error& e) {
    if (!choice.mayFallBack || e.kind() != ErrorKind::Device) throw;
    ctx.warn(std::string(e.what()) + "; going on with the CPU");
    return makeCpuViewer(scene, planes, laneSet(choice.lanes), ctx);
  }
}

} // namespace

ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const RadianceVolume& radiance,
                      const LitReceivers& receivers, const Camera& camera, const Background& background,
                      const ViewOptions& options, const RunContext& ctx, const ViewObserver& observer) {
  check(camera, options);
  if (!radiance || !sameLattice(radiance.domain(), medium.domain()))
    throw Error(ErrorKind::Usage, "view: the light is of another domain than the medium; trace it in this one");
  const LaneSet& lanes = laneSet(parseDevice(ctx.device).lanes);
  Picture picture(camera, options, medium.domain().voxelSize, ctx);
  const double ambient = medium.ambient().index;
  const kernels::CameraFrame frame = cameraFrame(camera, medium.domain());
  const Float3 eye(frame.origin);
  const double cameraIndex = kernels::insideBox(flat.dims, eye) ? kernels::sampleField(flat.view(), eye).n : ambient;
  const RadianceBricks& light = radiance.bricks();
  const ViewTables tables(flat.view(), light.caustic.view(), light.direct.view(), lanes, ctx);
  const kernels::ViewScene scene{flat.view(),
                                 tables.light(),
                                 tables.plan(),
                                 receivers ? receivers.data().scene() : kernels::ReceiverScene{},
                                 frame,
                                 viewRules(background, options, cameraIndex, ambient),
                                 pixelSampler(options.filter, options.samples, ctx.seed)};
  return picture.render(*makeViewer(scene, tables, flat.onDevice, picture.planes(), ctx), observer);
}

ViewResult renderView(const Medium& medium, const RadianceVolume& radiance, const Camera& camera,
                      const Background& background, const StepFieldOptions& stepField, const ViewOptions& options,
                      const RunContext& ctx, const ViewObserver& observer, const LitReceivers& receivers) {
  return renderView(medium, flattenMedium(medium, stepField, ctx), radiance, receivers, camera, background, options,
                    ctx, observer);
}

} // namespace volcaustic
