// n and its gradient for the kernels, brick by brick: docs/algorithms/step_field.md, "Field" and "Bends".
#pragma once

#include "kernels/flat_medium.h"
#include "volume/brick_block.h"

#include <array>
#include <cstdint>
#include <span>

namespace volcaustic {

/// Turns the samples of n in and around one brick at a time into what trilinear interpolation should be given. Beyond
/// the domain's faces n goes on as it came, so that a gradient across the box stays what it is up to the face. One for
/// each thread: it owns the buffers.
class IndexField {
public:
  void gather(const BrickGrid<float>& index, const Vec3i& brick) {
    mInside = Block::isInside(index, brick);
    mBlock.gatherExtended(index, brick);
  }

  // Of the brick gathered last:

  /// Whether all that was gathered is in the domain.
  [[nodiscard]] bool inside() const { return mInside; }
  /// The voxel before the brick's first one along each axis; rows along z are kRow numbers apart, planes kPlane.
  [[nodiscard]] const float* around() const { return mBlock.data() + Block::place(-1, -1, -1); }
  /// Whether n is one value as far as the filter reaches.
  [[nodiscard]] bool flat() const;
  /// The kFieldVoxels entries of the brick's slot.
  void filter(kernels::FieldVoxel* out);
  /// For each voxel, whether a trilinear lookup inside it can see a gradient: 0 or kernels::kStepBendsBit.
  void findBends(std::span<std::uint8_t, kBrickVoxels> bends);

private:
  using Block = BrickBlock<float, 3, 4>; ///< the filter's reach, and one more layer of entries on the high sides

public:
  static constexpr int kRow = Block::kRow, kPlane = Block::kPlane;

private:
  static constexpr int kEdge = kernels::kFieldEdge;
  static constexpr int kReach = 10; ///< voxels along an axis that lookups inside the brick touch: -1 to 8

  /// Samples filtered along x, and along x and y; each letter is what was done along an axis, V value, S slope.
  struct Partial {
    std::array<float, kEdge * Block::kPlane> v, s;
    std::array<float, kEdge * kEdge * Block::kRow + Block::kRow> vv, vs, sv;
    std::array<float, kEdge * kEdge * Block::kRow> vvv, vvs, vsv, svv;
    std::array<std::uint8_t, kReach * kReach * Block::kRow + Block::kRow> curved, alongZ, alongY;
  };

  Block mBlock;
  bool mInside = false;
  Partial mPartial{};
};

} // namespace volcaustic
