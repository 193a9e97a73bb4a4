// shape2mesh: functional objects to triangles, one shape, many, or the frames of one.
#include "common.h"
#include "frames.h"
#include "mesh_files.h"
#include "option_flags.h"

#include <volcaustic/mesh.h>
#include <volcaustic/polygonise.h>
#include <volcaustic/shape_file.h>

#include <fmt/format.h>
#include <optional>

namespace volcaustic::cli {

namespace {

struct ShapeToMesh {
  CommonOptions common;
  std::vector<std::string> inputs, outputs, sets;
  PolygoniseOptions polygonise;
  std::string frames;
  bool resume = false, ascii = false;
};

void declareShapeToMesh(CLI::App& command, ShapeToMesh& o) {
  addFiles(command, o.inputs, o.outputs, "shape files: .json",
           "one .obj, .ply, .stl or .off for each shape, a folder, or a name with {} for the shape's name");
  addFlags(command, o.polygonise);
  command.get_option("--cell-size")->excludes("--resolution");
  command.add_option("--set", o.sets, "set any value of the shape first, as shape.radius=0.2; again for more")
      ->allow_extra_args(false);
  command.add_option("--frames", o.frames, "A-B[xS]: one mesh a frame, its number in the place of #### or %04d in OUT");
  command.add_flag("--resume", o.resume, "skip outputs that are there");
  command.add_flag("--ascii", o.ascii, "text instead of binary, where the format has both (.ply, .stl)");
}

/// One mesh to make.
struct ShapeMesh {
  std::string input, output;
  std::optional<int> frame;
};

/// The meshes of an input: one, or one for each frame.
std::vector<ShapeMesh> meshesOf(const std::string& input, const std::string& output, const std::string& frames) {
  if (frames.empty()) {
    if (hasFramePlace(output))
      throw Error(ErrorKind::Usage, output + ": has a place for a frame number; give --frames");
    return {{input, output, {}}};
  }
  std::vector<ShapeMesh> meshes;
  for (const int frame : parseFrames(frames)) meshes.push_back({input, withFrame(framePattern(output), frame), frame});
  return meshes;
}

/// Makes one mesh; `polygoniser` takes over what the frame before has in common with it.
void convert(const ShapeMesh& mesh, const ShapeToMesh& o, Polygoniser& polygoniser, Job& job, Json& entry) {
  const RunContext& ctx = job.context();
  const Shape shape = job.timed("read", [&] {
    return readShape(mesh.input, {o.sets, static_cast<double>(mesh.frame.value_or(1))});
  });
  const auto start = std::chrono::steady_clock::now();
  Mesh triangles;
  try {
    triangles = job.timed("polygonise", [&] { return polygoniser.polygonise(shape, o.polygonise, ctx); });
  } catch (const Error& error) { // which knows no file
    if (error.kind() != ErrorKind::Input) throw;
    throw Error(error.kind(), mesh.input + ": " + error.what());
  }
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  job.timed("write", [&] { writeMesh(mesh.output, triangles, {.binary = !o.ascii}, ctx); });

  const PolygoniseReport& report = polygoniser.report();
  entry["vertices"] = triangles.positions.size();
  entry["triangles"] = triangles.triangles.size();
  entry["groups"] = triangles.groupNames;
  entry["cellSize"] = report.cellSize;
  entry["deviation"] = report.deviation;
  entry["blocks"] = report.blocks;
  entry["reusedBlocks"] = report.reusedBlocks;
  entry["evaluations"] = report.evaluations;
  entry["ms"] = ms;
  job.console().say(fmt::format(
      "{}: {} vertices, {} triangles, cells of {:.4g}, at most {:.2g} from the shape{}", mesh.output,
      triangles.positions.size(), triangles.triangles.size(), report.cellSize, report.deviation,
      mesh.frame ? fmt::format("; {} of {} blocks as in the frame before", report.reusedBlocks, report.blocks) : ""));
}

int runShapeToMesh(const ShapeToMesh& o) {
  Job job("shape2mesh", o.common);
  const std::vector<std::string> outputs = outputsFor(o.inputs, o.outputs, ".ply", FileKind::Mesh);
  std::vector<std::vector<ShapeMesh>> sequences;
  for (std::size_t i = 0; i < o.inputs.size(); ++i) sequences.push_back(meshesOf(o.inputs[i], outputs[i], o.frames));
  const std::size_t count = sequences.size() * sequences.front().size();
  std::size_t started = 0;
  for (const std::vector<ShapeMesh>& sequence : sequences) {
    Polygoniser polygoniser;
    for (const ShapeMesh& mesh : sequence) {
      job.console().startFile(started++, count);
      job.addInput(mesh.input);
      job.addOutput(mesh.output);
      Json entry{{"input", mesh.input}, {"output", mesh.output}};
      if (mesh.frame) entry["frame"] = *mesh.frame;
      if (job.skips(o.resume, mesh.output))
        entry["skipped"] = true;
      else
        job.attempt(entry, [&] { convert(mesh, o, polygoniser, job, entry); });
      job.report()["counts"].push_back(std::move(entry));
    }
  }
  job.finish();
  return job.status();
}

} // namespace

void addShapeToMeshCommand(CLI::App& app, Action& action) {
  addCommand<ShapeToMesh>(app, action, "shape2mesh", "triangles of functional objects", declareShapeToMesh,
                          runShapeToMesh);
}

} // namespace volcaustic::cli
