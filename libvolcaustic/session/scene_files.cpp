#include "session/scene_files.h"

#include "core/hash.h"
#include "core/xxhash64.h"
#include "volcaustic/shape_fields.h"

#include <algorithm>
#include <fstream>
#include <set>
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

std::string memoryName(const Mesh* mesh) { return "memory:" + std::to_string(reinterpret_cast<std::uintptr_t>(mesh)); }

bool areAsRead(const std::vector<FileStamp>& stamps) {
  return std::all_of(stamps.begin(), stamps.end(), [](const FileStamp& s) { return s == stampOf(s.file); });
}

/// 0 of a file that cannot be read: whoever needs it says so.
std::uint64_t hashOfFile(const std::filesystem::path& path, const RunContext& ctx) {
  std::ifstream file(path, std::ios::binary);
  XxHash64 hash;
  for (std::vector<char> piece(4 << 20); file; ctx.throwIfCancelled()) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    hash.add(piece.data(), static_cast<std::size_t>(file.gcount()));
  }
  return file.eof() ? hash.digest() : 0;
}

} // namespace

FileStamp stampOf(const std::filesystem::path& file) {
  std::error_code ignored;
  return {file, std::filesystem::last_write_time(file, ignored), std::filesystem::file_size(file, ignored)};
}

std::string nameOf(const SceneObject& object) {
  if (!object.name.empty()) return object.name;
  if (!object.shape.empty())
    return !object.shape.node().name.empty() ? object.shape.node().name : kShapeTypes[object.shape.node().kind.index()];
  return (object.volumeFile.empty() ? object.meshFile : object.volumeFile).filename().string();
}

const SceneFiles::LoadedMesh& SceneFiles::inMemory(const std::shared_ptr<const Mesh>& mesh) {
  LoadedMesh& entry = mMeshes[memoryName(mesh.get())];
  entry = {{}, contentOf(*mesh), mesh};
  return entry;
}

const SceneFiles::LoadedMesh& SceneFiles::fromFile(const std::filesystem::path& file, SceneMeshReader& reader) {
  LoadedMesh& entry = mMeshes[file.string()];
  if (entry.mesh && areAsRead(entry.stamps)) return entry;
  std::vector<FileStamp> stamps{stampOf(sceneMeshFile(file))}; // before it is read: what is written meanwhile is newer
  auto mesh = std::make_shared<const Mesh>(reader.read(file));
  for (const std::filesystem::path& from : reader.files())
    if (from != stamps.front().file) stamps.push_back(stampOf(from));
  const std::uint64_t key = contentOf(*mesh);
  entry = {std::move(stamps), key, std::move(mesh)};
  return entry;
}

std::uint64_t SceneFiles::fileKey(const std::filesystem::path& file, const RunContext& ctx) {
  const FileStamp stamp = stampOf(file);
  if (!mHashContents)
    return Hash().text(file.string()).value(stamp.time.time_since_epoch().count()).value(stamp.size).digest();
  const auto known = mContents.find(file);
  if (known != mContents.end() && known->second.stamp == stamp) return known->second.hash;
  return mContents.insert_or_assign(file, Contents{stamp, hashOfFile(file, ctx)}).first->second.hash;
}

void SceneFiles::keepOnly(const Scene& scene) {
  std::set<std::string> named;
  const auto name = [&](const auto& holder) {
    named.insert(holder.mesh ? memoryName(holder.mesh.get()) : holder.meshFile.string());
  };
  std::for_each(scene.objects.begin(), scene.objects.end(), name);
  std::for_each(scene.receivers.begin(), scene.receivers.end(), name);
  std::erase_if(mMeshes, [&](const auto& entry) { return !named.contains(entry.first); });
}

std::vector<MediumVolume> SceneFiles::volumes(const Scene& scene, const RunContext& ctx) {
  std::map<std::filesystem::path, LoadedVolume> before = std::exchange(mVolumes, {});
  for (const SceneObject& o : scene.objects)
    if (o.visible && !o.volumeFile.empty())
      for (const PropertyGrid& p : o.grids) mVolumes[o.volumeFile].names.push_back(p.mapping.grid);
  for (auto& [file, loaded] : mVolumes) {
    loaded.stamp = stampOf(file);
    const auto old = before.find(file);
    if (old != before.end() && old->second.stamp == loaded.stamp && old->second.names == loaded.names)
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
  const std::shared_ptr<const Image> imageBefore = std::exchange(b.image, nullptr);
  b = scene.background;
  if (b.image || b.file.empty()) return b;
  FileStamp stamp = stampOf(b.file);
  b.image = imageBefore && mBackgroundStamp == stamp ? imageBefore : readEnvironment(b.file, ctx);
  mBackgroundStamp = std::move(stamp);
  return b;
}

} // namespace volcaustic
