// The camera pass: sets up the pinhole in grid space, runs one body a pixel, sorts the sums into layers
// (docs/algorithms/view.md).

#include "volcaustic/view.h"

#include "backends/cpu.h"
#include "kernels/view.h"
#include "transport/emission.h"
#include "transport/passes.h"
#include "volcaustic/error.h"
#include "volume/radiance_bricks.h"

#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::Float3;

constexpr std::int64_t kPixelGrain = 256;
constexpr double kDegree = 3.14159265358979323846 / 180;

/// The view pass deposits nothing; it counts.
struct CountingSink {
  std::array<std::int64_t, static_cast<int>(kernels::Counter::Count)> counts{};
  void count(kernels::Counter c, std::int64_t n) { counts[static_cast<int>(c)] += n; }
};

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

kernels::SparseField sparseField(const BrickGrid<Vec3f>& g) {
  const auto floats = [](std::span<const Vec3f> s) { return s.empty() ? nullptr : s.data()->data(); };
  return {{g.dims()[0], g.dims()[1], g.dims()[2]},
          {g.brickDims()[0], g.brickDims()[1], g.brickDims()[2]},
          g.slots().data(),
          floats(g.constants()),
          floats(g.storage())};
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

/// Writes a colour into the planes NAME.R, NAME.G and NAME.B.
class Layer {
public:
  Layer(Image& image, const std::string& prefix) : mFirst(image.channels.size()), mImage(image) {
    for (const char* c : {"R", "G", "B"}) image.add(prefix + c);
  }
  void set(std::size_t pixel, const Float3& v) {
    for (int c = 0; c < 3; ++c) mImage.planes[mFirst + c][pixel] = v[c];
  }

private:
  std::size_t mFirst;
  Image& mImage;
};

Image toImage(std::span<const kernels::PixelSum> pixels, const Camera& camera, double voxelSize) {
  Image image;
  image.width = camera.resolution[0];
  image.height = camera.resolution[1];
  Layer beauty(image, "");
  const std::size_t alpha = image.channels.size();
  image.add("A");
  Layer caustic(image, "caustic."), direct(image, "direct."), background(image, "background."),
      transmittance(image, "transmittance.");
  const std::size_t depth = image.channels.size();
  image.add("depth.Z");
  image.add("steps.Y");
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const kernels::PixelSum& p = pixels[i];
    beauty.set(i, p.caustic + p.direct + p.background);
    image.planes[alpha][i] = 1 - (p.transmittance.x + p.transmittance.y + p.transmittance.z) / 3;
    caustic.set(i, p.caustic);
    direct.set(i, p.direct);
    background.set(i, p.background);
    transmittance.set(i, p.transmittance);
    image.planes[depth][i] =
        p.depth < 1e38f ? p.depth * static_cast<float>(voxelSize) : std::numeric_limits<float>::infinity();
    image.planes[depth + 1][i] = p.steps;
  }
  return image;
}

} // namespace

ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const RadianceVolume& radiance,
                      const Camera& camera, const Background& background, const ViewOptions& options,
                      const RunContext& ctx) {
  check(camera, options);
  const std::int64_t count = std::int64_t{camera.resolution[0]} * camera.resolution[1];
  ctx.requireMemory(static_cast<std::uint64_t>(count) * (sizeof(kernels::PixelSum) + 18 * sizeof(float)),
                    "camera.resolution");
  const kernels::CameraFrame frame = cameraFrame(camera, medium.domain());
  const double ambient = medium.ambient().index;
  const Float3 eye(frame.origin);
  const double cameraIndex = kernels::insideBox(flat.dims, eye) ? kernels::sampleField(flat.view(), eye).n : ambient;

  std::vector<kernels::PixelSum> pixels(count);
  std::vector<CountingSink> sinks(threadCount(ctx));
  const RadianceBricks& light = radiance.bricks();
  const kernels::ViewBody<CountingSink> body{flat.view(),
                                             sparseField(light.direct),
                                             sparseField(light.caustic),
                                             sparseField(light.direction),
                                             frame,
                                             viewRules(camera, background, options, cameraIndex, ambient),
                                             pixels.data()};
  launchCpu(count, kPixelGrain, ctx, "view", body, std::span(sinks));

  ViewResult result;
  result.image = toImage(pixels, camera, medium.domain().voxelSize);
  for (const CountingSink& s : sinks) {
    result.steps += s.counts[static_cast<int>(kernels::Counter::Steps)];
    result.raysNotFinite += s.counts[static_cast<int>(kernels::Counter::NotFinite)];
    result.raysAtStepLimit += s.counts[static_cast<int>(kernels::Counter::StepLimit)];
  }
  return result;
}

ViewResult renderView(const Medium& medium, const RadianceVolume& radiance, const Camera& camera,
                      const Background& background, const StepFieldOptions& stepField, const ViewOptions& options,
                      const RunContext& ctx) {
  return renderView(medium, flattenMedium(medium, stepField, ctx), radiance, camera, background, options, ctx);
}

} // namespace volcaustic
