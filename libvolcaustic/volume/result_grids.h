// The grids of results, as files and programs name them (docs/formats.md).
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/openvdb.h"
#include "volcaustic/photons.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace volcaustic {

/// Of the values of the grid of this name; radiance_NAME is radiance. Null for names that are none of ours.
struct GridMeaning {
  const char *name, *symbol, *unit;
  int components;
};
const GridMeaning* meaningOf(std::string_view grid);

/// Grids of a medium under their names, with classes and units.
openvdb::GridPtrVec grids(const Medium& medium);

/// Grids of a photon pass, made when they are asked for; light is multiplied by 2^exposure.
class LightGrids {
public:
  /// All must outlive it.
  LightGrids(const PhotonResult& photons, const Medium& medium, double exposure, const RunContext& ctx);

  /// In the order of the file: radiance, direction, emission, density, the parts where asked for; then of each light by
  /// itself.
  [[nodiscard]] static std::vector<std::string> names(const PhotonResult& photons, bool parts);
  /// Null for a name that is not among names(photons, true).
  [[nodiscard]] openvdb::GridBase::Ptr make(const std::string& name);

private:
  [[nodiscard]] openvdb::GridBase::Ptr light(const BrickGrid<Vec3f>& values, const std::string& name) const;
  const BrickGrid<Vec3f>& total();

  const PhotonResult& mPhotons;
  const Medium& mMedium;
  const double mExposure, mFactor;
  const RunContext& mCtx;
  std::optional<BrickGrid<Vec3f>> mTotal; ///< radiance, which emission is made of, too
};

} // namespace volcaustic
