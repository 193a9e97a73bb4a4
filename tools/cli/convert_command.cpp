// convert: .vdb <-> .nvdb, and between mesh and image formats.
#include "common.h"
#include "file_kind.h"

#include <volcaustic/image.h>
#include <volcaustic/mesh.h>
#include <volcaustic/vdb.h>

namespace volcaustic::cli {

namespace {

struct Convert {
  CommonOptions common;
  std::string in, out;
};

void declareConvert(CLI::App& command, Convert& o) {
  command.add_option("IN", o.in, "volume, mesh or image")->required();
  command.add_option("OUT", o.out, "file to write; its extension says the format")->required();
}

int runConvert(const Convert& o) {
  Job job("convert", o.common);
  const RunContext& ctx = job.context();
  const FileKind kind = fileKind(o.in);
  if (kind == FileKind::Scene)
    throw Error(ErrorKind::Usage, o.in + ": a scene has no other format; trace or render it");
  checkOutput(o.out, kind);
  job.timed("convert", [&] {
    switch (kind) {
    case FileKind::Volume:
      return convertVdb(o.in, o.out, {}, ctx);
    case FileKind::Mesh:
      return writeMesh(o.out, readMesh(o.in, ctx), {}, ctx);
    default:
      return writeImage(o.out, readImage(o.in, ctx), {}, ctx);
    }
  });
  job.addInput(o.in);
  job.addOutput(o.out);
  job.console().say(o.out + ": written");
  job.finish();
  return 0;
}

} // namespace

void addConvertCommand(CLI::App& app, Action& action) {
  addCommand<Convert>(app, action, "convert", ".vdb to .nvdb and back, and between mesh or image formats",
                      declareConvert, runConvert);
}

} // namespace volcaustic::cli
