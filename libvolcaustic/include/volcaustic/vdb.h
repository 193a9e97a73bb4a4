/// \file vdb.h
/// OpenVDB and NanoVDB files in and out, without naming OpenVDB: docs/formats.md lists grids, types and metadata.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/image.h"
#include "volcaustic/medium.h"
#include "volcaustic/medium_volume.h"
#include "volcaustic/photons.h"
#include "volcaustic/run_context.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic {

/// Who will open a file of light: it holds the grids that the program uses, in 16 bits where those do (docs/hosts.md).
enum class HostPreset { None, Blender, Houdini, Arnold, Unreal, Renderman };

struct VdbWriteOptions {
  HostPreset preset = HostPreset::None;
  bool half = false;   ///< 16-bit floats in the file
  bool parts = false;  ///< also `caustic` and `direct` (radiance volumes)
  double exposure = 0; ///< stops: radiance, caustic, direct and emission are multiplied by 2^exposure; recorded
  std::map<std::string, std::string> metadata; ///< added to the file's metadata, e.g. scene hash, frame, seed
};

/// Writes index, attenuation, scattering, coverage, and asymmetry where it varies. .vdb or .nvdb by extension; "-" is
/// standard output (.vdb). Written beside the target and renamed when whole.
VOLCAUSTIC_API void writeVdb(const std::filesystem::path& path, const Medium& medium,
                             const VdbWriteOptions& options = {}, const RunContext& ctx = {});
/// Writes radiance, direction, emission and density (the last two need the medium's scattering and attenuation), and
/// the two parts when asked for.
VOLCAUSTIC_API void writeVdb(const std::filesystem::path& path, const RadianceVolume& radiance, const Medium& medium,
                             const VdbWriteOptions& options = {}, const RunContext& ctx = {});

/// The same of a photon pass: where its lights were traced one by one, also radiance_NAME of each (lightLayers), and
/// with the parts caustic_NAME and direct_NAME.
VOLCAUSTIC_API void writeVdb(const std::filesystem::path& path, const PhotonResult& photons, const Medium& medium,
                             const VdbWriteOptions& options = {}, const RunContext& ctx = {});

/// Reads a medium: `index` (any float grid of that name), and attenuation, scattering, asymmetry, coverage where
/// present. The domain is the box of the file's own metadata, else the active voxels of `index`.
VOLCAUSTIC_API Medium readMedium(const std::filesystem::path& path, const RunContext& ctx = {});
/// Reads `radiance` and `direction` (and the parts, where present) as written by writeVdb onto a given domain.
VOLCAUSTIC_API RadianceVolume readRadiance(const std::filesystem::path& path, const Domain& domain,
                                           const RunContext& ctx = {});

/// Which grids of a file become a medium. What no grid is named for is the ambient value everywhere; scattering without
/// attenuation is taken for both.
struct MediumImport {
  std::optional<GridMapping> index, attenuation, scattering, asymmetry, coverage;
  /// A grid that is a body: a level set, or the solid fraction of a fog volume. It gives the coverage, and every
  /// property that has no grid of its own goes from the ambient value to the material's, the index smoothed.
  std::optional<std::string> body;
  Material material;
  Ambient ambient;      ///< where a grid is mapped, offset + scale * its background takes the place of this
  double voxelSize = 0; ///< world units; 0 takes the smallest edge of the mapped grids' voxels
  int padding = 2;      ///< voxels around the active ones
  int blur = 9;         ///< width of the Gaussian on a body's index: 1 (none), 3, 5, 7, 9 or 11
};

/// A medium from the grids of any .vdb or .nvdb: numbers or vectors of any type, on any linear transforms. The lattice
/// is that of the finest mapped grid where its voxels are upright cubes, else one of cubes; grids that do not lie on it
/// are resampled, trilinearly (the context is told). The box is that of all active voxels. Attenuation, scattering and
/// coverage are clamped to what they can be, with a warning.
/// \throws Error(Usage) for a mapping that cannot be, Error(Input) naming the grids that the file does hold; for
/// points, frustums, values that are not finite, an index that is not above zero, more scattering than attenuation.
VOLCAUSTIC_API Medium importMedium(const std::filesystem::path& path, const MediumImport& import,
                                   const RunContext& ctx = {});

struct GridInfo {
  std::string name, type, gridClass, vectorType;
  std::uint64_t activeVoxels = 0, leafNodes = 0, activeTiles = 0, memoryBytes = 0;
  Vec3i indexMin{0, 0, 0}, indexMax{0, 0, 0}; ///< active voxels, inclusive
  Box world;                                  ///< the same in world space, voxel faces
  Vec3d voxelSize{1, 1, 1};
  double minimum = 0, maximum = 0, mean = 0; ///< over active values; of the length for vectors
  std::map<std::string, std::string> metadata;
  bool mirrored = false; ///< the grid's axes are a mirror image of the world's: a left-handed transform
};
struct VdbInfo {
  std::vector<GridInfo> grids;
  std::map<std::string, std::string> metadata;
};
/// Lists the grids of a .vdb or .nvdb file. Like every reader here it first reads a foreign file in a guarded child
/// process, because OpenVDB's reader is not safe on damaged files; whatever happens there becomes one Error(Input).
VOLCAUSTIC_API VdbInfo inspectVdb(const std::filesystem::path& path, const RunContext& ctx = {});

/// Differences grid by grid over the union of active voxels (of vectors: of all components).
/// \throws Error(Input) when a grid of one file is missing in the other, or types or transforms differ.
VOLCAUSTIC_API std::vector<Difference> compareVdb(const std::filesystem::path& a, const std::filesystem::path& b,
                                                  const RunContext& ctx = {});

/// .vdb to .nvdb or back, every grid whose type both know. \throws Error naming a grid that cannot be converted.
VOLCAUSTIC_API void convertVdb(const std::filesystem::path& in, const std::filesystem::path& out,
                               const VdbWriteOptions& options = {}, const RunContext& ctx = {});

} // namespace volcaustic
