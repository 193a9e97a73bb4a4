#include "simulated_scene.h"

#include <volcaustic/error.h>

#include <fmt/format.h>
#include <fstream>
#include <iterator>

namespace volcaustic::cli {

namespace {

Json parsed(const std::filesystem::path& path, const Scene& scene) {
  std::string text;
  if (isGltfName(path)) {
    text = sceneToJson(scene);
  } else {
    std::ifstream file(path, std::ios::binary);
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  try {
    return Json::parse(text, nullptr, true, true);
  } catch (const Json::exception& error) {
    throw Error(ErrorKind::Input, path.string() + ": " + error.what() + "; `volcaustic scene check` says more");
  }
}

/// Makes relative paths lead to the same files from another folder.
class Rebase {
public:
  Rebase(const std::filesystem::path& from, const std::filesystem::path& to) : mFrom(folder(from)), mTo(folder(to)) {}

  void operator()(Json& scene) const {
    for (const char* section : {"volume", "background"})
      if (scene.contains(section)) path(scene[section], "file");
    if (scene.contains("shapes")) shape(scene["shapes"]);
    for (const char* section : {"objects", "receivers"}) {
      if (!scene.contains(section)) continue;
      for (Json& entry : scene[section]) {
        path(entry, "mesh");
        path(entry, "volume");
        path(entry, "shape"); // a file's name, or
        if (entry.contains("shape")) shape(entry["shape"]);
      }
    }
  }

private:
  static std::filesystem::path folder(const std::filesystem::path& file) {
    return std::filesystem::absolute(file).lexically_normal().parent_path();
  }

  void path(Json& owner, const char* key) const {
    if (!owner.is_object() || !owner.contains(key) || !owner[key].is_string()) return;
    const std::filesystem::path old = owner[key].get<std::string>();
    if (old.empty() || old.is_absolute()) return;
    owner[key] = (mFrom / old).lexically_normal().lexically_relative(mTo).string();
  }

  /// Shapes stand inside shapes, and any of them may be in a file.
  void shape(Json& node) const {
    path(node, "file");
    if (node.is_structured())
      for (Json& part : node) shape(part);
  }

  std::filesystem::path mFrom, mTo;
};

/// Of `place` as a whole and of its numbers one by one.
void removeTracks(Json& scene, const std::string& place) {
  if (!scene.contains("animation")) return;
  Json& tracks = scene["animation"];
  for (auto track = tracks.begin(); track != tracks.end();)
    track = track.key().starts_with(place) ? tracks.erase(track) : std::next(track);
}

Json track(std::span<const int> frames, std::span<const Placement> placements, Vec3d Placement::*member) {
  Json keys = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) keys.push_back({frames[i], placements[i].*member});
  return keys;
}

} // namespace

Json withKeys(const std::filesystem::path& from, const Scene& scene, const std::filesystem::path& to,
              std::span<const int> frames, double rate, std::span<const ObjectKeys> keys) {
  Json json = parsed(from, scene);
  Rebase(from, to)(json);
  for (const ObjectKeys& object : keys) {
    const std::string place = fmt::format("/objects/{}/", object.object);
    removeTracks(json, place + "translate");
    removeTracks(json, place + "rotate");
    json["animation"][place + "translate"] = track(frames, object.placements, &Placement::translate);
    json["animation"][place + "rotate"] = track(frames, object.placements, &Placement::rotate);
  }
  json["frames"] = {{"first", frames.front()}, {"last", frames.back()}, {"rate", rate}};
  return json;
}

} // namespace volcaustic::cli
