#include "backends/flat_storage.h"

#include "volcaustic/error.h"

#include <string>

namespace volcaustic {

FlatMediumStorage::FlatMediumStorage(const kernels::Int3& d, const kernels::Int3& bricks) : dims(d), brickDims(bricks) {
  const auto count = static_cast<std::size_t>(bricks.x) * bricks.y * bricks.z;
  fieldSlots = ZeroedTable<std::int32_t>(count);
  stepSlots = ZeroedTable<std::int32_t>(count);
  opticsSlots = ZeroedTable<std::int32_t>(count);
  indexOffsets = ZeroedTable<float>(count);
  bends = ZeroedTable<std::uint8_t>(count);
}

kernels::FlatMedium FlatMediumStorage::view() const {
  kernels::FlatMedium m;
  m.dims = dims;
  m.brickDims = brickDims;
  m.fieldSlots = fieldSlots.data();
  m.indexOffsets = indexOffsets.data();
  m.stepSlots = stepSlots.data();
  m.opticsSlots = opticsSlots.data();
  m.bends = bends.data();
  m.fields = fields.data();
  m.steps = steps.data();
  m.voxelOptics = voxelOptics.data();
  m.optics = optics.data();
  m.ambientIndex = ambientIndex;
  m.ambientStep = ambientStep;
  m.cap = cap;
  m.attenuates = attenuates;
  m.fieldCount = static_cast<std::int64_t>(fields.size());
  m.stepCount = static_cast<std::int64_t>(steps.size());
  m.voxelOpticsCount = static_cast<std::int64_t>(voxelOptics.size());
  m.opticsCount = static_cast<std::int64_t>(optics.size());
  return m;
}

std::size_t FlatMediumStorage::memoryBytes() const {
  return fieldSlots.size() * (3 * sizeof(std::int32_t) + sizeof(float) + sizeof(std::uint8_t)) +
         fields.size() * sizeof(kernels::FieldVoxel) + steps.size() + voxelOptics.size() * sizeof(std::int32_t) +
         optics.size() * sizeof(kernels::Optics);
}

void requireFieldSlots(std::int64_t count) {
  if (count >= kMostFieldSlots)
    throw Error(ErrorKind::Input, "volume: light bends in more than " + std::to_string(kMostFieldSlots) +
                                      " bricks of 8x8x8 voxels; lower the resolution");
}

bool attenuationMatters(std::span<const kernels::Optics> palette, double tolerance) {
  kernels::Float3 low = palette[0].attenuation, high = low; // a voxel
  for (const kernels::Optics& o : palette) {
    const kernels::Float3& a = o.attenuation;
    low = {kernels::smaller(low.x, a.x), kernels::smaller(low.y, a.y), kernels::smaller(low.z, a.z)};
    high = {kernels::larger(high.x, a.x), kernels::larger(high.y, a.y), kernels::larger(high.z, a.z)};
  }
  // The labels compare numbers that were rounded otherwise; when in doubt, it matters.
  return kernels::maxComponent(high - low) > 0.999 * tolerance;
}

} // namespace volcaustic
