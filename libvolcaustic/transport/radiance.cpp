#include "volcaustic/photons.h"
#include "volume/radiance_bricks.h"

namespace volcaustic {

namespace {

using kernels::Int3;

bool isInside(const Domain& domain, const Vec3i& v) {
  bool inside = true;
  for (int a = 0; a < 3; ++a) inside = inside && v[a] >= 0 && v[a] < domain.dims[a];
  return inside;
}
Vec3f vec(const kernels::Float3& v) { return {v.x, v.y, v.z}; }

} // namespace

Vec3f RadianceVolume::causticFluence(const Vec3i& v) const {
  return isInside(mDomain, v) ? vec(mBricks->caustic.view().at(Int3(v[0], v[1], v[2])).fluence) : Vec3f{0, 0, 0};
}
Vec3f RadianceVolume::directFluence(const Vec3i& v) const {
  return isInside(mDomain, v) ? vec(mBricks->direct.view().at(Int3(v[0], v[1], v[2])).fluence) : Vec3f{0, 0, 0};
}
Vec3f RadianceVolume::fluence(const Vec3i& v) const {
  const Vec3f a = causticFluence(v), b = directFluence(v);
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Vec3f RadianceVolume::direction(const Vec3i& v) const {
  if (!isInside(mDomain, v)) return {0, 0, 0};
  kernels::Light light = mBricks->direct.view().at(Int3(v[0], v[1], v[2]));
  light += mBricks->caustic.view().at(Int3(v[0], v[1], v[2]));
  return vec(light.meanDirection());
}

} // namespace volcaustic
