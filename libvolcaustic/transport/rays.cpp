// Rays without light: where the kernels carry them.

#include "core/parallel.h"
#include "kernels/march.h"
#include "transport/emission.h"
#include "transport/march_rules.h"
#include "volcaustic/error.h"
#include "volcaustic/photons.h"
#include "volume/flatten.h"

#include <string>

namespace volcaustic {

namespace {

using kernels::Float3;

void traceRay(TracedRay& ray, const kernels::FlatMedium& medium, const kernels::MarchRules& rules, const Domain& domain,
              int maxSteps) {
  kernels::Ray r{Float3(toGrid(domain, ray.position)),
                 kernels::normalize(Float3(static_cast<float>(ray.direction[0]), static_cast<float>(ray.direction[1]),
                                           static_cast<float>(ray.direction[2])))};
  r.v *= kernels::sampleField(medium, r.x).n;
  const double limit = ray.length > 0 ? ray.length / domain.voxelSize : 1e300;
  double length = 0;
  ray.left = false;
  for (ray.steps = 0; ray.steps < maxSteps && !ray.left && length < limit; ++ray.steps) {
    const kernels::Int3 voxel = medium.voxelOf(r.x);
    const Float3 towards = kernels::normalize(r.v);
    float ds = kernels::stepLength(medium, rules, r.x, towards, voxel, medium.stepAt(voxel));
    ds = static_cast<float>(kernels::smaller<double>(ds, limit - length));
    const kernels::StepResult<float> step = kernels::advanceInBox(medium, rules, r, towards, ds);
    // Half the step is drifted at the old speed, half at the new one.
    length += 0.5 * step.ds * (1 + kernels::length(step.ray.v) / kernels::length(r.v));
    r = step.ray;
    ray.left = step.leaves;
  }
  const double h = domain.voxelSize;
  const Float3 d = kernels::normalize(r.v);
  ray.position = {domain.minCorner[0] + h * r.x.x, domain.minCorner[1] + h * r.x.y, domain.minCorner[2] + h * r.x.z};
  ray.direction = {d.x, d.y, d.z};
  ray.opticalMomentum = kernels::length(r.v);
  ray.length = length * h;
}

} // namespace

void traceRays(const Medium& medium, std::span<TracedRay> rays, const StepFieldOptions& stepField,
               const PhotonOptions& options, const RunContext& ctx) {
  const FlatMediumStorage flat = flattenMedium(medium, stepField, ctx);
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (!kernels::insideBox(flat.dims, Float3(toGrid(medium.domain(), rays[i].position))))
      throw Error(ErrorKind::Usage, "rays[" + std::to_string(i) + "]: starts outside the domain's box");
  parallelFor(static_cast<std::int64_t>(rays.size()), 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      traceRay(rays[i], flat.view(), marchRules(options), medium.domain(), options.maxSteps);
  });
}

} // namespace volcaustic
