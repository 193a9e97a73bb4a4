// scene mesh: the triangles of a scene's objects as they stand in the world, deformed, frame by frame.
#include "common.h"
#include "file_kind.h"
#include "frames.h"
#include "scene_input.h"

#include <volcaustic/mesh.h>
#include <volcaustic/session.h>

#include <filesystem>
#include <fmt/format.h>
#include <optional>

namespace volcaustic::cli {

namespace {

struct SceneMesh {
  CommonOptions common;
  std::string scene, output, object, frames;
  SceneFlags flags;
  bool resume = false;
};

void declareSceneMesh(CLI::App& command, SceneMesh& o) {
  command.add_option("SCENE", o.scene, "scene file (.json, .gltf, .glb), or - for JSON on standard input")->required();
  command.add_option("-o,--output", o.output, "mesh of all objects, each a group: .obj, .ply, .stl or .off")
      ->required();
  command.add_option("--object", o.object, "the object of this name alone");
  addSceneFlags(command, o.flags, true);
  command.add_option("--frames", o.frames, "A-B[xS]: one file a frame, its number in the place of #### or %04d in OUT");
  command.add_flag("--resume", o.resume, "skip frames whose files are there");
}

std::string nameOf(const Scene& scene, std::size_t i) {
  return scene.objects[i].name.empty() ? fmt::format("object{}", i) : scene.objects[i].name;
}

/// Adds the triangles of object `i` as a group.
void append(Mesh& mesh, const Mesh& part, const std::string& group) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  for (const auto& t : part.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  mesh.triangleGroup.resize(mesh.triangles.size(), static_cast<std::uint32_t>(mesh.groupNames.size()));
  mesh.groupNames.push_back(group);
}

Mesh meshOf(Session& session, const SceneMesh& o) {
  Mesh mesh;
  const Scene& scene = session.scene();
  bool known = o.object.empty();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    known |= object.name == o.object;
    if (!object.visible || !object.volumeFile.empty() || (!o.object.empty() && object.name != o.object)) continue;
    append(mesh, *session.surface(i), nameOf(scene, i));
  }
  if (!known) throw Error(ErrorKind::Usage, "--object " + o.object + ": no object of the scene is called so");
  if (mesh.empty())
    throw Error(ErrorKind::Input, o.scene + ":/objects: none of them that is visible has a surface; volumes have none");
  return mesh;
}

int runSceneMesh(const SceneMesh& o) {
  Job job("scene mesh", o.common);
  checkOutput(o.output, FileKind::Mesh);
  job.addInput(o.scene);
  if (o.frames.empty() && hasFramePlace(o.output))
    throw Error(ErrorKind::Usage, "--output " + o.output + ": has a place for a frame number; give --frames");
  std::optional<Session> session;
  for (const int frame : o.frames.empty() ? std::vector<int>{1} : parseFrames(o.frames)) {
    const std::string output = o.frames.empty() ? o.output : withFrame(framePattern(o.output), frame);
    job.addOutput(output);
    if (job.skips(o.resume, output)) continue;
    Scene scene = readSceneArgument(o.scene, o.flags.at(frame), session ? withoutWords(job.context()) : job.context());
    if (session)
      session->setScene(std::move(scene));
    else
      session.emplace(std::move(scene), job.context());
    const Mesh mesh = meshOf(*session, o);
    warnOfSelfIntersections(job, *session);
    job.timed("write", [&] { writeMesh(output, mesh, {}, job.context()); });
    job.console().say(fmt::format("{}: {} triangles", output, mesh.triangles.size()));
  }
  if (session) job.addStages(session->runs());
  job.finish();
  return 0;
}

} // namespace

void warnOfSelfIntersections(Job& job, Session& session) {
  const Scene& scene = session.scene();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    if (!object.visible || object.deform.empty() || object.topology.topology != Topology::Free) continue;
    const SelfIntersections found = findSelfIntersections(*session.surface(i), job.context());
    if (!found.any()) continue;
    job.context().warn(
        fmt::format("objects ({}): runs through itself in {} pairs of triangles, within ({:.4g}, {:.4g}, "
                    "{:.4g}) to ({:.4g}, {:.4g}, {:.4g}); set its topology to keep, merge or split",
                    nameOf(scene, i), found.pairs, found.bounds.min[0], found.bounds.min[1], found.bounds.min[2],
                    found.bounds.max[0], found.bounds.max[1], found.bounds.max[2]));
  }
}

void addSceneMeshCommand(CLI::App& scene, Action& action) {
  addCommand<SceneMesh>(scene, action, "mesh", "write the objects' triangles, deformed and placed", declareSceneMesh,
                        runSceneMesh);
}

} // namespace volcaustic::cli
