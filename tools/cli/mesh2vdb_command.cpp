// mesh2vdb: surfaces to volumes, one mesh, many, or a sequence of frames.
#include "common.h"
#include "group_material.h"
#include "mesh2vdb.h"
#include "mesh_files.h"
#include "option_flags.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace volcaustic::cli {

namespace {

/// What belongs to a mesh; a scene says all of this itself.
void declareMeshOptions(CLI::App& command, MeshToVdb& o) {
  addFlags(command, o.lattice);
  command.get_option("--voxel-size")->excludes("--resolution");
  command
      .add_option("--bounds", o.lattice.bounds,
                  "box that the voxels cover in place of the mesh's own: least x y z, greatest x y z [world]")
      ->expected(6)
      ->allow_extra_args(false)
      ->option_text("FLOAT FLOAT FLOAT FLOAT FLOAT FLOAT");
  addFlags(command, o.material, {{}, {{"index", "ior"}}});
  command
      .add_option(
          "--group", o.groups,
          "material of one group of the mesh (OBJ usemtl), as wine:ior=1.33,priority=1,attenuation=0.1/0.4/0.3; "
          "what it leaves out is as for the rest; again for more")
      ->allow_extra_args(false)
      ->option_text("NAME:KEY=VALUE,...");
  addFlags(command, o.voxelise);
}

void declareMeshToVdb(CLI::App& command, MeshToVdb& o) {
  addFiles(command, o.inputs, o.outputs,
           "meshes: .obj, .ply, .stl, .off, or - for one on standard input; shape files (.json); or a scene (.json, "
           ".gltf, .glb), all of whose bodies make one volume",
           "one .vdb or .nvdb for each input, a folder, a name with {} for the input's name, or - for standard output");
  const auto before = std::ssize(command.get_options());
  declareMeshOptions(command, o);
  const std::vector<CLI::Option*> all = command.get_options({});
  o.meshOptions.assign(all.begin() + before, all.end());
  addFlags(command, o.write, {{"half"}, {}});
  addSceneFlags(command, o.scene, true);
  command.add_option("--frames", o.frames,
                     "A-B[xS]: a sequence, the frame's number in the place of #### or %04d in IN and OUT (of "
                     "shapes and scenes in OUT alone); all frames of a mesh or a shape get one lattice, around all of "
                     "them or --bounds");
  command.add_flag("--resume", o.resume, "skip outputs that are there");
}

} // namespace

void addMeshToVdbCommand(CLI::App& app, Action& action) {
  addCommand<MeshToVdb>(app, action, "mesh2vdb", "voxelise meshes: index, attenuation, scattering and coverage grids",
                        declareMeshToVdb, runMeshToVdb);
}

} // namespace volcaustic::cli
