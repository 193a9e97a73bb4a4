// The surface in one block of cells: a vertex for each patch, and a face for each crossed edge.
#pragma once

#include "polygonise/cell.h"
#include "polygonise/hierarchy.h"
#include "polygonise/vertex.h"

#include <array>
#include <cstdint>
#include <vector>

namespace volcaustic {

inline constexpr int kCellsOfBlock = kBlockCells * kBlockCells * kBlockCells;
constexpr int cellOfBlock(int x, int y, int z) { return x + kBlockCells * (y + kBlockCells * z); }

/// A face of the mesh to be: the four cells around a crossed edge of the lattice.
struct Crossing {
  std::uint16_t cell; ///< of the block, whose lowest corner the edge begins at
  std::uint8_t axis;  ///< of the edge
  bool outwards;      ///< whether it leaves the shape
  float slope;        ///< length of the gradient there; 0 where there is none
  Vec3f normal;       ///< along the gradient
  Vec3d position;
};

/// A cell of several patches: the patch of each edge.
struct ManyPatches {
  std::uint16_t cell;
  std::array<std::int8_t, kCellEdges> patch;
};

/// A cell and its ambiguous faces of one patch (facesOfOnePatch()).
struct PinchedCell {
  std::uint16_t cell;
  std::uint8_t inside, joined, faces;
};

/// Faces of a cell whose pieces of curve are paired the other way.
struct FlippedFaces {
  std::uint16_t cell;
  std::uint8_t faces;
  bool operator==(const FlippedFaces&) const = default;
};

struct BlockSurface {
  static constexpr std::uint16_t kNone = 0xffff;

  struct Stray {
    std::uint16_t vertex;
    Vec3d outside, within; ///< as of PatchVertex
  };

  std::vector<Vec3d> positions;
  std::vector<Stray> strays;                            ///< vertices that belong at an edge at their cell's border
  std::array<std::uint16_t, kCellsOfBlock> firstVertex; ///< of each cell, or kNone
  std::vector<ManyPatches> many;                        ///< in order of cells
  std::vector<Crossing> crossings;
  std::vector<PinchedCell> pinched;
  std::uint64_t evaluations = 0;

  /// The vertex of the patch that crosses an edge of a cell, or kNone.
  [[nodiscard]] std::uint16_t vertexAt(int cell, int edge) const;
};

/// Points of the lattice within blocks, by the program's values alone. For one thread.
class BlockSampler {
public:
  /// Evaluates a block's points.
  void sample(const SurfaceBlock& block, double cellSize);
  /// Faces of the block's part of the mesh.
  [[nodiscard]] std::size_t countCrossings() const;

  [[nodiscard]] bool isCrossed() const { return mCrossed; }
  [[nodiscard]] double value(int point) const { return mValues[point]; }
  /// Of the nine points of a row along x: bit x is set inside.
  [[nodiscard]] unsigned row(int y, int z) const { return mRows[y + kBlockPoints * z]; }
  [[nodiscard]] Vec3d point(int x, int y, int z) const { return {mPoints.x[x], mAxisY[y], mAxisZ[z]}; }
  [[nodiscard]] ShapeScratch& scratch() { return mScratch; }

  static constexpr int pointOfBlock(int x, int y, int z) { return x + kBlockPoints * (y + kBlockPoints * z); }
  static constexpr int kStep[3] = {1, kBlockPoints, kBlockPoints* kBlockPoints}; ///< to the next point along an axis
  static constexpr int kPoints = kBlockPoints * kBlockPoints * kBlockPoints;

private:
  ShapeScratch mScratch;
  PointArrays mPoints;
  std::array<double, kBlockPoints> mAxisY{}, mAxisZ{};
  std::vector<double> mValues;
  std::array<std::uint16_t, kBlockPoints * kBlockPoints> mRows{};
  bool mCrossed = false;
};

/// \param flipped in order of cells
BlockSurface blockSurface(const SurfaceBlock& block, double cellSize, const std::vector<FlippedFaces>& flipped,
                          BlockSampler& sampler);

} // namespace volcaustic
