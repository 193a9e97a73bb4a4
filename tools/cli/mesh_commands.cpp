// mesh2vdb and vdb2mesh: between surfaces and volumes.
#include "common.h"
#include "file_kind.h"
#include "option_flags.h"

#include <volcaustic/medium.h>
#include <volcaustic/mesh.h>
#include <volcaustic/vdb.h>

#include <filesystem>
#include <fmt/format.h>
#include <set>

namespace volcaustic::cli {

namespace {

/// One output for each input. `outputs` is as many files, one pattern with {} for the input's stem, or one folder,
/// where the files get `extension`. \throws Error(Usage) when it is none of these, or two inputs would write the same
/// file.
std::vector<std::string> outputsFor(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                                    const std::string& extension, FileKind kind) {
  std::vector<std::string> files = outputs;
  if (outputs.size() == 1) {
    const std::string& target = outputs.front();
    const bool isFolder = target.ends_with('/') || std::filesystem::is_directory(target);
    const bool isPattern = target.find("{}") != std::string::npos;
    if (isFolder || isPattern) files.clear();
    for (const std::string& input : inputs) {
      const std::string stem = std::filesystem::path(input).stem().string();
      if (isPattern)
        files.push_back(std::string(target).replace(target.find("{}"), 2, stem));
      else if (isFolder)
        files.push_back((std::filesystem::path(target) / (stem + extension)).string());
    }
  }
  if (files.size() != inputs.size())
    throw Error(ErrorKind::Usage,
                fmt::format("--output: {} outputs for {} inputs; give one for each, a folder, or a name "
                            "with {{}} for the input's name",
                            files.size(), inputs.size()));
  if (const std::set<std::string> different(files.begin(), files.end()); different.size() != files.size())
    throw Error(ErrorKind::Usage, "--output: two inputs would write the same file; give them different names");
  for (const std::string& file : files) checkOutput(file, kind);
  return files;
}

void addFiles(CLI::App& command, std::vector<std::string>& inputs, std::vector<std::string>& outputs,
              const char* inputText, const char* outputText) {
  command.add_option("IN", inputs, inputText)->required();
  command.add_option("-o,--output", outputs, outputText)->required()->allow_extra_args(false);
}

/// How finely a mesh is voxelised when it stands alone.
struct LatticeOptions {
  int resolution = 128;
  double voxelSize = 0;
  int padding = 8;
};
template <class Visitor>
void describe(Visitor&& visit, LatticeOptions& o) {
  visit("resolution", o.resolution, FieldDoc{"voxels along the longest side of the mesh", "voxels", 1, 32768});
  visit("voxelSize", o.voxelSize, FieldDoc{"edge of a voxel; above 0 it replaces the resolution", "world", 0, 1e12});
  visit("padding", o.padding, FieldDoc{"empty voxels around the mesh, room for the blur", "voxels", 0, 4096});
}

struct MeshToVdb {
  CommonOptions common;
  std::vector<std::string> inputs, outputs;
  LatticeOptions lattice;
  Material material;
  VoxeliseOptions voxelise;
  VdbWriteOptions write;
};

void declareMeshToVdb(CLI::App& command, MeshToVdb& o) {
  addFiles(command, o.inputs, o.outputs, "meshes: .obj, .ply, .stl, .off",
           "one .vdb or .nvdb for each mesh, a folder, a name with {} for the mesh's name, or - for standard output");
  addFlags(command, o.lattice);
  command.get_option("--voxel-size")->excludes("--resolution");
  addFlags(command, o.material, {{}, {{"index", "ior"}}});
  addFlags(command, o.voxelise);
  addFlags(command, o.write, {{"half"}, {}});
}

/// Reads, voxelises and writes one mesh; returns what was counted.
Json voxeliseFile(Job& job, const MeshToVdb& o, const std::string& input, const std::string& output) {
  const RunContext& ctx = job.context();
  auto mesh = std::make_shared<Mesh>(job.timed("read", [&] { return readMesh(input, ctx); }));
  const Domain domain = domainAround(bounds(*mesh), o.lattice.resolution, o.lattice.voxelSize, o.lattice.padding);
  const Body body{mesh, o.material, 0, input};
  const Medium medium = job.timed("medium", [&] {
    return buildMedium({&body, 1}, Ambient{}, domain, o.voxelise, ctx);
  });
  job.timed("write", [&] { writeVdb(output, medium, o.write, ctx); });
  if (output != "-")
    job.console().say(fmt::format("{}: {} x {} x {} voxels of {:.6g}, from {} triangles", output, domain.dims[0],
                                  domain.dims[1], domain.dims[2], domain.voxelSize, mesh->triangles.size()));
  return {{"input", input},
          {"output", output},
          {"vertices", mesh->positions.size()},
          {"triangles", mesh->triangles.size()},
          {"dims", domain.dims},
          {"voxelSize", domain.voxelSize}};
}

int runMeshToVdb(const MeshToVdb& o) {
  Job job("mesh2vdb", o.common);
  for (int channel = 0; channel < 3; ++channel)
    if (o.material.scattering[channel] > o.material.attenuation[channel])
      throw Error(ErrorKind::Usage,
                  "--scattering: is more than --attenuation, which includes it; lower it or raise the other");
  const std::vector<std::string> outputs = outputsFor(o.inputs, o.outputs, ".vdb", FileKind::Volume);
  if (job.json() && outputs.front() == "-")
    throw Error(ErrorKind::Usage, "--json: standard output is taken by -o -; write to a file");
  Json counts = Json::array();
  for (std::size_t i = 0; i < o.inputs.size(); ++i) {
    counts.push_back(voxeliseFile(job, o, o.inputs[i], outputs[i]));
    job.addInput(o.inputs[i]);
    job.addOutput(outputs[i]);
  }
  job.report()["counts"] = std::move(counts);
  job.finish();
  return 0;
}

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

void addMeshCommands(CLI::App& app, Action& action) {
  addCommand<MeshToVdb>(app, action, "mesh2vdb", "voxelise meshes: index, attenuation, scattering and coverage grids",
                        declareMeshToVdb, runMeshToVdb);
  addCommand<VdbToMesh>(app, action, "vdb2mesh", "iso-surface of a scalar grid", declareVdbToMesh, runVdbToMesh);
}

} // namespace volcaustic::cli
