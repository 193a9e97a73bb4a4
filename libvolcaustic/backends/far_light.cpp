#include "backends/far_light.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace volcaustic {

namespace {

// Pieces of the list of chords that are sorted at once: at most so many, and so many counters in all.
constexpr std::int64_t kMostPieces = 64, kMostCounters = 1 << 21;

/// Calls visit for the blocks that the chord goes through or passes within a voxel of; a few others may be among them.
template <class Visit>
void forBlocks(const FarChord& chord, const kernels::Int3& blockDims, const Visit& visit) {
  const float* d = chord.direction;
  const float size[3] = {std::abs(d[0]), std::abs(d[1]), std::abs(d[2])};
  const int w = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  const int u = (w + 1) % 3, v = (w + 2) % 3;
  constexpr float kMargin = 1 + 1e-3f; // and rounding
  const auto blockAt = [](float p, int dim) {
    return std::clamp(static_cast<int>(std::floor(p * (1.0f / kBlockEdge))), 0, dim - 1);
  };
  const float begin = chord.start[w], end = begin + d[w] * chord.length;
  const float inverse = 1 / d[w];
  int block[3];
  const int last = blockAt(std::max(begin, end) + kMargin, blockDims[w]);
  for (block[w] = blockAt(std::min(begin, end) - kMargin, blockDims[w]); block[w] <= last; ++block[w]) {
    // The part of the chord inside the layer of blocks and a voxel beside it.
    const float low = (static_cast<float>(block[w]) * kBlockEdge - kMargin - begin) * inverse;
    const float high = low + (kBlockEdge + 2 * kMargin) * inverse;
    const float from = std::clamp(std::min(low, high), 0.0f, chord.length);
    const float to = std::clamp(std::max(low, high), 0.0f, chord.length);
    int first[3], beyond[3];
    for (const int a : {u, v}) {
      const float p = chord.start[a] + d[a] * from, q = chord.start[a] + d[a] * to;
      first[a] = blockAt(std::min(p, q) - kMargin, blockDims[a]);
      beyond[a] = blockAt(std::max(p, q) + kMargin, blockDims[a]) + 1;
    }
    for (block[u] = first[u]; block[u] < beyond[u]; ++block[u])
      for (block[v] = first[v]; block[v] < beyond[v]; ++block[v])
        visit((std::int64_t{block[0]} * blockDims.y + block[1]) * blockDims.z + block[2]);
  }
}

/// What goes along a high face of the domain lights the voxels before it.
void moveInside(FarChord& chord, const kernels::Int3& dims) {
  for (int a = 0; a < 3; ++a)
    chord.start[a] = std::min(chord.start[a], std::nextafter(static_cast<float>(dims[a]), 0.0f));
}

} // namespace

FarLight::FarLight(const kernels::Int3& dims, const LaneSet& lanes)
    : mDims(dims)
    , mBlockDims(blockDims(dims))
    , mLanes(lanes)
    , mFirst(std::size_t(mBlockDims.x) * mBlockDims.y * mBlockDims.z + 1) {}

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

void FarLight::collect(const RunContext& ctx) {
  ctx.requireMemory(2 * (mChords.size() + waiting()) * sizeof(FarChord), "photons: straight ways");
  std::vector<std::pair<const FarChords*, std::size_t>> places; // tasks, and where their chords go
  std::size_t end = mChords.size();
  for (const std::vector<FarChords>& tasks : mTasks)
    for (const FarChords& task : tasks) {
      places.emplace_back(&task, end);
      end += task.all().size();
    }
  mChords.resize(end);
  parallelFor(static_cast<std::int64_t>(places.size()), 8, ctx, [&](std::int64_t begin, std::int64_t stop, int) {
    for (std::int64_t i = begin; i < stop; ++i)
      std::copy(places[i].first->all().begin(), places[i].first->all().end(), mChords.begin() + places[i].second);
  });
  mTasks.clear();
}

void FarLight::sort(const RunContext& ctx) {
  collect(ctx);
  if (mChords.empty()) return;

  // A counting sort by block that keeps the order of the chords: each piece of the list counts its chords in each
  // block, then writes them to its own places.
  const auto count = static_cast<std::int64_t>(mChords.size());
  const std::int64_t blocks = blockCount(), most = std::clamp(kMostCounters / blocks, std::int64_t{1}, kMostPieces);
  const std::int64_t piece = (count + most - 1) / most;
  const std::int64_t pieces = (count + piece - 1) / piece;
  struct Crossing {
    std::uint32_t block, chord;
  };
  std::vector<std::vector<Crossing>> found(pieces);
  std::vector<std::vector<std::int64_t>> places(pieces);
  parallelFor(pieces, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t p = begin; p < end; ++p) {
      for (std::int64_t i = p * piece; i < std::min((p + 1) * piece, count); ++i) moveInside(mChords[i], mDims);
      places[p].resize(blocks);
      found[p].reserve(3 * piece);
      for (std::int64_t i = p * piece; i < std::min((p + 1) * piece, count); ++i)
        forBlocks(mChords[i], mBlockDims, [&](std::int64_t block) {
          ++places[p][block];
          found[p].push_back({static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(i)});
        });
    }
  });
  std::int64_t next = 0;
  for (std::int64_t b = 0; b < blocks; ++b) {
    mFirst[b] = next;
    for (auto& place : places) next += std::exchange(place[b], next);
  }
  mFirst[blocks] = next;
  mIds.resize(next);
  parallelFor(pieces, 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t p = begin; p < end; ++p)
      for (const Crossing& c : found[p]) mIds[places[p][c.block]++] = c.chord;
  });
}

void FarLight::addTo(std::int64_t block, float scale, BlockSums& sums) const {
  if (!touched(block)) return;
  mLanes.rasterise(mChords.data(), mIds.data() + mFirst[block], mFirst[block + 1] - mFirst[block],
                   blockCorner(mBlockDims, block), scale, sums);
}

std::uint64_t FarLight::bytes() const {
  return mChords.size() * sizeof(FarChord) + mIds.size() * sizeof(std::uint32_t);
}

} // namespace volcaustic
