#include "volume/flatten.h"

#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volume/grids.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <unordered_map>

namespace volcaustic {

namespace {

using kernels::FieldVoxel;
using kernels::Float3;
using kernels::Int3;
using kernels::Optics;

// Changes of n under this between voxels are rounding, not refraction: a ray that meets it all along 256 voxels turns
// by 0.015 degrees.
constexpr float kFlat = 1e-6f;

/// n over a brick and its surroundings. Beyond the domain's faces n goes on as it came (odd reflection about the face's
/// voxel), so that a gradient across the box stays what it is up to the face.
constexpr int kLow = 3, kHigh = 4, kBlock = kBrickSize + kLow + kHigh;
class IndexBlock {
public:
  void gather(const BrickGrid<float>& index, const Vec3i& origin) {
    for (int x = 0; x < kBlock; ++x)
      for (int y = 0; y < kBlock; ++y)
        for (int z = 0; z < kBlock; ++z) {
          const Vec3i v{origin[0] + x - kLow, origin[1] + y - kLow, origin[2] + z - kLow};
          mValues[(x * kBlock + y) * kBlock + z] = extended(index, v);
        }
  }
  /// Coordinates relative to the brick, from -3 to 11.
  [[nodiscard]] float at(int x, int y, int z) const {
    return mValues[((x + kLow) * kBlock + y + kLow) * kBlock + z + kLow];
  }
  [[nodiscard]] const float* data() const { return mValues.data(); }
  [[nodiscard]] bool flat() const {
    const auto [low, high] = std::minmax_element(mValues.begin(), mValues.end());
    return *high - *low < kFlat;
  }

private:
  static float extended(const BrickGrid<float>& index, const Vec3i& v) {
    const Vec3i d = index.dims();
    Vec3i face, mirror;
    bool outside = false;
    for (int a = 0; a < 3; ++a) {
      face[a] = std::clamp(v[a], 0, d[a] - 1);
      mirror[a] = std::clamp(2 * face[a] - v[a], 0, d[a] - 1);
      outside = outside || face[a] != v[a];
    }
    const float n = index.at(face[0], face[1], face[2]);
    return outside ? 2 * n - index.at(mirror[0], mirror[1], mirror[2]) : n;
  }

  std::array<float, kBlock * kBlock * kBlock> mValues;
};

/// Turns samples of n into what trilinear interpolation should be given (docs/algorithms/step_field.md, "Field").
///
/// Between samples f, linear interpolation lies above a convex function by h^2 f''/12 on average. Taking that off the
/// samples, f - (second difference)/12 along each axis, leaves an error that alternates in sign along a path instead of
/// adding up. The gradient is the central difference of fourth order, (8 (f1 - f-1) - (f2 - f-2))/12, treated in the
/// same way.
class FieldFilter {
public:
  void run(const IndexBlock& block, FieldVoxel* out) {
    apply(block, {value, value, value}, out, &FieldVoxel::n);
    apply(block, {slope, value, value}, out, &FieldVoxel::gx);
    apply(block, {value, slope, value}, out, &FieldVoxel::gy);
    apply(block, {value, value, slope}, out, &FieldVoxel::gz);
  }

private:
  /// One tap at p[0] from p[-3 stride] to p[3 stride]. Written in differences, so that a constant gives itself and a
  /// slope of exactly zero.
  using Tap = float (*)(const float* p, int stride);
  static float value(const float* p, int s) { return p[0] - ((p[s] - p[0]) + (p[-s] - p[0])) * (1 / 12.f); }
  static float slope(const float* p, int s) {
    return ((p[s] - p[-s]) * 113 - (p[2 * s] - p[-2 * s]) * 22 + (p[3 * s] - p[-3 * s])) * (1 / 144.f);
  }

  static constexpr int kEdge = kernels::kFieldEdge, kPlane = kBlock * kBlock;

  void apply(const IndexBlock& block, const std::array<Tap, 3>& taps, FieldVoxel* out, float FieldVoxel::*member) {
    for (int x = 0; x < kEdge; ++x)
      for (int yz = 0; yz < kPlane; ++yz)
        mAfterX[x * kPlane + yz] = taps[0](block.data() + (x + kLow) * kPlane + yz, kPlane);
    for (int x = 0; x < kEdge; ++x)
      for (int y = 0; y < kEdge; ++y)
        for (int z = 0; z < kBlock; ++z)
          mAfterY[(x * kEdge + y) * kBlock + z] = taps[1](&mAfterX[x * kPlane + (y + kLow) * kBlock + z], kBlock);
    for (int row = 0; row < kEdge * kEdge; ++row)
      for (int z = 0; z < kEdge; ++z) out[row * kEdge + z].*member = taps[2](&mAfterY[row * kBlock + z + kLow], 1);
  }

