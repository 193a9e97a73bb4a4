/// \file usd.h
/// Volumes for OpenUSD: a text stage (.usda) that names .vdb files, written without OpenUSD.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/run_context.h"

#include <filesystem>
#include <span>

namespace volcaustic {

enum class UpAxis { Y, Z };

struct UsdWriteOptions {
  double metersPerUnit = 1; ///< length of a unit of the world
  UpAxis upAxis = UpAxis::Z;
  double rate = 24; ///< frames per second
};

/// A volume, and when it is seen.
struct UsdFrame {
  int frame = 1;
  std::filesystem::path file; ///< .vdb
};

/// Writes a stage of one Volume prim with a field (OpenVDBAsset) for each grid that the files hold and OpenUSD knows:
/// name, data type, class, role, and the file, relative to the stage. Several frames become time samples, a frame's
/// number its time code. The extent is the domain's box, of volumes made by others that of the active voxels, time
/// sampled where it changes. Written beside the target and renamed when whole. \throws Error(Usage) for another
/// extension, no frame or a file that is no .vdb, Error(Input) where grids of one name differ in their type or a file
/// has no grid that OpenUSD knows, Error(File).
VOLCAUSTIC_API void writeUsd(const std::filesystem::path& path, std::span<const UsdFrame> frames,
                             const UsdWriteOptions& options = {}, const RunContext& ctx = {});

} // namespace volcaustic
