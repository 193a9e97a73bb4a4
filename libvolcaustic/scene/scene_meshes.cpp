#include "scene/scene_meshes.h"

#include "scene/gltf_mesh.h"
#include "volcaustic/error.h"

namespace volcaustic {

namespace {

/// Where the '#' of "x.glb#/meshes/0" is, or the end of a plain file name.
std::size_t fragmentOf(const std::string& reference) {
  const std::size_t mark = reference.rfind("#/");
  return mark != std::string::npos && isGltfName(reference.substr(0, mark)) ? mark : reference.size();
}

} // namespace

std::filesystem::path sceneMeshFile(const std::filesystem::path& reference) {
  const std::string text = reference.string();
  return text.substr(0, fragmentOf(text));
}

Mesh SceneMeshReader::read(const std::filesystem::path& reference) {
  const std::string text = reference.string();
  const std::filesystem::path path = text.substr(0, fragmentOf(text));
  mFiles.assign(1, path);
  if (!isGltfName(path)) return readMesh(path, mContext);
  if (path == reference)
    throw Error(ErrorKind::Input, text + ": say which mesh of the file it is, as " + text + "#/meshes/0");
  if (!mFile || mOpen != path) {
    mFile.reset(); // before the next one takes memory
    mFile = std::make_unique<GltfFile>(path, mContext);
    mOpen = path;
  }
  mFiles = mFile->files();
  return readGltfFragment(*mFile, std::string_view(text).substr(path.string().size() + 1));
}

} // namespace volcaustic
