// The options of mesh2vdb and its work.
#pragma once

#include "common.h"
#include "scene_input.h"

#include <volcaustic/medium.h>
#include <volcaustic/options.h>
#include <volcaustic/vdb.h>

#include <string>
#include <vector>

namespace volcaustic::cli {

/// How finely a mesh is voxelised when it stands alone.
struct LatticeOptions {
  int resolution = 128;
  double voxelSize = 0;
  int padding = 8;
  std::vector<double> bounds; ///< empty, or the least and the greatest corner
};

template <class Visitor>
void describe(Visitor&& visit, LatticeOptions& o) {
  visit("resolution", o.resolution,
        FieldDoc{"voxels along the longest side of the mesh, or of the box of all frames", "voxels", 1, 32768});
  visit("voxelSize", o.voxelSize, FieldDoc{"edge of a voxel; above 0 it replaces the resolution", "world", 0, 1e12});
  visit("padding", o.padding, FieldDoc{"empty voxels around the mesh, room for the blur", "voxels", 0, 4096});
}

struct MeshToVdb {
  CommonOptions common;
  std::vector<std::string> inputs, outputs;
  LatticeOptions lattice;
  Material material;
  std::vector<std::string> groups;
  VoxeliseOptions voxelise;
  VdbWriteOptions write;
  SceneFlags scene;
  std::string frames;
  bool resume = false;
  std::vector<const CLI::Option*> meshOptions; ///< those that mean nothing for a scene
};

int runMeshToVdb(const MeshToVdb& options);

} // namespace volcaustic::cli
