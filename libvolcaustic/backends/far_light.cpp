#include "backends/far_light.h"

#include "core/parallel.h"

#include <algorithm>

namespace volcaustic {

namespace {

constexpr std::int64_t kPiece = 4096; // chords that are sorted together

} // namespace

FarLight::FarLight(const kernels::Int3& dims, const LaneSet& lanes)
    : mBlockDims(blockDims(dims)), mLanes(lanes), mFirst(std::size_t(mBlockDims.x) * mBlockDims.y * mBlockDims.z + 1) {}

std::span<FarChords> FarLight::newTasks(std::int64_t count) { return mTasks.emplace_back(count); }

std::size_t FarLight::waiting() const {
  std::size_t count = 0;
  for (const std::vector<FarChords>& tasks : mTasks)
    for (const FarChords& task : tasks) count += task.all().size();
  return count;
}

void FarLight::clear() {
  mTasks.clear();
  mChords.clear();
  mIds.clear();
  std::fill(mFirst.begin(), mFirst.end(), 0);
}

void FarLight::sort(const RunContext& ctx) {
  ctx.requireMemory(2 * (mChords.size() + waiting()) * sizeof(FarChord), "photons: straight ways");
  for (std::vector<FarChords>& tasks : mTasks)
    for (FarChords& task : tasks) mChords.insert(mChords.end(), task.all().begin(), task.all().end());
  mTasks.clear();
  if (mChords.empty()) return;

  // Each piece finds the blocks of its chords; a counting sort brings them together, pieces in their order.
  const auto count = static_cast<std::int64_t>(mChords.size()), pieces = (count + kPiece - 1) / kPiece;
  const std::int64_t blocks = static_cast<std::int64_t>(mFirst.size()) - 1;
  std::vector<std::vector<BlockCrossing>> found(pieces);
  parallelFor(pieces, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t p = begin; p < end; ++p) {
      const std::int64_t size = std::min(kPiece, count - p * kPiece);
      const FarChord* chords = mChords.data() + p * kPiece;
      std::int64_t most = 0;
      for (std::int64_t i = 0; i < size; ++i) most += mostBlocks(chords[i].length);
      found[p].resize(most);
      found[p].resize(mLanes.findBlocks(chords, size, mBlockDims, found[p].data()));
    }
  });
  std::fill(mFirst.begin(), mFirst.end(), 0);
  for (const auto& piece : found)
    for (const BlockCrossing& c : piece) ++mFirst[c.block + 1];
  for (std::int64_t b = 0; b < blocks; ++b) mFirst[b + 1] += mFirst[b];
  mIds.resize(mFirst[blocks]);
  std::vector<std::int64_t> next(mFirst.begin(), mFirst.end() - 1);
  for (std::int64_t p = 0; p < pieces; ++p)
    for (const BlockCrossing& c : found[p]) mIds[next[c.block]++] = static_cast<std::uint32_t>(p * kPiece + c.chord);
}

std::int64_t FarLight::addTo(std::int64_t block, float scale, BlockSums& sums) const {
  if (!touched(block)) return 0;
  const auto z = static_cast<std::int32_t>(block % mBlockDims.z);
  const auto rest = static_cast<std::int32_t>(block / mBlockDims.z);
  const kernels::Int3 corner{rest / mBlockDims.y * kBlockEdge, rest % mBlockDims.y * kBlockEdge, z * kBlockEdge};
  return mLanes.rasterise(mChords.data(), mIds.data() + mFirst[block], mFirst[block + 1] - mFirst[block], corner, scale,
                          sums);
}

std::uint64_t FarLight::bytes() const {
  return mChords.size() * sizeof(FarChord) + mIds.size() * sizeof(std::uint32_t);
}

} // namespace volcaustic
