// convert: .vdb <-> .nvdb, between mesh and image formats, volumes made by others to media, sequences to stages.
#include "common.h"
#include "file_kind.h"
#include "frames.h"
#include "group_material.h"
#include "named_settings.h"
#include "option_flags.h"

#include <volcaustic/image.h>
#include <volcaustic/mesh.h>
#include <volcaustic/usd.h>
#include <volcaustic/vdb.h>

#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

struct Convert {
  CommonOptions common;
  std::string in, out, frames;
  bool resume = false;
  std::string index, attenuation, scattering, asymmetry, coverage, body;
  MediumImport import;
  VdbWriteOptions write;
  ImageWriteOptions image;
  UsdWriteOptions stage;
};

constexpr const char* kMapping = "A medium from any volume: value = offset + scale * grid; RGB as 0.1/0.2/0.3";

void declareConvert(CLI::App& command, Convert& o) {
  command.add_option("IN", o.in, "volume, mesh or image")->required();
  command.add_option("OUT", o.out, "file to write; its extension says the format")->required();
  command.add_option("--frames", o.frames,
                     "A-B[xS]: a sequence, the frame's number in the place of #### or %04d in IN and OUT");
  command.add_flag("--resume", o.resume, "skip outputs that are there");
  const auto mapping = [&](const char* flag, std::string& text, const char* what) {
    command.add_option(flag, text, what)->option_text("GRID[:scale=S,offset=O]")->group(kMapping);
  };
  mapping("--index", o.index, "refractive index, as heat:scale=-1e-4,offset=1.0003");
  mapping("--attenuation", o.attenuation, "extinction coefficient [1/world], as density:scale=2");
  mapping("--scattering", o.scattering, "scattering coefficient [1/world], as density:scale=1.8/1.6/1.2");
  mapping("--asymmetry", o.asymmetry, "Henyey-Greenstein mean cosine g");
  mapping("--coverage", o.coverage, "solid fraction, 0 to 1");
  command.add_option("--body", o.body, "level set or solid fraction of a body, as sphere:ior=1.5,attenuation=0.1")
      ->option_text("GRID[:ior=N,...]")
      ->group(kMapping);
  addFlags(command, o.import);
  command.add_flag("--half", o.write.half, "16-bit floats in .vdb, .nvdb and .exr files");
  addFlags(command, o.write, {{"preset"}, {}});
  addFlags(command, o.image, {{"layers", "compression", "tiles", "exposure", "tone", "bits", "alpha"}, {}});
  addFlags(command, o.stage);
}

/// What the command line maps; an empty import when nothing.
MediumImport importOf(const Convert& o) {
  MediumImport import = o.import;
  const auto map = [](const char* flag, const std::string& text, std::optional<GridMapping>& mapping) {
    if (text.empty()) return;
    GridMapping& made = mapping.emplace();
    made.grid = nameAndSettings(flag, text, [&](FieldSetter& setter) { describe(setter, made); });
  };
  map("--index", o.index, import.index);
  map("--attenuation", o.attenuation, import.attenuation);
  map("--scattering", o.scattering, import.scattering);
  map("--asymmetry", o.asymmetry, import.asymmetry);
  map("--coverage", o.coverage, import.coverage);
  if (!o.body.empty()) {
    const auto describeMaterial = [&](FieldSetter& setter) { describe(setter, import.material); };
    import.body = nameAndSettings("--body", o.body, describeMaterial);
    requirePhysical(import.material, "--body " + o.body);
  }
  return import;
}

bool mapsGrids(const Convert& o) {
  for (const std::string* text : {&o.index, &o.attenuation, &o.scattering, &o.asymmetry, &o.coverage, &o.body})
    if (!text->empty()) return true;
  return false;
}

void importVolume(Job& job, const FilePair& file, const Convert& o) {
  const RunContext& ctx = job.context();
  const Medium medium = job.timed("import", [&] { return importMedium(file.in, importOf(o), ctx); });
  job.timed("write", [&] { writeVdb(file.out, medium, o.write, ctx); });
  const Domain& domain = medium.domain();
  job.report()["dims"] = domain.dims;
  job.report()["voxelSize"] = domain.voxelSize;
  job.console().say(fmt::format("{}: {} x {} x {} voxels of {:.6g}", file.out, domain.dims[0], domain.dims[1],
                                domain.dims[2], domain.voxelSize));
}

void convertFile(Job& job, const FilePair& file, const Convert& o, FileKind kind) {
  const RunContext& ctx = job.context();
  job.timed("convert", [&] {
    switch (kind) {
    case FileKind::Volume:
      return convertVdb(file.in, file.out, o.write, ctx);
    case FileKind::Mesh:
      return writeMesh(file.out, readMesh(file.in, ctx), {}, ctx);
    default:
      ImageWriteOptions write = o.image;
      write.half = o.write.half;
      return writeImage(file.out, readImage(file.in, ctx), write, ctx);
    }
  });
  job.console().say(file.out + ": written");
}

bool isStage(const std::string& path) { return std::filesystem::path(path).extension() == ".usda"; }

/// One stage that names all volumes.
void convertToStage(Job& job, const Convert& o) {
  if (mapsGrids(o)) throw Error(ErrorKind::Usage, o.out + ": names grids as they are; map them into a .vdb first");
  std::vector<UsdFrame> frames;
  for (const FilePair& file : framePairs(o.in, o.in, o.frames)) {
    job.addInput(file.in);
    frames.push_back({file.frame, file.in});
  }
  job.addOutput(o.out);
  if (job.skips(o.resume, o.out)) return;
  job.timed("stage", [&] { writeUsd(o.out, frames, o.stage, job.context()); });
  job.console().say(o.out + ": written");
}

void convertEach(Job& job, const Convert& o) {
  for (const FilePair& file : framePairs(o.in, o.out, o.frames)) {
    job.addInput(file.in);
    job.addOutput(file.out);
    if (job.skips(o.resume, file.out)) continue;
    const FileKind kind = fileKind(file.in);
    if (kind == FileKind::Scene)
      throw Error(ErrorKind::Usage, file.in + ": a scene has no other format; trace or render it");
    checkOutput(file.out, kind);
    if (mapsGrids(o) && kind != FileKind::Volume)
      throw Error(ErrorKind::Usage, file.in + ": is no volume, so no grid of it can be mapped");
    if (mapsGrids(o))
      importVolume(job, file, o);
    else
      convertFile(job, file, o, kind);
  }
}

int runConvert(const Convert& o) {
  Job job("convert", o.common);
  if (isStage(o.out))
    convertToStage(job, o);
  else
    convertEach(job, o);
  job.finish();
  return 0;
}

} // namespace

void addConvertCommand(CLI::App& app, Action& action) {
  addCommand<Convert>(
      app, action, "convert",
      ".vdb to .nvdb and back, any volume to a medium, volumes to a .usda, and between mesh or image formats",
      declareConvert, runConvert);
}

} // namespace volcaustic::cli