  std::array<float, kEdge * kPlane> mAfterX;
  std::array<float, kEdge * kEdge * kBlock> mAfterY;
};

class Flattener {
public:
  Flattener(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx)
      : mDomain(medium.domain())
      , mCtx(ctx)
      , mIndex(fromFloatGrid(*medium.grids().index, mDomain.dims, ctx))
      , mAttenuation(fromVec3Grid(*medium.grids().attenuation, mDomain.dims, ctx))
      , mScattering(fromVec3Grid(*medium.grids().scattering, mDomain.dims, ctx))
      , mAsymmetry(medium.grids().asymmetry
                       ? fromFloatGrid(*medium.grids().asymmetry, mDomain.dims, ctx)
                       : BrickGrid<float>(mDomain.dims, static_cast<float>(medium.ambient().asymmetry)))
      , mSteps(stepFieldGrid(medium, options, ctx)) {
    const Vec3i& bricks = mIndex.brickDims();
    mOut.dims = {mDomain.dims[0], mDomain.dims[1], mDomain.dims[2]};
    mOut.brickDims = {bricks[0], bricks[1], bricks[2]};
    mOut.cap = static_cast<float>(options.cap);
    const auto count = static_cast<std::size_t>(mIndex.brickCount());
    mOut.fieldSlots = ZeroedTable<std::int32_t>(count);
    mOut.stepSlots = ZeroedTable<std::int32_t>(count);
    mOut.opticsSlots = ZeroedTable<std::int32_t>(count);
    mOut.indexOffsets = ZeroedTable<float>(count);
    mOut.bends = ZeroedTable<std::uint8_t>(count);
    const Ambient& a = medium.ambient();
    mOut.ambientIndex = static_cast<float>(a.index);
    const auto f = [](const Rgb& c) { return Vec3f{float(c[0]), float(c[1]), float(c[2])}; };
    paletteEntry(f(a.attenuation), f(a.scattering), static_cast<float>(a.asymmetry)); // entry 0
  }

  FlatMediumStorage run() {
    findFields();
    fillOptics();
    fillFieldsAndSteps();
    return std::move(mOut);
  }

private:
  /// Whether n is one value in the brick and its 26 neighbours, by their constants alone.
  [[nodiscard]] bool surroundedByConstant(std::int64_t b) const {
    if (!mIndex.isConstant(b)) return false;
    const Vec3i c = mIndex.brickCoord(b), n = mIndex.brickDims();
    for (int x = std::max(c[0] - 1, 0); x <= std::min(c[0] + 1, n[0] - 1); ++x)
      for (int y = std::max(c[1] - 1, 0); y <= std::min(c[1] + 1, n[1] - 1); ++y)
        for (int z = std::max(c[2] - 1, 0); z <= std::min(c[2] + 1, n[2] - 1); ++z) {
          const std::int64_t other = mIndex.brickIndex({x, y, z});
          if (!mIndex.isConstant(other) || mIndex.constant(other) != mIndex.constant(b)) return false;
        }
    return true;
  }

  /// Slots for the bricks in or beside which n changes.
  void findFields() {
    const std::int64_t count = mIndex.brickCount();
    std::vector<char> varies(count);
    parallelFor(count, 256, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      IndexBlock block;
      for (std::int64_t b = begin; b < end; ++b) {
        const float n = mIndex.isConstant(b) ? mIndex.constant(b) : mIndex.voxels(b)[0];
        if (n != mOut.ambientIndex) mOut.indexOffsets[b] = n - mOut.ambientIndex;
        if (surroundedByConstant(b)) continue;
        block.gather(mIndex, originOf(b));
        varies[b] = !block.flat();
      }
    });
    std::int32_t slots = 1; // slot 0: no gradient, for every brick without a slot
    for (std::int64_t b = 0; b < count; ++b)
      if (varies[b]) mOut.fieldSlots[b] = nextSlot(slots);
    mCtx.requireMemory(std::uint64_t(slots) * kernels::kFieldVoxels * sizeof(FieldVoxel), "stepField: index field");
    mOut.fields.resize(std::size_t(slots) * kernels::kFieldVoxels);
  }

  /// Kernels address voxel arrays with 32 bits, and floats of a field voxel too.
  static std::int32_t nextSlot(std::int32_t& slots) {
    constexpr std::int32_t kMostSlots = std::numeric_limits<std::int32_t>::max() / (4 * kernels::kFieldVoxels);
    if (slots == kMostSlots)
      throw Error(ErrorKind::Input, "volume: light bends in more than " + std::to_string(kMostSlots) +
                                        " bricks of 8x8x8 voxels; lower the resolution");
    return slots++;
  }

