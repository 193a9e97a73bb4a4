// A medium's grids as OpenVDB pointers: read here, changed here, and handed back.
#include <volcaustic/openvdb.h>
#include <volcaustic/volcaustic.h>

#include <cmath>
#include <cstdio>

int main() {
  openvdb::initialize();
  const volcaustic::Domain domain{.minCorner = {-1, -1, -1}, .voxelSize = 0.125, .dims = {16, 16, 16}};
  const auto ramp = [](const volcaustic::Vec3d& pWorld) { return 1.5 + 0.25 * pWorld[2]; };
  const volcaustic::Medium medium = volcaustic::sampleMedium(domain, {}, ramp);

  const openvdb::FloatGrid::ConstPtr index = medium.grids().index;
  const openvdb::Coord voxel(3, 7, 11);
  const openvdb::Vec3d centre = index->transform().indexToWorld(voxel);
  const double expected = ramp({centre.x(), centre.y(), centre.z()});
  if (std::abs(index->getConstAccessor().getValue(voxel) - expected) > 1e-6) {
    std::fprintf(stderr, "index of a voxel is not that of its centre\n");
    return 1;
  }

  volcaustic::MediumGrids changed = medium.grids();
  const openvdb::FloatGrid::Ptr raised = index->deepCopy();
  raised->tree().setValue(voxel, 2.0F);
  changed.index = raised;
  const volcaustic::Medium back = volcaustic::mediumFromGrids(domain, medium.ambient(), changed);
  return back.grids().index->tree().getValue(voxel) == 2.0F ? 0 : 1;
}
