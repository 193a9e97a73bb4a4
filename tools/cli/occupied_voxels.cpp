#include "occupied_voxels.h"

#include <cmath>
#include <volcaustic/openvdb.h>

namespace volcaustic::cli {

std::int64_t occupiedVoxels(const Medium& medium) {
  openvdb::Index64 voxels = 0;
  for (auto value = medium.grids().coverage->cbeginValueOn(); value; ++value)
    if (*value > 0) voxels += value.getVoxelCount();
  return static_cast<std::int64_t>(voxels);
}

double coveredVolume(const Medium& medium) {
  double voxels = 0;
  for (auto value = medium.grids().coverage->cbeginValueOn(); value; ++value)
    voxels += *value * static_cast<double>(value.getVoxelCount());
  return voxels * std::pow(medium.domain().voxelSize, 3);
}

} // namespace volcaustic::cli
