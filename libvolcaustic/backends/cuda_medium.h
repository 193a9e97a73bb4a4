// A medium that is built, and stays, in the memory of a CUDA device (docs/algorithms/cuda.md, "The medium"). Names no
// CUDA type.
#pragma once

#include "backends/flat_storage.h"
#include "backends/medium_plan.h"
#include "backends/optics_bricks.h"
#include "volcaustic/run_context.h"

#include <memory>

namespace volcaustic {

/// Bodies painted into the ambient medium and smoothed, on a device.
class DeviceBricks {
public:
  virtual ~DeviceBricks() = default;
  /// The grids, on the host. \throws Error(Input) beyond the memory limit; Error(Device).
  [[nodiscard]] virtual OpticsBricks download(const RunContext& ctx) const = 0;
  /// The arrays that the kernels read, on the device and on the host: the bits that the CPU makes, but for the order of
  /// the palette. \throws as download()
  [[nodiscard]] virtual FlatMediumStorage flatten(const kernels::StepRules& rules, float cap,
                                                  const RunContext& ctx) const = 0;
};

/// Takes bodies from low priority to high.
class DeviceMediumBuilder {
public:
  virtual ~DeviceMediumBuilder() = default;
  /// Voxelises a closed mesh there; its lattice begins at the domain's brick `first`. \return whether any sample of it
  /// is inside \throws Error(Device)
  virtual bool add(const CountTask& mesh, const Vec3i& first, const kernels::PointOptics& optics,
                   const RunContext& ctx) = 0;
  /// A body that was voxelised on the host.
  virtual void add(const BodyCounts& counts, const kernels::PointOptics& optics) = 0;
  /// \throws Error(Device), Error(Input) for a medium that kernels cannot address
  [[nodiscard]] virtual std::shared_ptr<const DeviceBricks> finish(const MediumPlan& plan) = 0;
};

/// \throws Error(Device) when the device cannot be used
std::unique_ptr<DeviceMediumBuilder> makeCudaMediumBuilder(std::uint64_t memoryLimit, int ordinal);

} // namespace volcaustic
