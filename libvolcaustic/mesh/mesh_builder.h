// Collects what a reader finds into a Mesh, within the memory limit and with polygons split into triangles.
#pragma once

#include "mesh/source.h"
#include "mesh/triangulate.h"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

class MeshBuilder {
public:
  MeshBuilder(const MeshSource& source, const RunContext& ctx) : mSource(source), mCtx(ctx) {}

  /// Announces counts that the file's size has been found to bear out.
  void reserve(std::uint64_t positions, std::uint64_t triangles);

  void addPosition(const Vec3d& p) {
    if (mMesh.positions.size() == mMesh.positions.capacity()) grow(mMesh.positions);
    mMesh.positions.push_back(p);
  }
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (mMesh.triangles.size() == mMesh.triangles.capacity()) grow(mMesh.triangles);
    mMesh.triangles.push_back({a, b, c});
    if (mMesh.groupNames.empty()) return;
    if (mMesh.triangleGroup.size() == mMesh.triangleGroup.capacity()) grow(mMesh.triangleGroup);
    mMesh.triangleGroup.push_back(mGroup);
  }
  /// A face of three or more corners, each the index of a position added before. False when it is beyond
  /// kMaxConcaveCorners.
  [[nodiscard]] bool addPolygon(std::span<const std::uint32_t> corners);
  /// Triangles added from here on belong to a new group; those before the first group to an unnamed one.
  std::uint32_t addGroup(std::string name);
  void setGroup(std::uint32_t group) { mGroup = group; }

  /// Takes the positions that a welder collected in place of added ones.
  void setPositions(std::vector<Vec3d> positions) { mMesh.positions = std::move(positions); }

  [[nodiscard]] std::size_t positionCount() const { return mMesh.positions.size(); }
  [[nodiscard]] std::size_t triangleCount() const { return mMesh.triangles.size(); }
  [[nodiscard]] Mesh take() { return std::move(mMesh); }

private:
  template <class T>
  void grow(std::vector<T>& values) {
    if (values.size() >= kMaxElements) mSource.fail("has more than 4294967295 vertices or triangles; split the mesh");
    makeRoom(values, std::clamp<std::size_t>(2 * values.capacity(), 1024, kMaxElements));
  }
  template <class T>
  void makeRoom(std::vector<T>& values, std::size_t capacity);

  static constexpr std::size_t kMaxElements = 0xffffffffu; // indices have 32 bits

  const MeshSource& mSource;
  const RunContext& mCtx;
  Mesh mMesh;
  std::uint32_t mGroup = 0;
  PolygonTriangulator mTriangulator;
  std::vector<Vec3d> mCorners;
};

} // namespace volcaustic
