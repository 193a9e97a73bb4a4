// Blocks of surface put together: vertices numbered, faces with four corners around crossed edges, and their triangles.
#pragma once

#include "polygonise/block.h"
#include "volcaustic/mesh.h"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace volcaustic {

/// Corners of a face against the clock as seen from outside.
using Quad = std::array<std::uint32_t, 4>;

/// Faces and vertices stand in the order of blocks, those of a block in the order of its surface.
class QuadMesh {
public:
  /// \param surfaces of the blocks, which must outlive it. \throws Error(Input) for more vertices than indices
  QuadMesh(std::span<const SurfaceBlock> blocks, std::span<const std::shared_ptr<const BlockSurface>> surfaces,
           double cellSize, const RunContext& ctx);

  [[nodiscard]] std::size_t blockCount() const { return mBlocks.size(); }
  [[nodiscard]] const SurfaceBlock& block(std::size_t b) const { return mBlocks[b]; }
  [[nodiscard]] const BlockSurface& surface(std::size_t b) const { return *mSurfaces[b]; }
  [[nodiscard]] double cellSize() const { return mCellSize; }

  [[nodiscard]] std::size_t firstVertex(std::size_t b) const { return mFirstVertex[b]; }
  [[nodiscard]] std::size_t firstQuad(std::size_t b) const { return mFirstQuad[b]; }
  [[nodiscard]] std::size_t quadCount() const { return mQuads.size(); }
  [[nodiscard]] const Quad& quad(std::size_t q) const { return mQuads[q]; }
  [[nodiscard]] std::size_t blockOfQuad(std::size_t q) const;
  [[nodiscard]] const Crossing& crossing(std::size_t b, std::size_t q) const {
    return mSurfaces[b]->crossings[q - mFirstQuad[b]];
  }

  /// The two triangles of a face, cut along the diagonal that lies nearer to the surface, or where both lie close to
  /// it along the one that leaves the greater least angle.
  [[nodiscard]] std::array<std::array<std::uint32_t, 3>, 2> triangles(const Quad& quad, const Crossing& crossing) const;

  std::vector<Vec3d> positions; ///< of vertices

private:
  void connectBlock(std::size_t b);
  [[nodiscard]] std::size_t find(const Vec3i& coord) const;

  std::span<const SurfaceBlock> mBlocks;
  std::span<const std::shared_ptr<const BlockSurface>> mSurfaces;
  double mCellSize;
  std::vector<std::size_t> mFirstVertex, mFirstQuad; // of blocks, and the count after the last
  std::vector<Quad> mQuads;
};

} // namespace volcaustic
