// info: what is in volumes, images, meshes, scenes and shapes.
#include "file_kind.h"
#include "info_report.h"

#include <volcaustic/shape_file.h>

#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

struct Info {
  CommonOptions common;
  std::vector<std::string> files;
  bool selfIntersections = false;
};

void declareInfo(CLI::App& command, Info& o) {
  command.add_option("FILE", o.files, "volumes, images, meshes, scenes or shapes")->required();
  command.add_flag("--self-intersections", o.selfIntersections,
                   "of meshes also where the surface runs through itself: pairs of triangles, and their box");
  command.footer(
      "Tables on standard output; --verbose adds the grids' metadata and the rows of long tables, --json has "
      "everything. A file that cannot be read is one line on standard error and exit status 3; the others get "
      "their turn. A mesh's \"--fill auto\" is the rule that mesh2vdb would take, and why.");
}

Json infoOf(const std::string& file, const Info& o, Job& job) {
  switch (fileKind(file)) {
  case FileKind::Volume:
    return volumeInfo(file, job);
  case FileKind::Image:
    return imageInfo(file, job);
  case FileKind::Mesh:
    return meshInfo(file, o.selfIntersections, job);
  case FileKind::Scene:
    break;
  }
  return isShapeFile(file) ? shapeInfo(file, job) : sceneInfo(file, job);
}

/// "5 files: 3 meshes (2 closed), 1 volume, 1 not readable"
std::string summary(const Json& files) {
  std::string text;
  const auto count = [&](const char* key, const Json& value) {
    return std::count_if(files.begin(), files.end(), [&](const Json& f) { return f.contains(key) && f[key] == value; });
  };
  const auto add = [&](std::ptrdiff_t number, const char* one, const char* many, const std::string& detail = {}) {
    if (number > 0)
      text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", number, number == 1 ? one : many, detail);
  };
  add(count("kind", "mesh"), "mesh", "meshes", fmt::format(" ({} closed)", count("closed", true)));
  add(count("kind", "volume"), "volume", "volumes");
  add(count("kind", "image"), "image", "images");
  add(count("kind", "scene"), "scene", "scenes");
  add(count("kind", "shape"), "shape", "shapes");
  add(std::count_if(files.begin(), files.end(), [](const Json& f) { return f.contains("error"); }), "not readable",
      "not readable");
  return fmt::format("{} files: {}", files.size(), text);
}

int runInfo(const Info& o) {
  Job job("info", o.common);
  Json& files = job.report()["files"] = Json::array();
  for (const std::string& file : o.files) {
    job.addInput(file);
    Json entry{{"file", file}};
    if (!files.empty() && !job.json()) fmt::print("\n");
    job.attempt(entry, [&] { entry.update(infoOf(file, o, job)); });
    files.push_back(std::move(entry));
  }
  if (o.files.size() > 1 && !job.json()) fmt::print("\n{}\n", summary(files));
  job.finish();
  return job.status();
}

} // namespace

void addInfoCommand(CLI::App& app, Action& action) {
  addCommand<Info>(app, action, "info", "what is in volumes, images, meshes, scenes and shapes", declareInfo, runInfo);
}

} // namespace volcaustic::cli
