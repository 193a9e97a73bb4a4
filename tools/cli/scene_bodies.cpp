#include "scene_bodies.h"

#include <volcaustic/error.h>
#include <volcaustic/session.h>

#include <charconv>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

/// A receiver without a mesh: a square of edge 1 around the origin.
std::shared_ptr<const Mesh> square() {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-.5, -.5, 0}, {.5, -.5, 0}, {.5, .5, 0}, {-.5, .5, 0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

SceneObject standIn(const SceneReceiver& receiver) {
  SceneObject object;
  object.meshFile = receiver.meshFile;
  object.mesh = receiver.mesh || !receiver.meshFile.empty() ? receiver.mesh : square();
  return object;
}

} // namespace

std::vector<SceneBody> sceneBodies(const Scene& scene, const RunContext& ctx) {
  std::vector<SceneBody> bodies;
  Scene sources; // their surfaces in their own space
  const auto add = [&](SceneObject source, const Placement& placement, std::string name) {
    bodies.push_back({.body = {.name = std::move(name), .mesh = {}, .placement = placement}});
    source.placement = {};
    source.material = sources.materials.front().name;
    source.groups.clear();
    sources.objects.push_back(std::move(source));
  };
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    if (!object.visible || !object.volumeFile.empty()) continue;
    add(object, object.placement, object.name.empty() ? fmt::format("objects.{}", i) : object.name);
    bodies.back().object = i;
  }
  for (std::size_t i = 0; i < scene.receivers.size(); ++i) {
    const SceneReceiver& receiver = scene.receivers[i];
    add(standIn(receiver), receiver.placement, receiver.name.empty() ? fmt::format("receivers.{}", i) : receiver.name);
    bodies.back().receiver = bodies.back().body.fixed = true;
  }
  Session session(std::move(sources), ctx);
  for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].body.mesh = session.surface(i);
  return bodies;
}

std::size_t bodyNamed(const char* flag, const std::string& name, std::span<const SceneBody> bodies) {
  std::string names;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].body.name == name) return i;
    names += (i == 0 ? "" : ", ") + bodies[i].body.name;
  }
  throw Error(ErrorKind::Usage,
              fmt::format("{} {}: no body has that name; there are {}", flag, name, names.empty() ? "none" : names));
}

NamedNumbers namedNumbers(const char* flag, const std::string& text, std::size_t count,
                          std::span<const SceneBody> bodies) {
  const std::size_t equals = text.rfind('=');
  const auto wrong = [&] {
    return Error(ErrorKind::Usage,
                 fmt::format("{} {}: write it as NAME={}", flag, text, count == 3 ? "X,Y,Z" : "NUMBER"));
  };
  if (equals == std::string::npos) throw wrong();
  NamedNumbers result{bodyNamed(flag, text.substr(0, equals), bodies), {}};
  const char* at = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  while (true) {
    double number = 0;
    const auto [stop, error] = std::from_chars(at, end, number);
    if (error != std::errc()) throw wrong();
    result.numbers.push_back(number);
    if (stop == end) break;
    if (*stop != ',') throw wrong();
    at = stop + 1;
  }
  if (result.numbers.size() != count) throw wrong();
  return result;
}

} // namespace volcaustic::cli
