#include "session/scene_files.h"

#include "core/xxhash64.h"
#include "volcaustic/shape_fields.h"

#include <system_error>
#include <utility>

namespace volcaustic {

namespace {

template <class T>
void addVector(XxHash64& hash, const std::vector<T>& v) {
  const std::size_t size = v.size();
  hash.add(&size, sizeof size);
  hash.add(v.data(), size * sizeof(T));
}

std::uint64_t contentOf(const Mesh& mesh) {
  XxHash64 hash;
  addVector(hash, mesh.positions);
  addVector(hash, mesh.triangles);
  addVector(hash, mesh.triangleGroup);
  for (const std::string& name : mesh.groupNames) {
    const std::size_t size = name.size();
    hash.add(&size, sizeof size);
    hash.add(name.data(), size);
  }
  return hash.digest();
}

} // namespace

std::filesystem::file_time_type writeTime(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::last_write_time(file, ignored);
}

std::string nameOf(const SceneObject& object) {
  if (!object.name.empty()) return object.name;
  if (!object.shape.empty())
    return !object.shape.node().name.empty() ? object.shape.node().name : kShapeTypes[object.shape.node().kind.index()];
  return (object.volumeFile.empty() ? object.meshFile : object.volumeFile).filename().string();
}

const SceneFiles::LoadedMesh& SceneFiles::inMemory(const std::shared_ptr<const Mesh>& mesh) {
  const std::string name = "memory:" + std::to_string(reinterpret_cast<std::uintptr_t>(mesh.get()));
  ++mUses[name];
  LoadedMesh& entry = mMeshes[name];
  entry = {{}, contentOf(*mesh), mesh};
  return entry;
}

const SceneFiles::LoadedMesh& SceneFiles::fromFile(const std::filesystem::path& file, SceneMeshReader& reader) {
  const auto time = writeTime(sceneMeshFile(file));
  ++mUses[file.string()];
  LoadedMesh& entry = mMeshes[file.string()];
  if (!entry.mesh || entry.time != time) {
    auto mesh = std::make_shared<const Mesh>(reader.read(file));
    const std::uint64_t key = contentOf(*mesh);
    entry = {time, key, std::move(mesh)};
  }
  return entry;
}

void SceneFiles::dropUnused() {
  std::erase_if(mMeshes, [&](const auto& entry) { return !mUses.contains(entry.first); });
  mUses.clear();
}

std::vector<MediumVolume> SceneFiles::volumes(const Scene& scene, const RunContext& ctx) {
  std::map<std::filesystem::path, LoadedVolume> before = std::exchange(mVolumes, {});
  for (const SceneObject& o : scene.objects)
    if (o.visible && !o.volumeFile.empty())
      for (const PropertyGrid& p : o.grids) mVolumes[o.volumeFile].names.push_back(p.mapping.grid);
  for (auto& [file, loaded] : mVolumes) {
    loaded.time = writeTime(file);
    const auto old = before.find(file);
    if (old != before.end() && old->second.time == loaded.time && old->second.names == loaded.names)
      loaded.grids = std::move(old->second.grids);
  }
  before.clear(); // before the new ones take memory
  for (auto& [file, loaded] : mVolumes)
    if (!loaded.grids) loaded.grids = readVolumeGrids(file, loaded.names, ctx);

  std::vector<MediumVolume> placed;
  for (const SceneObject& o : scene.objects)
    if (o.visible && !o.volumeFile.empty())
      placed.push_back({mVolumes[o.volumeFile].grids, o.grids, affine(o.placement), "objects (" + nameOf(o) + ")"});
  return placed;
}

const Background& SceneFiles::background(const Scene& scene, const RunContext& ctx) {
  Background& b = mBackground;
  const std::filesystem::path fileBefore = std::exchange(b.file, {});
  const std::shared_ptr<const Image> imageBefore = std::exchange(b.image, nullptr);
  b = scene.background;
  if (b.image || b.file.empty()) return b;
  const auto time = writeTime(b.file);
  const bool known = imageBefore && fileBefore == b.file && mBackgroundTime == time;
  b.image = known ? imageBefore : readEnvironment(b.file, ctx);
  mBackgroundTime = time;
  return b;
}

} // namespace volcaustic
