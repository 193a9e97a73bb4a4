#include "polygonise/store.h"

#include "core/hash.h"

namespace volcaustic {

std::size_t BlockStore::KeyHash::operator()(const Key& key) const {
  Hash hash;
  hash.values(std::span<const int>(key.coord)).value(key.program).value(key.cellSize);
  for (const FlippedFaces& f : key.flipped) hash.value(f.cell).value(f.faces);
  return hash.digest();
}

StoredBlock& BlockStore::take(const SurfaceBlock& block, double cellSize, const std::vector<FlippedFaces>& flipped) {
  const auto [at, isNew] = mNow.try_emplace({block.coord, block.hash, cellSize, flipped});
  if (!isNew) return at->second;
  const auto before = mBefore.find(at->first);
  if (before != mBefore.end() && before->second.surface) {
    at->second = std::move(before->second);
    at->second.reused = true;
  }
  return at->second;
}

void BlockStore::beginShape() {
  mBefore = std::move(mNow);
  mNow.clear();
}

} // namespace volcaustic
