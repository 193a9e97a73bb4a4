/// \file dense.h
/// Voxels of results as plain arrays, for hosts that have no OpenVDB.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/medium.h"
#include "volcaustic/photons.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// A grid that writeVdb writes.
struct GridSummary {
  std::string name;
  std::string unit;
  int components = 1; ///< 1 or 3
};
VOLCAUSTIC_API std::vector<GridSummary> gridsOf(const Medium& medium);
/// With the parts.
VOLCAUSTIC_API std::vector<GridSummary> gridsOf(const PhotonResult& photons);

/// A box of voxels of a domain: first, and how many.
struct VoxelBox {
  Vec3i first{0, 0, 0}, size{0, 0, 0};
};

/// Copies the values that writeVdb would write for the grid of this name: voxel (i, j, k) of the box at
/// out[((k * size[1] + j) * size[0] + i) * components]. Outside of the domain that is the grid's background.
/// \throws Error(Usage) for a name that is not there (the message has the nearest), a box without voxels, or where
/// `out` does not fit it.
VOLCAUSTIC_API void readVoxels(const Medium& medium, const std::string& grid, const VoxelBox& box, std::span<float> out,
                               const RunContext& ctx = {});
VOLCAUSTIC_API void readVoxels(const PhotonResult& photons, const Medium& medium, const std::string& grid,
                               const VoxelBox& box, std::span<float> out, const RunContext& ctx = {});

} // namespace volcaustic
