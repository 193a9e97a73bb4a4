// Media that are built on the GPU.
#pragma once

#include "backends/cuda_medium.h"
#include "volume/voxelise.h"

#include <memory>
#include <optional>
#include <span>

namespace volcaustic {

kernels::PointOptics pointOptics(const Material& material);
kernels::PointOptics pointOptics(const Ambient& ambient);
MediumPlan planOf(const Domain& domain, const Ambient& ambient, std::span<const Body> bodies, int blur);
kernels::StepRules stepRules(const StepFieldOptions& options, const Domain& domain);
/// Of fractions of supersample^3 samples.
BodyCounts countsOf(const CoveragePatch& patch, int supersample);

/// The medium on the GPU that ctx.device means; `bodies` go from low priority to high. Null when the CPU is to build
/// it: ctx.device means it, or leaves it open and the meshes are small, or a GPU that it left open has failed, which is
/// warned of. \throws Error(Device) when a device asked for by name cannot be used or its memory does not do; as
/// buildMedium()
std::shared_ptr<const DeviceBricks> mediumOnDevice(std::span<const Body> bodies, const Ambient& ambient,
                                                   const Domain& domain, const VoxeliseOptions& options,
                                                   const RunContext& ctx);

/// flattenMedium() where the medium lies; nothing where that is not a GPU, where ctx.device means the CPU, or a GPU
/// that it left open has failed, which is warned of.
std::optional<FlatMediumStorage> flattenOnDevice(const Medium& medium, const StepFieldOptions& options,
                                                 const RunContext& ctx);

} // namespace volcaustic
