// vdb2mesh: volumes to surfaces.
#include "common.h"
#include "frames.h"
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
  std::string frames;
  bool resume = false, ascii = false;
};

void declareVdbToMesh(CLI::App& command, VdbToMesh& o) {
  addFiles(command, o.inputs, o.outputs, "volumes: .vdb, .nvdb",
           "one .obj, .ply, .stl or .off for each volume, or a name with {} for the volume's name");
  addFlags(command, o.surface);
  CLI::Option* isovalue = command.get_option("--isovalue");
  isovalue->description("value on the surface; default 0.5 for coverage and fog, 0 for level sets")
      ->each([&o](const std::string&) { o.surface.automaticIsovalue = false; });
  command.add_option("--frames", o.frames,
                     "A-B[xS]: a sequence, the frame's number in the place of #### or %04d in IN and OUT");
  command.add_flag("--resume", o.resume, "skip outputs that are there");
  command.add_flag("--ascii", o.ascii, "text instead of binary, where the format has both (.ply, .stl)");
}

int runVdbToMesh(const VdbToMesh& o) {
  Job job("vdb2mesh", o.common);
  const std::vector<std::string> outputs = outputsFor(o.inputs, o.outputs, ".ply", FileKind::Mesh);
  Json counts = Json::array();
  std::vector<FilePair> files;
  for (std::size_t i = 0; i < o.inputs.size(); ++i)
    for (FilePair& file : framePairs(o.inputs[i], outputs[i], o.frames)) files.push_back(std::move(file));
  for (const FilePair& file : files) {
    job.addInput(file.in);
    job.addOutput(file.out);
    if (job.skips(o.resume, file.out)) {
      counts.push_back({{"input", file.in}, {"output", file.out}, {"skipped", true}});
      continue;
    }
    const Mesh mesh = job.timed("surface", [&] { return surfaceFromVdb(file.in, o.surface, job.context()); });
    job.timed("write", [&] { writeMesh(file.out, mesh, {.binary = !o.ascii}, job.context()); });
    job.console().say(
        fmt::format("{}: {} vertices, {} triangles", file.out, mesh.positions.size(), mesh.triangles.size()));
    counts.push_back({{"input", file.in},
                      {"output", file.out},
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
