// The last form of a medium: arrays that the kernels read, on this machine and perhaps on another.
#pragma once

#include "core/large_memory.h"
#include "core/zeroed_table.h"
#include "kernels/flat_medium.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace volcaustic {

/// The same arrays in the memory of a CUDA device, made there.
class DeviceFlatMedium {
public:
  virtual ~DeviceFlatMedium() = default;
  [[nodiscard]] virtual int ordinal() const = 0;
  /// Pointers of the device; good while this lives.
  [[nodiscard]] virtual const kernels::FlatMedium& view() const = 0;
};

/// Owns what kernels::FlatMedium points at.
struct FlatMediumStorage {
  kernels::Int3 dims, brickDims;
  ZeroedTable<std::int32_t> fieldSlots, stepSlots, opticsSlots;
  ZeroedTable<float> indexOffsets;
  ZeroedTable<std::uint8_t> bends;
  LargeVector<kernels::FieldVoxel> fields;
  LargeVector<std::uint8_t> steps;
  LargeVector<std::int32_t> voxelOptics;
  std::vector<kernels::Optics> optics;
  float ambientIndex = 1;
  std::int32_t ambientStep = 0;
  float cap = 2;
  bool attenuates = false;
  std::shared_ptr<const DeviceFlatMedium> onDevice; ///< where the medium was built; null on the CPU

  FlatMediumStorage() = default;
  /// Tables of zeros.
  FlatMediumStorage(const kernels::Int3& dims, const kernels::Int3& brickDims);

  [[nodiscard]] kernels::FlatMedium view() const;
  /// Of the arrays on this machine; pages of the tables that nothing was written to count too.
  [[nodiscard]] std::size_t memoryBytes() const;
};

/// The greatest number of slots that kernels can address: with 32 bits, floats of a field voxel too.
inline constexpr std::int64_t kMostFieldSlots = 0x7fffffff / (4 * kernels::kFieldVoxels);
/// \throws Error(Input) for more.
void requireFieldSlots(std::int64_t count);

/// Whether attenuation differs by so much that some step may have to be shorter for it.
bool attenuationMatters(std::span<const kernels::Optics> palette, double tolerance);

} // namespace volcaustic
