#include "volume/optics_palette.h"

#include "core/brick_set.h"
#include "core/parallel.h"

#include <array>
#include <cstring>
#include <unordered_map>

namespace volcaustic {

namespace {

using kernels::Float3;
using kernels::Optics;

/// Attenuation, scattering, asymmetry.
using Key = std::array<float, 7>;

struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::array<std::uint64_t, 4> words{};
    std::memcpy(words.data(), key.data(), sizeof key);
    const std::uint64_t h = words[0] * 0x9e3779b97f4a7c15ull ^ words[1] * 0xc2b2ae3d27d4eb4full ^
                            words[2] * 0x165667b19e3779f9ull ^ words[3] * 0xff51afd7ed558ccdull;
    return h >> 32;
  }
};

bool sameBits(const Key& a, const Key& b) { return std::memcmp(a.data(), b.data(), sizeof a) == 0; }

/// Keys by number, in the order in which they were asked for first.
class Palette {
public:
  explicit Palette(const Key& first) : mKeys{first} { mNumbers.emplace(first, 0); }

  std::int32_t entry(const Key& key) {
    std::int32_t& recent = mRecent[KeyHash()(key) % mRecent.size()];
    if (sameBits(key, mKeys[recent])) return recent;
    const auto [it, added] = mNumbers.try_emplace(key, static_cast<std::int32_t>(mKeys.size()));
    if (added) mKeys.push_back(key);
    return recent = it->second;
  }
  [[nodiscard]] const std::vector<Key>& keys() const { return mKeys; }

private:
  std::unordered_map<Key, std::int32_t, KeyHash> mNumbers;
  std::vector<Key> mKeys;
  std::array<std::int32_t, 256> mRecent{}; // by hash: spares most lookups, as coverage has few values
};

/// What the grids hold in one brick.
class BrickOptics {
public:
  BrickOptics(const OpticsGrids& grids, std::int64_t brick)
      : mAttenuation(grids.attenuation, brick)
      , mScattering(grids.scattering, brick)
      , mAsymmetry(grids.asymmetry, brick) {}

  [[nodiscard]] bool varies() const { return mAttenuation.scale || mScattering.scale || mAsymmetry.scale; }
  /// Whether a voxel's optics are those of the one before it.
  [[nodiscard]] bool repeats(int voxel) const {
    return mAttenuation.repeats(voxel) && mScattering.repeats(voxel) && mAsymmetry.repeats(voxel);
  }
  [[nodiscard]] Key at(int voxel) const {
    const Vec3f &a = mAttenuation.at(voxel), &s = mScattering.at(voxel);
    return {a[0], a[1], a[2], s[0], s[1], s[2], mAsymmetry.at(voxel)};
  }

private:
  template <class T>
  struct Source {
    const T* values;
    int scale; // 0: one value for all voxels
    Source(const BrickGrid<T>& grid, std::int64_t brick)
        : values(grid.isConstant(brick) ? &grid.constant(brick) : grid.voxels(brick).data())
        , scale(grid.isConstant(brick) ? 0 : 1) {}
    [[nodiscard]] const T& at(int voxel) const { return values[voxel * scale]; }
    [[nodiscard]] bool repeats(int voxel) const { return scale == 0 || values[voxel] == values[voxel - 1]; }
  };
  Source<Vec3f> mAttenuation, mScattering;
  Source<float> mAsymmetry;
};

/// Bricks whose optics are not the ambient ones all over, in order.
std::vector<std::int64_t> opticsBricks(const OpticsGrids& grids) {
  return merged(merged(grids.attenuation.occupied(), grids.scattering.occupied()), grids.asymmetry.occupied());
}

constexpr std::int64_t kGrain = 64; // bricks that share a palette of their own at first

class OpticsPacker {
public:
  OpticsPacker(const OpticsGrids& grids, FlatMediumStorage& out, const RunContext& ctx)
      : mGrids(grids), mOut(out), mCtx(ctx), mBricks(opticsBricks(grids)), mAmbient(ambientKey(grids)) {}

