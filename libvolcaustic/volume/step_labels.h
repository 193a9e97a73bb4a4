// Labels of the step field: for every voxel the largest aligned cube of 2^m voxels in which n and attenuation hardly
// change (Vyatkin and Dolgovesov, "Volume-oriented visualization of caustics ...", section 2). Held as an octree whose
// memory goes by what varies; docs/algorithms/step_field.md.
#pragma once

#include "core/brick_grid.h"
#include "core/large_memory.h"
#include "kernels/flattening.h"
#include "volcaustic/medium.h"
#include "volume/index_field.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace volcaustic {

/// A label as a step byte has it: level m, and kernels::kStepCappedBit where steps are capped.
using StepLabel = kernels::CubeLabel;

/// \throws Error(Usage) for tolerances in the wrong order.
void requireTolerances(const StepFieldOptions& options);

class StepLabels {
public:
  /// Called once for each brick of the band, from several threads: its place in the band, the brick, the greatest minus
  /// the least n in it and one voxel around it, and n in its surroundings, gathered; null where n is one value there.
  using Visit = std::function<void(std::size_t i, std::int64_t brick, float range, IndexField* field)>;

  /// Both grids over the same domain; without one of attenuation its range stays within the tolerance everywhere. One
  /// pass over the bricks in or beside which something varies labels them and visits them.
  /// \throws as requireTolerances()
  StepLabels(const BrickGrid<float>& index, const BrickGrid<Vec3f>* attenuation, double voxelSize,
             const StepFieldOptions& options, const RunContext& ctx, const Visit& visit = {});

  /// A cube of whole bricks under one label, clipped to the domain.
  struct Cube {
    Vec3i first, last; ///< bricks, both inclusive
    StepLabel label;
    [[nodiscard]] std::int64_t brickCount() const {
      return std::int64_t{last[0] - first[0] + 1} * (last[1] - first[1] + 1) * (last[2] - first[2] + 1);
    }
  };
  /// The largest ones; with mixedBricks() they fill the domain.
  [[nodiscard]] const std::vector<Cube>& cubes() const { return mCubes; }
  /// Bricks that need labels for their voxels, in order.
  [[nodiscard]] const std::vector<std::int64_t>& mixedBricks() const { return mMixed; }
  /// Bricks in or beside which n or attenuation is not the background, in order. Of all others n and attenuation are
  /// the backgrounds, one voxel around them too.
  [[nodiscard]] const std::vector<std::int64_t>& band() const { return mBand; }

  static constexpr StepLabel kMixed = kernels::kMixedLabel;
  /// The label of a whole brick, or kMixed.
  [[nodiscard]] StepLabel ofBrick(const Vec3i& brick) const;
  /// The labels of a mixed brick's voxels; 0 beyond the domain.
  void ofVoxels(const Vec3i& brick, std::span<StepLabel, kBrickVoxels> labels) const;

private:
  static constexpr int kCells = 4; ///< of 2^3 voxels along a brick's edge
  using Cells = std::array<StepLabel, kCells * kCells * kCells>;

  using Range = kernels::CubeRange;
  class Ranges;

  /// The cubes of one size that hold a brick of the band, in arrays by slot - 1.
  struct Level {
    Vec3i dims;                      ///< cubes of the domain
    ZeroedTable<std::int32_t> slots; ///< 1 and up; 0: only background
    LargeVector<Vec3i> coords;
    LargeVector<Range> ranges;
    LargeVector<StepLabel> labels; ///< kMixed where finer ones are needed

    explicit Level(const Vec3i& cubes) : dims(cubes), slots(std::size_t(cubes[0]) * cubes[1] * cubes[2]) {}
    void resize(std::size_t count) {
      coords.resize(count);
      ranges.resize(count);
      labels.resize(count);
    }
    [[nodiscard]] std::size_t cubeCount() const { return slots.size(); }
    [[nodiscard]] std::size_t place(const Vec3i& c) const {
      return (std::size_t(c[0]) * dims[1] + c[1]) * dims[2] + c[2];
    }
  };

  [[nodiscard]] StepLabel classify(const Range& r, int level) const { return r.label(mRules, level); }
  void labelBand(const BrickGrid<float>& index, const BrickGrid<Vec3f>* attenuation, const RunContext& ctx,
                 const Visit& visit);
  void labelCells(const Ranges& ranges, Cells& labels) const;
  [[nodiscard]] Level coarser(const Level& fine, int level) const;
  [[nodiscard]] StepLabel ofCube(int level, const Vec3i& cube) const;
  void collect(int level, const Vec3i& cube);

  kernels::StepRules mRules;
  Vec3i mDims;
  Range mAmbient;
  std::vector<std::int64_t> mBand, mMixed;
  LargeVector<Cells> mCells;  ///< of the band's bricks, set where they are mixed
  std::vector<Level> mLevels; ///< [0] holds the bricks
  std::vector<Cube> mCubes;
};

} // namespace volcaustic
