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

/// What tells a file from what it was before without reading it.
struct FileStamp {
  std::filesystem::path file;
  std::filesystem::file_time_type time; ///< of the last write; the earliest where it cannot be asked
  std::uintmax_t size = 0;
  bool operator==(const FileStamp&) const = default;
};
FileStamp stampOf(const std::filesystem::path& file);

/// The object's name, else that of its file or shape, for messages.
std::string nameOf(const SceneObject& object);

class SceneFiles {
public:
  /// \param hashContents keys of files are those of their contents, for keys that outlive the process; else of their
  /// stamps
  explicit SceneFiles(bool hashContents) : mHashContents(hashContents) {}

  struct LoadedMesh {
    std::vector<FileStamp> stamps; ///< of the files it is from
    std::uint64_t key = 0;         ///< hash of its contents
    std::shared_ptr<const Mesh> mesh;
  };

  /// The mesh of an object or a receiver, in its own space; read again when the file has changed. A mesh in memory may
  /// change behind its pointer, so it is hashed afresh.
  template <class Holder>
  const LoadedMesh& mesh(const Holder& holder, SceneMeshReader& reader) {
    return holder.mesh ? inMemory(holder.mesh) : fromFile(holder.meshFile, reader);
  }

  /// Of a volume or a map.
  std::uint64_t fileKey(const std::filesystem::path& file, const RunContext& ctx);

  /// The volumes of the scene's visible objects, placed. Only those of this scene are kept: they are large.
  std::vector<MediumVolume> volumes(const Scene& scene, const RunContext& ctx);

  /// The scene's background with its map.
  const Background& background(const Scene& scene, const RunContext& ctx);

  /// Forgets meshes that the scene does not name.
  void keepOnly(const Scene& scene);

private:
  const LoadedMesh& inMemory(const std::shared_ptr<const Mesh>& mesh);
  const LoadedMesh& fromFile(const std::filesystem::path& file, SceneMeshReader& reader);

  struct LoadedVolume {
    FileStamp stamp;
    std::vector<std::string> names;
    std::shared_ptr<const VolumeGrids> grids;
  };

  std::map<std::string, LoadedMesh> mMeshes; // as read, before placement
  std::map<std::filesystem::path, LoadedVolume> mVolumes;
  Background mBackground;
  FileStamp mBackgroundStamp;
  struct Contents {
    FileStamp stamp;
    std::uint64_t hash;
  };
  std::map<std::filesystem::path, Contents> mContents;
  bool mHashContents;
};

} // namespace volcaustic