  std::vector<std::int64_t> run(double voxelSize) {
    assignSlots();
    const auto count = static_cast<std::int64_t>(mBricks.size());
    std::vector<Palette> palettes((mBricks.size() + kGrain - 1) / kGrain, Palette(mAmbient));
    parallelFor(count, kGrain, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) number(mBricks[i], palettes[begin / kGrain]);
    });
    // Palette by palette in order: the numbers are those of one palette for all.
    Palette all(mAmbient);
    std::vector<std::vector<std::int32_t>> numbers(palettes.size());
    for (std::size_t p = 0; p < palettes.size(); ++p)
      for (const Key& key : palettes[p].keys()) numbers[p].push_back(all.entry(key));
    parallelFor(count, kGrain, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) renumber(mBricks[i], numbers[begin / kGrain]);
    });
    const auto h = static_cast<float>(voxelSize);
    for (const Key& key : all.keys())
      mOut.optics.push_back({Float3(key[0], key[1], key[2]) * h, Float3(key[3], key[4], key[5]) * h, key[6]});
    for (const Optics& o : mOut.optics) mOut.attenuates = mOut.attenuates || kernels::maxComponent(o.attenuation) > 0;
    return std::move(mBricks);
  }

private:
  static Key ambientKey(const OpticsGrids& grids) {
    const Vec3f &a = grids.attenuation.background(), &s = grids.scattering.background();
    return {a[0], a[1], a[2], s[0], s[1], s[2], grids.asymmetry.background()};
  }

  void assignSlots() {
    std::vector<std::int64_t> varying;
    for (const std::int64_t b : mBricks)
      if (BrickOptics(mGrids, b).varies()) varying.push_back(b);
    const std::int64_t slots = assignBrickSlots(varying, mOut.opticsSlots);
    mCtx.requireMemory(std::uint64_t(slots) * kernels::kStepVoxels * sizeof(std::int32_t), "stepField: optics");
    mOut.voxelOptics.resize(std::size_t(slots) * kernels::kStepVoxels);
    std::fill_n(mOut.voxelOptics.begin(), kernels::kStepVoxels, 0); // slot 0: ambient
  }

  [[nodiscard]] std::span<std::int32_t> voxelsOf(std::int32_t slot) {
    return {mOut.voxelOptics.data() + std::size_t(slot) * kernels::kStepVoxels, kernels::kStepVoxels};
  }
  /// Entries of the palette; of all bricks' own in renumber().
  void number(std::int64_t b, Palette& palette) {
    const BrickOptics optics(mGrids, b);
    const std::int32_t slot = mOut.opticsSlots[b], first = palette.entry(optics.at(0));
    if (slot <= 0) {
      mOut.opticsSlots[b] = -first;
      return;
    }
    const std::span<std::int32_t> entries = voxelsOf(slot);
    entries[0] = first;
    for (int i = 1; i < kBrickVoxels; ++i)
      entries[i] = optics.repeats(i) ? entries[i - 1] : palette.entry(optics.at(i));
  }
  void renumber(std::int64_t b, const std::vector<std::int32_t>& numbers) {
    if (const std::int32_t slot = mOut.opticsSlots[b]; slot > 0)
      for (std::int32_t& entry : voxelsOf(slot)) entry = numbers[entry];
    else
      mOut.opticsSlots[b] = -numbers[-slot];
  }

  const OpticsGrids& mGrids;
  FlatMediumStorage& mOut;
  const RunContext& mCtx;
  std::vector<std::int64_t> mBricks;
  Key mAmbient;
};

} // namespace

std::vector<std::int64_t> packOptics(const OpticsGrids& grids, double voxelSize, FlatMediumStorage& flat,
                                     const RunContext& ctx) {
  return OpticsPacker(grids, flat, ctx).run(voxelSize);
}

} // namespace volcaustic
