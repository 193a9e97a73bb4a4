// OpenVDB files as lists of grids: what the readers and writers of this folder share.
#pragma once

#include "volcaustic/error.h"
#include "volcaustic/run_context.h"
#include "volcaustic/vdb.h"

#include <filesystem>
#include <functional>
#include <openvdb/openvdb.h>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// Registers OpenVDB's types, once; every entry point that meets grids of unknown type calls it first.
void initialiseOpenVdb();

/// File metadata that restores a medium exactly; docs/formats.md lists them.
namespace metadata_key {
inline constexpr const char* kDims = "volcaustic_dims";
inline constexpr const char* kMinCorner = "volcaustic_min_corner";
inline constexpr const char* kVoxelSize = "volcaustic_voxel_size";
inline constexpr const char* kAmbientIndex = "volcaustic_ambient_index";
inline constexpr const char* kAmbientAttenuation = "volcaustic_ambient_attenuation";
inline constexpr const char* kAmbientScattering = "volcaustic_ambient_scattering";
inline constexpr const char* kAmbientAsymmetry = "volcaustic_ambient_asymmetry";
inline constexpr const char* kExposure = "exposure";
} // namespace metadata_key

struct VdbFile {
  openvdb::GridPtrVec grids; ///< .vdb: sorted by name; .nvdb: in file order
  openvdb::MetaMap metadata;

  [[nodiscard]] openvdb::GridBase::Ptr find(const std::string& name) const;
};

struct GridName {
  std::string name, type;
};
/// "density (Tree_float_5_4_3), v (Tree_vec3s_5_4_3)", for messages.
std::string listGrids(std::span<const GridName> grids);

/// Picks the grids that are wanted, as indices; may throw Error(Input). An empty function takes all.
using GridSelection = std::function<std::vector<std::size_t>(std::span<const GridName>)>;
/// The grids of these names, those that are there.
GridSelection gridsNamed(std::vector<std::string> names);

/// Reads a .vdb or .nvdb, told apart by content. The foreign bytes are parsed in a guarded child only
/// (core/guarded_process.h); what arrives here was written anew by that child. \throws Error(File), Error(Input).
VdbFile readVdbFile(const std::filesystem::path& path, const RunContext& ctx, const GridSelection& selection = {});

/// Writes .vdb or .nvdb by extension, or .vdb to standard output for "-"; whole or not at all, and with the same bytes
/// for the same grids. `options.metadata` goes to the file and to each grid. \throws Error(Usage) for another
/// extension, Error(File), Error(Input) naming a grid that .nvdb cannot hold.
void writeVdbFile(const std::filesystem::path& path, const openvdb::GridPtrVec& grids, openvdb::MetaMap metadata,
                  const VdbWriteOptions& options, const RunContext& ctx);

} // namespace volcaustic