  /// Whether the brick's step bytes are one value.
  [[nodiscard]] bool stepsAreConstant(std::int64_t b) const {
    return mOut.fieldSlots[b] == 0 && mOut.opticsSlots[b] <= 0 && !mSteps->tree().probeConstLeaf(coordOf(b));
  }

  void fillFieldsAndSteps() {
    // A brick has step bytes of its own where labels differ inside it, where light bends in a part of it, or where the
    // optics do; slots first, bytes in parallel.
    const std::int64_t count = mIndex.brickCount();
    std::vector<std::int16_t> bytes(count, -1);
    std::array<std::int64_t, 256> frequency{};
    std::int32_t slots = 1;
    for (std::int64_t b = 0; b < count; ++b) {
      if (!stepsAreConstant(b)) {
        mOut.stepSlots[b] = nextSlot(slots);
        continue;
      }
      const bool bends = mOut.opticsSlots[b] != 0;
      if (bends) mOut.bends[b] = 1;
      bytes[b] = stepByte(mSteps->tree().getValue(coordOf(b)), bends);
      ++frequency[bytes[b]];
    }
    mOut.ambientStep =
        static_cast<std::int32_t>(std::max_element(frequency.begin(), frequency.end()) - frequency.begin());
    for (std::int64_t b = 0; b < count; ++b)
      if (bytes[b] >= 0 && bytes[b] != mOut.ambientStep) mOut.stepSlots[b] = ~std::int32_t{bytes[b]};

    mOut.steps.resize(std::size_t(slots) * kernels::kStepVoxels + kernels::kStepPadding);
    std::fill_n(mOut.steps.begin(), kernels::kStepVoxels, static_cast<std::uint8_t>(mOut.ambientStep));
    parallelFor(count, 64, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
      IndexBlock block;
      FieldFilter filter;
      openvdb::Int32Grid::ConstAccessor labels(mSteps->getConstAccessor());
      for (std::int64_t b = begin; b < end; ++b) {
        if (mOut.stepSlots[b] <= 0) continue;
        if (mOut.fieldSlots[b] > 0) {
          block.gather(mIndex, originOf(b));
          filter.run(block, mOut.fields.data() + std::size_t(mOut.fieldSlots[b]) * kernels::kFieldVoxels);
        }
        fillSteps(b, block, labels);
      }
    });
  }

