/// \file medium_volume.h
/// Volumes made by others as a part of a medium: smoke, steam, hot air, glass of graded index.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/medium.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// What a grid made by others means: value = offset + scale * grid, channel by channel. A grid of numbers is a grey
/// one; of vectors, index, asymmetry and coverage take the length, in the first channel.
struct GridMapping {
  std::string grid;    ///< its name in the file
  Rgb scale{1, 1, 1};  ///< what one unit of the grid is
  Rgb offset{0, 0, 0}; ///< value where the grid is 0
};

enum class OpticalProperty { Index, Attenuation, Scattering, Asymmetry };

/// What one grid of a volume is in a medium.
struct PropertyGrid {
  OpticalProperty property = OpticalProperty::Attenuation;
  GridMapping mapping;
};

/// Grids of one file as they were read. Immutable.
class VolumeGrids;

/// Reads the named grids of a .vdb or .nvdb: numbers or vectors of any type, on any linear transforms.
/// \throws Error(File), Error(Input) naming the grids that the file does hold; for points, frustums, values that are
/// not finite.
VOLCAUSTIC_API std::shared_ptr<const VolumeGrids>
readVolumeGrids(const std::filesystem::path& path, const std::vector<std::string>& names, const RunContext& ctx = {});

/// Around the active voxels of all of them, in world space; nothing where there are none, as before the smoke begins.
VOLCAUSTIC_API std::optional<Box> bounds(const VolumeGrids& grids, const Affine& placement = kIdentity);

/// A volume made by others in world space, and what its grids are. A property that no grid is named for is the ambient
/// one, but that scattering without attenuation is taken for both.
struct MediumVolume {
  std::shared_ptr<const VolumeGrids> grids;
  std::vector<PropertyGrid> properties; ///< each property at most once
  Affine placement = kIdentity;         ///< of the file's world
  std::string name;                     ///< for messages
};

/// As buildMedium() of medium.h, with volumes in the ambient medium; bodies take their place as they take that of the
/// ambient medium (docs/algorithms/voxelise.md). Attenuation and scattering of volumes add to the ambient ones, of the
/// index their differences from the ambient one do, and the asymmetry is the mean of all, weighted by what scatters.
/// Grids are sampled trilinearly at the domain's voxels, means over several places where theirs are smaller; beyond
/// their voxels their background goes on. Attenuation, scattering and asymmetry are clamped to what they can be, with a
/// warning. \throws Error(Usage) for a mapping that cannot be, Error(Input) for an index beyond 0.1 to 10, for more
/// scattering than attenuation.
VOLCAUSTIC_API Medium buildMedium(std::span<const Body> bodies, std::span<const MediumVolume> volumes,
                                  const Ambient& ambient, const Domain& domain, const VoxeliseOptions& options = {},
                                  const RunContext& ctx = {});

} // namespace volcaustic
