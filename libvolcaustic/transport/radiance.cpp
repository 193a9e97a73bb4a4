#include "volcaustic/photons.h"
#include "volume/radiance_bricks.h"

namespace volcaustic {

namespace {

Vec3f valueAt(const BrickGrid<Vec3f>& field, const Vec3i& v) {
  for (int a = 0; a < 3; ++a)
    if (v[a] < 0 || v[a] >= field.dims()[a]) return {0, 0, 0};
  return field.at(v[0], v[1], v[2]);
}

} // namespace

Vec3f RadianceVolume::causticFluence(const Vec3i& voxel) const { return valueAt(mBricks->caustic, voxel); }
Vec3f RadianceVolume::directFluence(const Vec3i& voxel) const { return valueAt(mBricks->direct, voxel); }
Vec3f RadianceVolume::direction(const Vec3i& voxel) const { return valueAt(mBricks->direction, voxel); }
Vec3f RadianceVolume::fluence(const Vec3i& voxel) const {
  const Vec3f a = causticFluence(voxel), b = directFluence(voxel);
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

} // namespace volcaustic
