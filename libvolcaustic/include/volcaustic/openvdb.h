/// \file openvdb.h
/// The one bridge between volcaustic and OpenVDB: include it only where grids cross the border (OpenVDB's own header
/// costs ten seconds and more of compilation).
#pragma once

#include "volcaustic/medium.h"
#include "volcaustic/photons.h"

#include <openvdb/openvdb.h>

namespace volcaustic {

/// The grids of a medium. Index coordinate (0, 0, 0) is the domain's first voxel; see Domain for the transform.
struct MediumGrids {
  openvdb::FloatGrid::ConstPtr index;       ///< background: the ambient index
  openvdb::Vec3SGrid::ConstPtr attenuation; ///< 1/world; background: ambient
  openvdb::Vec3SGrid::ConstPtr scattering;  ///< 1/world; background: ambient
  openvdb::FloatGrid::ConstPtr coverage;    ///< solid fraction 0..1
  openvdb::FloatGrid::ConstPtr asymmetry;   ///< null where g is the ambient one everywhere
};

/// The linear transform of a domain's grids.
VOLCAUSTIC_API openvdb::math::Transform::Ptr domainTransform(const Domain& domain);

/// A medium from grids made elsewhere. Their transforms must be the domain's; null attenuation, scattering, coverage
/// and asymmetry mean ambient (and zero coverage). \throws Error(Input) when `index` is null or a transform differs.
VOLCAUSTIC_API Medium mediumFromGrids(const Domain& domain, const Ambient& ambient, MediumGrids grids);

/// Radiance (fluence / 4 pi) and direction as grids; the parts are null unless asked for.
struct RadianceGrids {
  openvdb::Vec3SGrid::Ptr radiance, direction, caustic, direct;
};
VOLCAUSTIC_API RadianceGrids radianceGrids(const RadianceVolume& radiance, bool parts = false);

/// Labels of the step field (VD sections 2 and 3) on a tree that is the octree where both agree: level m says that the
/// aligned cube of 2^m voxels is nearly constant; kStepCapped is added where the step is capped.
inline constexpr int kStepCapped = 256;
VOLCAUSTIC_API openvdb::Int32Grid::Ptr stepFieldGrid(const Medium& medium, const StepFieldOptions& options = {},
                                                     const RunContext& ctx = {});

} // namespace volcaustic
