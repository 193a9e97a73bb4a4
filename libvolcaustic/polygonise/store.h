// Blocks of surface from one polygonised shape to the next.
#pragma once

#include "polygonise/block.h"
#include "polygonise/measure.h"

#include <memory>
#include <unordered_map>

namespace volcaustic {

struct StoredBlock {
  std::shared_ptr<const BlockSurface> surface; ///< none yet in a new one
  BlockMeasure measure;
  bool reused = false; ///< made for a shape before
};

/// Keeps what the last shape's blocks were, by all that decides them, and forgets those that a shape does not use.
class BlockStore {
public:
  /// Finds or makes a block, which stays where it is until the shape after the next one begins.
  StoredBlock& take(const SurfaceBlock& block, double cellSize, const std::vector<FlippedFaces>& flipped);
  /// What was not taken since the last call of this is forgotten.
  void beginShape();

private:
  struct Key {
    Vec3i coord;
    std::uint64_t program;
    double cellSize;
    std::vector<FlippedFaces> flipped;
    bool operator==(const Key&) const = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const;
  };
  using Blocks = std::unordered_map<Key, StoredBlock, KeyHash>;

  Blocks mBefore, mNow;
};

} // namespace volcaustic
