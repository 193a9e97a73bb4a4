#include "mesh/mesh_builder.h"

namespace volcaustic {

template <class T>
void MeshBuilder::makeRoom(std::vector<T>& values, std::size_t capacity) {
  mCtx.throwIfCancelled();
  const std::uint64_t held = mMesh.positions.capacity() * sizeof(Vec3d) +
                             mMesh.triangles.capacity() * sizeof(mMesh.triangles[0]) +
                             mMesh.triangleGroup.capacity() * sizeof(std::uint32_t);
  mCtx.requireMemory(mSource.content.size() + held + std::uint64_t{capacity} * sizeof(T), mSource.name);
  values.reserve(capacity);
}

template void MeshBuilder::makeRoom(std::vector<Vec3d>&, std::size_t);
template void MeshBuilder::makeRoom(std::vector<std::array<std::uint32_t, 3>>&, std::size_t);
template void MeshBuilder::makeRoom(std::vector<std::uint32_t>&, std::size_t);

void MeshBuilder::reserve(std::uint64_t positions, std::uint64_t triangles) {
  makeRoom(mMesh.positions, positions);
  makeRoom(mMesh.triangles, triangles);
}

bool MeshBuilder::addPolygon(std::span<const std::uint32_t> corners) {
  if (corners.size() == 3) {
    addTriangle(corners[0], corners[1], corners[2]);
    return true;
  }
  mCorners.clear();
  for (const std::uint32_t c : corners) mCorners.push_back(mMesh.positions[c]);
  const auto triangles = mTriangulator.triangulate(mCorners);
  for (const auto& [a, b, c] : triangles) addTriangle(corners[a], corners[b], corners[c]);
  return !triangles.empty();
}

std::uint32_t MeshBuilder::addGroup(std::string name) {
  if (mMesh.groupNames.empty() && !mMesh.triangles.empty()) {
    mMesh.groupNames.emplace_back();
    makeRoom(mMesh.triangleGroup, mMesh.triangles.capacity());
    mMesh.triangleGroup.assign(mMesh.triangles.size(), 0);
  }
  mMesh.groupNames.push_back(std::move(name));
  mGroup = static_cast<std::uint32_t>(mMesh.groupNames.size() - 1);
  return mGroup;
}

} // namespace volcaustic
