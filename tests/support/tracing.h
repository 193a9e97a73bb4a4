// Photon passes of tests, in a cube of edge 1.
#pragma once

#include "support/fields.h"
#include "support/solids.h"
#include "volcaustic/photons.h"

#include <span>
#include <vector>

namespace volcaustic::test {

inline Body glassBall(const Vec3d& centre, double radius, double index) {
  Body b;
  b.mesh = ball(centre, radius);
  b.material.index = index;
  return b;
}

inline PhotonResult trace(const std::vector<Body>& bodies, const Ambient& ambient, int resolution, const Light& light,
                          PhotonOptions options = {}, const RunContext& ctx = {}, int photonsPerSide = 512) {
  options.grid = {photonsPerSide, photonsPerSide};
  options.smooth = false;
  return tracePhotons(buildMedium(bodies, ambient, unitCube(resolution), {}, ctx), std::span(&light, 1), {}, options,
                      ctx);
}

template <class Visit>
void forVoxels(const RadianceVolume& v, const Visit& visit) {
  const Vec3i d = v.domain().dims;
  for (int x = 0; x < d[0]; ++x)
    for (int y = 0; y < d[1]; ++y)
      for (int z = 0; z < d[2]; ++z) visit(Vec3i{x, y, z});
}

} // namespace volcaustic::test
