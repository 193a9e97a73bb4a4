// What a scene names and a session reads once: meshes, volumes, the background's map.
#pragma once

#include "scene/scene_meshes.h"
#include "volcaustic/background.h"
#include "volcaustic/medium_volume.h"
#include "volcaustic/scene.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace volcaustic {

/// When a file was last written; the earliest time where it cannot be asked.
std::filesystem::file_time_type writeTime(const std::filesystem::path& file);
inline std::int64_t timeTicks(const std::filesystem::path& file) { return writeTime(file).time_since_epoch().count(); }

/// The object's name, else that of its file or shape, for messages.
std::string nameOf(const SceneObject& object);

class SceneFiles {
public:
  struct LoadedMesh {
    std::filesystem::file_time_type time;
    std::uint64_t key = 0; ///< hash of its contents
    std::shared_ptr<const Mesh> mesh;
  };

  /// The mesh of an object or a receiver, in its own space; read again when the file has changed. A mesh in memory may
  /// change behind its pointer, so it is hashed afresh.
  template <class Holder>
  const LoadedMesh& mesh(const Holder& holder, SceneMeshReader& reader) {
    return holder.mesh ? inMemory(holder.mesh) : fromFile(holder.meshFile, reader);
  }

  /// The volumes of the scene's visible objects, placed. Only those of this scene are kept: they are large.
  std::vector<MediumVolume> volumes(const Scene& scene, const RunContext& ctx);

  /// The scene's background with its map.
  const Background& background(const Scene& scene, const RunContext& ctx);
  /// Of the map of the last background().
  [[nodiscard]] std::filesystem::file_time_type backgroundTime() const { return mBackgroundTime; }

  /// Forgets meshes that no call of mesh() has asked for since the last call.
  void dropUnused();

private:
  const LoadedMesh& inMemory(const std::shared_ptr<const Mesh>& mesh);
  const LoadedMesh& fromFile(const std::filesystem::path& file, SceneMeshReader& reader);

  struct LoadedVolume {
    std::filesystem::file_time_type time;
    std::vector<std::string> names;
    std::shared_ptr<const VolumeGrids> grids;
  };

  std::map<std::string, LoadedMesh> mMeshes; // as read, before placement
  std::map<std::string, int> mUses;          // of each since dropUnused()
  std::map<std::filesystem::path, LoadedVolume> mVolumes;
  Background mBackground;
  std::filesystem::file_time_type mBackgroundTime;
};

} // namespace volcaustic
