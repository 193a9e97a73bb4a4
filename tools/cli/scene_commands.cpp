// scene check, schema and new.
#include "common.h"
#include "scene_input.h"

#include <volcaustic/scene.h>
#include <volcaustic/shape_file.h>

#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <iterator>

namespace volcaustic::cli {

void addSceneFlags(CLI::App& command, SceneFlags& flags, bool hasFrames) {
  command.add_option("--set", flags.sets, "set any option of a scene first, as photons.grid=[512,512]; again for more")
      ->allow_extra_args(false);
  if (hasFrames)
    command
        .add_option("--fps", flags.framesPerSecond,
                    "frames a second of a glTF file's animation, whose frame N is at N/fps seconds; 24 if not given")
        ->check(CLI::Range(0.001, 1e6));
}

RunContext withoutWords(RunContext ctx) {
  ctx.onLog = nullptr;
  return ctx;
}

Scene readSceneArgument(const std::string& path, const SceneReadOptions& options, const RunContext& ctx) {
  if (path != "-") return readScene(path, options, ctx);
  // Frames read the scene again; standard input can be read once.
  static const std::string text{std::istreambuf_iterator<char>(std::cin), {}};
  return parseScene(text, "<stdin>", options);
}

namespace {

/// \throws Error(File) at the pointer of the first file of a scene that is not there.
void checkFiles(const Scene& scene, const std::string& name) {
  const auto check = [&](const std::filesystem::path& file, const std::string& pointer) {
    std::error_code ignored;
    if (!file.empty() && !std::filesystem::is_regular_file(sceneMeshFile(file), ignored))
      throw Error(ErrorKind::File,
                  name + ":" + pointer + ": no such file: " + file.string() + "; paths start at the scene file");
  };
  check(scene.volume.file, "/volume/file");
  check(scene.background.file, "/background/file");
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    check(scene.objects[i].meshFile, fmt::format("/objects/{}/mesh", i));
    check(scene.objects[i].volumeFile, fmt::format("/objects/{}/volume", i));
  }
}

struct SceneCheck {
  CommonOptions common;
  std::vector<std::string> files;
  SceneFlags flags;
};

void declareCheck(CLI::App& command, SceneCheck& o) {
  command.add_option("FILE", o.files, "scene files (.json, .gltf, .glb), or - for JSON on standard input")->required();
  addSceneFlags(command, o.flags, false);
}

int runCheck(const SceneCheck& o) {
  Job job("scene check", o.common);
  for (const std::string& file : o.files) {
    const Scene scene = readSceneArgument(file, o.flags.at(1), job.context());
    for (int frame = scene.frames.first; frame <= scene.frames.last; ++frame) {
      job.context().throwIfCancelled();
      checkFiles(readSceneArgument(file, o.flags.at(frame), withoutWords(job.context())), file);
    }
    job.addInput(file);
    job.report()["sceneHashes"].push_back(sceneHash(scene));
    job.console().say(fmt::format("{}: good; {} objects, {} materials, {} lights", file, scene.objects.size(),
                                  scene.materials.size(), scene.lights.size()));
  }
  job.finish();
  return 0;
}

struct SceneSchema {
  bool ofShapes = false;
};

void declareSchema(CLI::App& command, SceneSchema& o) {
  command.add_flag("--shape", o.ofShapes, "of shape files in place of scenes");
}

int runSchema(const SceneSchema& o) {
  std::fputs((o.ofShapes ? shapeSchema() : sceneSchema()).c_str(), stdout);
  return 0;
}

struct SceneNew {
  std::string mesh;
};

void declareNew(CLI::App& command, SceneNew& o) {
  command.add_option("--mesh", o.mesh, "mesh to name in the scene, relative to where it will be saved");
}

int runNew(const SceneNew& o) {
  std::string text = sceneTemplate();
  if (!o.mesh.empty()) {
    const std::string placeholder = "\"mesh\": " + Json(parseScene(text, "").objects.front().meshFile.string()).dump();
    text.replace(text.find(placeholder), placeholder.size(), "\"mesh\": " + Json(o.mesh).dump());
  }
  std::fputs(text.c_str(), stdout);
  return 0;
}

} // namespace

void addSceneCommands(CLI::App& app, Action& action) {
  CLI::App* scene =
      app.add_subcommand("scene", "check scene files, write their meshes, print their JSON Schema, start a new one");
  scene->require_subcommand(1);
  addCommand<SceneCheck>(*scene, action, "check", "validate scene files and the files they name, in every frame",
                         declareCheck, runCheck);
  addCommand<SceneSchema>(*scene, action, "schema", "print the JSON Schema of scene files, or of shape files",
                          declareSchema, runSchema);
  addSceneMeshCommand(*scene, action);
  addCommand<SceneNew>(*scene, action, "new", "print a commented scene to start from", declareNew, runNew);
}

} // namespace volcaustic::cli
