#include "volcaustic/openvdb.h"
#include "volume/iso_surface.h"
#include "volume/scalar_grid.h"
#include "volume/sharpen_coverage.h"
#include "volume/vdb_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace volcaustic {

namespace {

/// The one grid that the options name: as asked, else `coverage`, else the first scalar one.
GridSelection surfaceGrid(const std::string& place, const std::string& wanted) {
  return [place, wanted](std::span<const GridName> grids) -> std::vector<std::size_t> {
    const auto named = [&](const std::string& name) {
      return std::find_if(grids.begin(), grids.end(), [&](const GridName& g) { return g.name == name; });
    };
    auto chosen = named(wanted.empty() ? "coverage" : wanted);
    if (chosen == grids.end() && wanted.empty())
      chosen = std::find_if(grids.begin(), grids.end(), [](const GridName& g) { return isScalarType(g.type); });
    if (chosen == grids.end())
      throw Error(ErrorKind::Input, place + ": holds " +
                                        (wanted.empty() ? "no scalar grid" : "no grid '" + wanted + "'") +
                                        "; it holds " + listGrids(grids));
    if (!isScalarType(chosen->type) && !isVectorType(chosen->type))
      throw Error(ErrorKind::Input, place + ": grid '" + chosen->name + "' is of type " + chosen->type +
                                        ", which has no iso-surface; it holds " + listGrids(grids));
    return {static_cast<std::size_t>(chosen - grids.begin())};
  };
}

void requireOptions(const SurfaceOptions& options) {
  if (!(options.adaptivity >= 0 && options.adaptivity <= 1))
    throw Error(ErrorKind::Usage, "adaptivity: " + std::to_string(options.adaptivity) + " is not in 0 to 1");
  if (!options.automaticIsovalue && !std::isfinite(options.isovalue))
    throw Error(ErrorKind::Usage, "isovalue: is not finite");
}

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

Mesh surfaceOf(const openvdb::FloatGrid::ConstPtr& grid, bool isCoverage, const SurfaceOptions& options,
               const std::string& place, const RunContext& ctx) {
  const double automatic = grid->getGridClass() == openvdb::GRID_LEVEL_SET ? 0.0 : 0.5;
  const double isovalue = options.automaticIsovalue ? automatic : options.isovalue;
  const bool sharpen = options.sharpen && isCoverage && isovalue == 0.5;
  Mesh mesh = isoSurface(sharpen ? *sharpenedCoverage(*grid, ctx) : *grid, isovalue, options.adaptivity, place, ctx);
  if (mesh.empty()) {
    float low = grid->background(), high = low;
    for (auto value = grid->cbeginValueOn(); value; ++value) {
      low = std::min(low, *value);
      high = std::max(high, *value);
    }
    throw Error(ErrorKind::Input, place + ": has no surface at the value " + text(isovalue) + "; its values go from " +
                                      text(low) + " to " + text(high) + ", choose another isovalue");
  }
  return mesh;
}

} // namespace

Mesh surfaceFromVdb(const std::filesystem::path& path, const SurfaceOptions& options, const RunContext& ctx) {
  requireOptions(options);
  const VdbFile file = readVdbFile(path, ctx, surfaceGrid(path.string(), options.grid));
  const std::string name = file.grids.at(0)->getName();
  return surfaceOf(asFloatGrid(file.grids[0], ctx), name == "coverage", options,
                   path.string() + ": grid '" + name + "'", ctx);
}

Mesh surfaceFromMedium(const Medium& medium, const SurfaceOptions& options, const RunContext& ctx) {
  requireOptions(options);
  return surfaceOf(medium.grids().coverage, true, options, "medium: grid 'coverage'", ctx);
}

} // namespace volcaustic
