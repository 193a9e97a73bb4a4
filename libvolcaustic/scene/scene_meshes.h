// Meshes as the objects of a scene name them.
#pragma once

#include "scene/gltf_file.h"
#include "volcaustic/mesh.h"
#include "volcaustic/scene.h"

#include <filesystem>
#include <memory>
#include <vector>

namespace volcaustic {

/// Reads mesh after mesh; of a glTF file that holds many, JSON and buffers are read once.
class SceneMeshReader {
public:
  explicit SceneMeshReader(const RunContext& ctx) : mContext(ctx) {}

  /// \throws Error as readMesh, and Error(Input) for a reference into a glTF file that names no mesh there.
  Mesh read(const std::filesystem::path& reference);
  /// That the last read() took its mesh from.
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return mFiles; }

private:
  const RunContext& mContext;
  std::vector<std::filesystem::path> mFiles;
  std::filesystem::path mOpen;
  std::unique_ptr<GltfFile> mFile;
};

} // namespace volcaustic
