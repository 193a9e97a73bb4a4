// vdb2mesh: volumes to surfaces.
#include "common.h"
#include "mesh_files.h"
#include "option_flags.h"

#include <volcaustic/medium.h>
#include <volcaustic/mesh.h>

#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

struct VdbToMesh {
  CommonOptions common;
  std::vector<std::string> inputs, outputs;
  SurfaceOptions surface;
  bool ascii = false;
};

void declareVdbToMesh(CLI::App& command, VdbToMesh& o) {
  addFiles(command, o.inputs, o.outputs, "volumes: .vdb, .nvdb",
           "one .obj, .ply, .stl or .off for each volume, or a name with {} for the volume's name");
  addFlags(command, o.surface);
  CLI::Option* isovalue = command.get_option("--isovalue");
  isovalue->description("value on the surface; default 0.5 for coverage and fog, 0 for level sets")
      ->each([&o](const std::string&) { o.surface.automaticIsovalue = false; });
  command.add_flag("--ascii", o.ascii, "text instead of binary, where the format has both (.ply, .stl)");
}

int runVdbToMesh(const VdbToMesh& o) {
  Job job("vdb2mesh", o.common);
  const std::vector<std::string> outputs = outputsFor(o.inputs, o.outputs, ".ply", FileKind::Mesh);
  Json counts = Json::array();
  for (std::size_t i = 0; i < o.inputs.size(); ++i) {
    const Mesh mesh = job.timed("surface", [&] { return surfaceFromVdb(o.inputs[i], o.surface, job.context()); });
    job.timed("write", [&] { writeMesh(outputs[i], mesh, {.binary = !o.ascii}, job.context()); });
    job.console().say(
        fmt::format("{}: {} vertices, {} triangles", outputs[i], mesh.positions.size(), mesh.triangles.size()));
    job.addInput(o.inputs[i]);
    job.addOutput(outputs[i]);
    counts.push_back({{"input", o.inputs[i]},
                      {"output", outputs[i]},
                      {"vertices", mesh.positions.size()},
                      {"triangles", mesh.triangles.size()}});
  }
  job.report()["counts"] = std::move(counts);
  job.finish();
  return 0;
}

} // namespace

void addVdbToMeshCommand(CLI::App& app, Action& action) {
  addCommand<VdbToMesh>(app, action, "vdb2mesh", "iso-surface of a scalar grid", declareVdbToMesh, runVdbToMesh);
}

} // namespace volcaustic::cli
