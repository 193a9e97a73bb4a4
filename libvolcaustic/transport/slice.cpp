#include "volcaustic/slice.h"

#include "backends/flat_storage.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <numbers>

namespace volcaustic {

namespace {

Vec3f scaled(const Vec3f& v, double factor) {
  const auto f = static_cast<float>(factor);
  return {v[0] * f, v[1] * f, v[2] * f};
}

Vec3f grey(float value) { return {value, value, value}; }

/// Edge of the cube that a step may cross, from the step field's byte.
float stepEdge(std::int32_t step, float cap) {
  const auto edge = static_cast<float>(1 << (step & kernels::kStepLevelMask));
  return step & kernels::kStepCappedBit ? std::min(edge, cap) : edge;
}

/// The value of a layer at a voxel.
Vec3f valueAt(VolumeLayer layer, const kernels::FlatMedium& medium, const RadianceVolume& light, const Vec3i& v,
              float cap) {
  constexpr double kPerSphere = 1 / (4 * std::numbers::pi);
  const kernels::Int3 voxel(v[0], v[1], v[2]);
  const double perWorld = 1 / light.domain().voxelSize;
  switch (layer) {
  case VolumeLayer::Radiance:
    return scaled(light.fluence(v), kPerSphere);
  case VolumeLayer::Caustic:
    return scaled(light.causticFluence(v), kPerSphere);
  case VolumeLayer::Direct:
    return scaled(light.directFluence(v), kPerSphere);
  case VolumeLayer::Direction:
    return light.direction(v);
  case VolumeLayer::Index:
    return grey(kernels::nearestField(medium, kernels::Float3(voxel) + kernels::Float3(.5f)).n);
  case VolumeLayer::Attenuation: {
    const kernels::Float3 a = medium.opticsAt(voxel).attenuation;
    return scaled({a.x, a.y, a.z}, perWorld);
  }
  case VolumeLayer::Step:
    return grey(stepEdge(medium.stepAt(voxel), cap));
  case VolumeLayer::Energy: {
    const kernels::Float3 a = medium.opticsAt(voxel).attenuation;
    const Vec3f f = light.fluence(v);
    return scaled({a.x * f[0], a.y * f[1], a.z * f[2]}, perWorld);
  }
  }
  return {};
}

} // namespace

VolumeSlice sliceVolume(const FlatMediumStorage& storage, const PhotonResult& photons, const SliceOptions& options) {
  if (options.axis < 0 || options.axis > 2) throw Error(ErrorKind::Usage, "slice: axis must be 0, 1 or 2");
  if (!(options.position >= 0 && options.position <= 1))
    throw Error(ErrorKind::Usage, "slice: position must be from 0 to 1");
  const Domain& domain = photons.radiance.domain();
  const kernels::FlatMedium medium = storage.view();
  if (!(domain.dims == Vec3i{medium.dims.x, medium.dims.y, medium.dims.z}))
    throw Error(ErrorKind::Usage,
                "slice: medium and light have other voxels than each other; take both from one session");
  const int across = options.axis, along = (across + 1) % 3, up = (across + 2) % 3;
  Vec3i v{};
  v[across] = std::min(static_cast<int>(options.position * domain.dims[across]), domain.dims[across] - 1);

  VolumeSlice slice;
  slice.columns = domain.dims[along];
  slice.rows = domain.dims[up];
  slice.values.reserve(static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows));
  for (v[up] = slice.rows - 1; v[up] >= 0; --v[up])
    for (v[along] = 0; v[along] < slice.columns; ++v[along])
      slice.values.push_back(valueAt(options.layer, medium, photons.radiance, v, storage.cap));
  slice.least = slice.greatest = slice.values.front()[0];
  for (const Vec3f& value : slice.values)
    for (const float x : value) {
      slice.least = std::min(slice.least, x);
      slice.greatest = std::max(slice.greatest, x);
    }
  for (int corner = 0; corner < 4; ++corner) {
    Vec3d& p = slice.corners[corner];
    p[across] = domain.minCorner[across] + (v[across] + .5) * domain.voxelSize;
    p[along] = corner == 1 || corner == 2 ? domain.maxCorner()[along] : domain.minCorner[along];
    p[up] = corner < 2 ? domain.maxCorner()[up] : domain.minCorner[up];
  }
  return slice;
}

} // namespace volcaustic
