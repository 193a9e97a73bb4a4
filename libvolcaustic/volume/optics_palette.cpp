#include "volume/optics_palette.h"

#include "core/brick_set.h"
#include "core/parallel.h"
#include "volcaustic/error.h"

#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
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

/// Entries beyond which numbers are rounded: 3.5 MiB of optics, which a cache still holds.
constexpr std::size_t kMostEntries = 1 << 17;
/// How a key's numbers may be rounded, from fine to coarse: bits of the significand that they keep, by which they are
/// off by 2^-(bits + 1) of themselves at most, and up to how many entries. Kernels have 23 bits for an entry's number.
struct Rounding {
  int bits;
  double mostEntries;
};
constexpr std::array<Rounding, 5> kRoundings{
    {{11, kMostEntries}, {9, kMostEntries}, {7, 1 << 22}, {5, 1 << 22}, {3, 1 << 22}}};
constexpr int kAllBits = 23;

float rounded(float value, int bits) {
  const int dropped = kAllBits - bits;
  const std::uint32_t half = dropped ? 1u << (dropped - 1) : 0;
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(value) + half) >> dropped << dropped);
}
Key rounded(const Key& key, int bits) {
  Key result;
  for (std::size_t i = 0; i < key.size(); ++i) result[i] = rounded(key[i], bits);
  return result;
}

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

/// Tells how many distinct keys there are, to a percent or two, by the bits of a table that their hashes hit (Whang,
/// Vander-Zanden, Taylor 1990). Which bits these are does not depend on the order, so threads may add at once.
class KeyCount {
public:
  void add(const Key& key) {
    const std::size_t bit = KeyHash()(key) % kBits;
    std::atomic<std::uint64_t>& word = mWords[bit / 64];
    const std::uint64_t mask = std::uint64_t{1} << bit % 64;
    if (!(word.load(std::memory_order_relaxed) & mask)) word.fetch_or(mask, std::memory_order_relaxed);
  }
  [[nodiscard]] double estimate() const {
    constexpr double kAll = kBits;
    double set = 0;
    for (const auto& word : mWords) set += std::popcount(word.load(std::memory_order_relaxed));
    return -kAll * std::log1p(-std::min(set, kAll - 1) / kAll);
  }

private:
  static constexpr std::size_t kBits = 1 << 21;
  std::vector<std::atomic<std::uint64_t>> mWords = std::vector<std::atomic<std::uint64_t>>(kBits / 64);
};

/// Bricks whose optics are not the ambient ones all over, in order.
std::vector<std::int64_t> opticsBricks(const OpticsGrids& grids) {
  return merged(merged(grids.attenuation.occupied(), grids.scattering.occupied()), grids.asymmetry.occupied());
}

constexpr std::int64_t kGrain = 64;        ///< bricks that share a palette of their own at first
constexpr std::uint64_t kEntryBytes = 128; ///< of a palette in the making

class OpticsPacker {
public:
  OpticsPacker(const OpticsGrids& grids, FlatMediumStorage& out, const RunContext& ctx)
      : mGrids(grids), mOut(out), mCtx(ctx), mBricks(opticsBricks(grids)), mAmbient(ambientKey(grids)) {}

  std::vector<std::int64_t> run(double voxelSize) {
    assignSlots();
    Palette all = numberAll(kMostEntries);
    if (all.keys().size() > kMostEntries) {
      chooseBits();
      all = numberAll(std::numeric_limits<std::size_t>::max());
    }
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

  /// Numbers the entries of all bricks, or of so many that there are more than `most`. Some pieces at a time, so that
  /// the palettes of all never exist at once.
  Palette numberAll(std::size_t most) {
    Palette all(mAmbient);
    const auto count = static_cast<std::int64_t>(mBricks.size());
    const std::int64_t wave = kGrain * 8 * threadCount(mCtx);
    for (std::int64_t begin = 0; begin < count && all.keys().size() <= most; begin += wave)
      numberWave(begin, std::min(begin + wave, count), all);
    return all;
  }

  /// The finest rounding by which the optics are few enough; smoke has others in every voxel.
  void chooseBits() {
    for (const auto& [bits, mostEntries] : kRoundings) {
      mBits = bits;
      KeyCount keys;
      parallelFor(static_cast<std::int64_t>(mBricks.size()), kGrain, mCtx,
                  [&](std::int64_t begin, std::int64_t end, int) {
                    for (std::int64_t i = begin; i < end; ++i) countKeys(mBricks[i], keys);
                  });
      if (const double entries = keys.estimate(); entries <= mostEntries) {
        mCtx.requireMemory(static_cast<std::uint64_t>(entries) * kEntryBytes, "stepField: optics");
        return;
      }
    }
    throw Error(ErrorKind::Input, "stepField: more than four million different optics, too many to number; take larger "
                                  "voxels, or grids of numbers in place of vectors");
  }
  void countKeys(std::int64_t b, KeyCount& keys) const {
    const BrickOptics optics(mGrids, b);
    keys.add(keyOf(optics, 0));
    for (int i = 1; i < kBrickVoxels && optics.varies(); ++i)
      if (!optics.repeats(i)) keys.add(keyOf(optics, i));
  }

  /// Of a voxel, rounded unless its optics are the ambient ones.
  [[nodiscard]] Key keyOf(const BrickOptics& optics, int voxel) const {
    const Key key = optics.at(voxel);
    return sameBits(key, mAmbient) ? key : rounded(key, mBits);
  }

  /// Numbers the entries of a run of bricks by palettes of their own, then palette by palette in order: the numbers are
  /// those of one palette for all.
  void numberWave(std::int64_t first, std::int64_t last, Palette& all) {
    std::vector<Palette> palettes(static_cast<std::size_t>((last - first + kGrain - 1) / kGrain), Palette(mAmbient));
    const auto forEachBrick = [&](auto&& visit) {
      parallelFor(last - first, kGrain, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t i = begin; i < end; ++i) visit(mBricks[first + i], static_cast<std::size_t>(begin / kGrain));
      });
    };
    forEachBrick([&](std::int64_t b, std::size_t p) { number(b, palettes[p]); });
    std::vector<std::vector<std::int32_t>> numbers(palettes.size());
    for (std::size_t p = 0; p < palettes.size(); ++p)
      for (const Key& key : palettes[p].keys()) numbers[p].push_back(all.entry(key));
    forEachBrick([&](std::int64_t b, std::size_t p) { renumber(b, numbers[p]); });
  }

  [[nodiscard]] std::span<std::int32_t> voxelsOf(std::int32_t slot) {
    return {mOut.voxelOptics.data() + std::size_t(slot) * kernels::kStepVoxels, kernels::kStepVoxels};
  }
  /// Entries of the palette; of all bricks' own in renumber().
  void number(std::int64_t b, Palette& palette) {
    const BrickOptics optics(mGrids, b);
    const std::int32_t slot = mOut.opticsSlots[b], first = palette.entry(keyOf(optics, 0));
    if (slot <= 0) {
      mOut.opticsSlots[b] = -first;
      return;
    }
    const std::span<std::int32_t> entries = voxelsOf(slot);
    entries[0] = first;
    for (int i = 1; i < kBrickVoxels; ++i)
      entries[i] = optics.repeats(i) ? entries[i - 1] : palette.entry(keyOf(optics, i));
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
  int mBits = kAllBits;
};

} // namespace

std::vector<std::int64_t> packOptics(const OpticsGrids& grids, double voxelSize, FlatMediumStorage& flat,
                                     const RunContext& ctx) {
  return OpticsPacker(grids, flat, ctx).run(voxelSize);
}

} // namespace volcaustic
