// Grids of one file as the volumes of a medium, and where a domain's voxels lie in them.
#pragma once

#include "core/brick_grid.h"
#include "core/brick_set.h"
#include "volcaustic/medium_volume.h"

#include <openvdb/openvdb.h>
#include <string>
#include <vector>

namespace volcaustic {

class VolumeGrids {
public:
  struct Grid {
    std::string name;
    openvdb::FloatGrid::ConstPtr numbers; ///< of vectors their length
    openvdb::Vec3SGrid::ConstPtr vectors; ///< null where it holds numbers
    openvdb::CoordBBox active;            ///< empty where all is background
  };

  /// What is not the background of a grid is active. \throws as readVolumeGrids()
  VolumeGrids(const std::filesystem::path& path, const std::vector<std::string>& names, const RunContext& ctx);

  /// Null where none has this name.
  [[nodiscard]] const Grid* find(const std::string& name) const;
  [[nodiscard]] const std::vector<Grid>& all() const { return mGrids; }

private:
  std::vector<Grid> mGrids;
};

/// Where the voxels of a domain lie in the index space of a grid that is placed in the world.
class VoxelPlaces {
public:
  /// \throws Error(Usage), naming `place`, for a placement that flattens.
  VoxelPlaces(const openvdb::math::Transform& grid, const Affine& placement, const Domain& domain,
              const std::string& place);

  /// Centre of voxel (x, y, z), which need not be whole.
  [[nodiscard]] openvdb::Vec3d at(double x, double y, double z) const {
    return mOrigin + mSteps[0] * x + mSteps[1] * y + mSteps[2] * z;
  }
  /// Places along each axis of a voxel whose mean is its value: so many that none of the grid's voxels is passed by, up
  /// to eight.
  [[nodiscard]] int samples(int axis) const { return mSamples[axis]; }
  /// Marks the bricks of the domain whose samples can see a voxel of a box in index space.
  void markReach(const openvdb::CoordBBox& box, const Vec3i& brickDims, BrickSet& reach) const;

private:
  openvdb::Vec3d mOrigin;
  std::array<openvdb::Vec3d, 3> mSteps;
  openvdb::Mat3R mBack; ///< from index space to voxels
  std::array<int, 3> mSamples;
};

} // namespace volcaustic