  void fillSteps(std::int64_t b, const IndexBlock& block, const openvdb::Int32Grid::ConstAccessor& labels) {
    std::uint8_t* out = mOut.steps.data() + std::size_t(mOut.stepSlots[b]) * kernels::kStepVoxels;
    const std::int32_t opticsSlot = mOut.opticsSlots[b];
    const bool hasField = mOut.fieldSlots[b] > 0;
    std::array<bool, 1000> curved{};
    if (hasField) markCurved(block, curved);
    const openvdb::Coord origin = coordOf(b);
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < 8; ++z) {
          const int i = brickOffset(x, y, z);
          const std::int32_t optics =
              opticsSlot <= 0 ? -opticsSlot : mOut.voxelOptics[std::size_t(opticsSlot) * kernels::kStepVoxels + i];
          const bool bends = optics != 0 || (hasField && touchesCurved(curved, x, y, z));
          out[i] = stepByte(labels.getValue(origin.offsetBy(x, y, z)), bends);
          if (bends) mOut.bends[b] = 1;
        }
  }

  /// Voxels from -1 to 8 at which the gradient is not zero (the filter's outermost weight, 1/144, aside).
  static void markCurved(const IndexBlock& block, std::array<bool, 1000>& curved) {
    for (int x = -1; x <= 8; ++x)
      for (int y = -1; y <= 8; ++y)
        for (int z = -1; z <= 8; ++z) {
          float low = block.at(x, y, z), high = low;
          for (const int d : {-2, -1, 1, 2})
            for (const float n : {block.at(x + d, y, z), block.at(x, y + d, z), block.at(x, y, z + d)}) {
              low = std::min(low, n);
              high = std::max(high, n);
            }
          curved[((x + 1) * 10 + y + 1) * 10 + z + 1] = high - low > kFlat;
        }
  }
  /// Whether a trilinear lookup inside the voxel can see a gradient.
  static bool touchesCurved(const std::array<bool, 1000>& curved, int x, int y, int z) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          if (curved[((x + i) * 10 + y + j) * 10 + z + k]) return true;
    return false;
  }

  static std::uint8_t stepByte(int label, bool bends) {
    const int capped = label & kStepCapped;
    return static_cast<std::uint8_t>((label & kernels::kStepLevelMask) | (capped ? kernels::kStepCappedBit : 0) |
                                     (bends ? kernels::kStepBendsBit : 0));
  }

  /// Distinct optics once each; bricks and voxels refer to them by number.
  void fillOptics() {
    mOut.voxelOptics.resize(kernels::kStepVoxels); // slot 0
    std::int32_t slots = 1;
    for (std::int64_t b = 0; b < mIndex.brickCount(); ++b) {
      if (mAttenuation.isConstant(b) && mScattering.isConstant(b) && mAsymmetry.isConstant(b)) {
        const std::int32_t entry =
            paletteEntry(mAttenuation.constant(b), mScattering.constant(b), mAsymmetry.constant(b));
        if (entry != 0) mOut.opticsSlots[b] = -entry;
        continue;
      }
      mOut.opticsSlots[b] = nextSlot(slots);
      const auto value = [b](const auto& grid, int i) {
        return grid.isConstant(b) ? grid.constant(b) : grid.voxels(b)[i];
      };
      for (int i = 0; i < kBrickVoxels; ++i)
        mOut.voxelOptics.push_back(paletteEntry(value(mAttenuation, i), value(mScattering, i), value(mAsymmetry, i)));
    }
    for (const Optics& o : mOut.optics) mOut.attenuates = mOut.attenuates || kernels::maxComponent(o.attenuation) > 0;
  }

  std::int32_t paletteEntry(const Vec3f& attenuation, const Vec3f& scattering, float asymmetry) {
    const std::array<float, 7> key{attenuation[0], attenuation[1], attenuation[2], scattering[0],
                                   scattering[1],  scattering[2],  asymmetry};
    if (!mOut.optics.empty() && key == mLastKey) return mLastEntry;
    const auto [it, added] = mPalette.try_emplace(key, static_cast<std::int32_t>(mOut.optics.size()));
    if (added) {
      const float h = static_cast<float>(mDomain.voxelSize);
      mOut.optics.push_back({Float3(key[0], key[1], key[2]) * h, Float3(key[3], key[4], key[5]) * h, asymmetry});
    }
    mLastKey = key;
    return mLastEntry = it->second;
  }

  [[nodiscard]] Vec3i originOf(std::int64_t b) const {
    const Vec3i c = mIndex.brickCoord(b);
    return {c[0] * kBrickSize, c[1] * kBrickSize, c[2] * kBrickSize};
  }
  [[nodiscard]] openvdb::Coord coordOf(std::int64_t b) const {
    const Vec3i o = originOf(b);
    return {o[0], o[1], o[2]};
  }

  struct KeyHash {
    std::size_t operator()(const std::array<float, 7>& key) const {
      std::size_t h = 0;
      for (const float f : key) {
        std::uint32_t bits;
        std::memcpy(&bits, &f, sizeof bits);
        h = (h ^ bits) * 0x9e3779b97f4a7c15ull;
        h ^= h >> 29;
      }
      return h;
    }
  };

  Domain mDomain;
  const RunContext& mCtx;
  BrickGrid<float> mIndex;
  BrickGrid<Vec3f> mAttenuation, mScattering;
  BrickGrid<float> mAsymmetry;
  openvdb::Int32Grid::Ptr mSteps;
  std::unordered_map<std::array<float, 7>, std::int32_t, KeyHash> mPalette;
  std::array<float, 7> mLastKey{};
  std::int32_t mLastEntry = 0;
  FlatMediumStorage mOut;
};

} // namespace

kernels::FlatMedium FlatMediumStorage::view() const {
  kernels::FlatMedium m;
  m.dims = dims;
  m.brickDims = brickDims;
  m.fieldSlots = fieldSlots.data();
  m.indexOffsets = indexOffsets.data();
  m.stepSlots = stepSlots.data();
  m.opticsSlots = opticsSlots.data();
  m.bends = bends.data();
  m.fields = fields.data();
  m.steps = steps.data();
  m.voxelOptics = voxelOptics.data();
  m.optics = optics.data();
  m.ambientIndex = ambientIndex;
  m.ambientStep = ambientStep;
  m.cap = cap;
  m.attenuates = attenuates;
  m.fieldCount = static_cast<std::int64_t>(fields.size());
  m.stepCount = static_cast<std::int64_t>(steps.size());
  m.voxelOpticsCount = static_cast<std::int64_t>(voxelOptics.size());
  m.opticsCount = static_cast<std::int64_t>(optics.size());
  return m;
}

std::size_t FlatMediumStorage::memoryBytes() const {
  return fieldSlots.size() * (3 * sizeof(std::int32_t) + sizeof(float) + sizeof(std::uint8_t)) +
         fields.size() * sizeof(FieldVoxel) + steps.size() + voxelOptics.size() * sizeof(std::int32_t) +
         optics.size() * sizeof(Optics);
}

FlatMediumStorage flattenMedium(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx) {
  return Flattener(medium, options, ctx).run();
}

} // namespace volcaustic
