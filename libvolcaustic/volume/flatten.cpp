#include "volume/flatten.h"

#include "core/brick_set.h"
#include "core/parallel.h"
#include "kernels/index_taps.h"
#include "volume/device_medium.h"
#include "volume/index_field.h"
#include "volume/medium_store.h"
#include "volume/optics_palette.h"
#include "volume/step_labels.h"

#include <algorithm>
#include <array>
#include <optional>

namespace volcaustic {

namespace {

using kernels::FieldVoxel;

Vec3f toFloat(const Rgb& c) { return {float(c[0]), float(c[1]), float(c[2])}; }

/// Attenuation, scattering and asymmetry of the ambient medium everywhere.
OpticsBricks ambientOptics(const Medium& medium) {
  const Vec3i& dims = medium.domain().dims;
  const Ambient& ambient = medium.ambient();
  OpticsBricks optics;
  optics.attenuation.emplace(dims, toFloat(ambient.attenuation));
  optics.scattering.emplace(dims, toFloat(ambient.scattering));
  optics.asymmetry.emplace(dims, static_cast<float>(ambient.asymmetry));
  return optics;
}

class Flattener {
public:
  Flattener(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx)
      : mCtx(ctx)
      , mVoxelSize(medium.domain().voxelSize)
      , mOptions(options)
      , mBricks(bricksOf(medium, ctx))
      , mIndex(mBricks->index)
      , mUniform(ambientOptics(medium))
      , mOptics{mBricks->attenuation ? *mBricks->attenuation : *mUniform.attenuation,
                mBricks->scattering ? *mBricks->scattering : *mUniform.scattering,
                mBricks->asymmetry ? *mBricks->asymmetry : *mUniform.asymmetry} {
    const Vec3i &dims = mIndex.dims(), &bricks = mIndex.brickDims();
    mOut = FlatMediumStorage({dims[0], dims[1], dims[2]}, {bricks[0], bricks[1], bricks[2]});
    mOut.cap = static_cast<float>(options.cap);
    mOut.ambientIndex = mIndex.background();
  }

  FlatMediumStorage run() {
    const std::vector<std::int64_t> opticsBricks = packOptics(mOptics, mVoxelSize, mOut, mCtx);
    fillFields();
    assignSteps(opticsBricks);
    fillSteps();
    return std::move(mOut);
  }

private:
  /// Slots for the bricks in or beside which n may change, then labels, n, its gradient and where light bends in one
  /// pass over the band.
  void fillFields() {
    BrickSet around(mIndex.brickDims());
    around.insertAround(mIndex.occupied());
    std::vector<std::int64_t> varying = around.sorted();
    std::erase_if(varying, [&](std::int64_t b) { return mIndex.uniformAround(b); });
    const std::int64_t slots = assignBrickSlots(varying, mOut.fieldSlots);
    mCtx.requireMemory(std::uint64_t(slots) * (kernels::kFieldVoxels * sizeof(FieldVoxel) + kBrickVoxels),
                       "stepField: index field");
    mOut.fields.resize(std::size_t(slots) * kernels::kFieldVoxels);
    std::fill_n(mOut.fields.begin(), kernels::kFieldVoxels, FieldVoxel{1, 0, 0, 0}); // slot 0
    mBends.resize(std::size_t(slots) * kBrickVoxels);
    mLabels.emplace(
        mIndex, attenuationMatters(mOut.optics, mOptions.attenuationTolerance) ? &mOptics.attenuation : nullptr,
        mVoxelSize, mOptions, mCtx,
        [this](std::size_t, std::int64_t brick, float range, IndexField* field) { fillField(brick, range, field); });
    for (const std::int64_t b : varying)
      if (mOut.fieldSlots[b] > 0) mFieldBricks.push_back(b);
  }
  void fillField(std::int64_t b, float range, IndexField* field) {
    const float n = mIndex.isConstant(b) ? mIndex.constant(b) : mIndex.voxels(b)[0];
    if (n != mOut.ambientIndex) mOut.indexOffsets[b] = n - mOut.ambientIndex;
    if (!field) return;
    if (range < kernels::kFlatIndex && field->flat()) { // the filter reaches farther than the range
      mOut.fieldSlots[b] = 0;
      return;
    }
    const auto slot = static_cast<std::size_t>(mOut.fieldSlots[b]);
    field->filter(mOut.fields.data() + slot * kernels::kFieldVoxels);
    field->findBends(std::span<std::uint8_t, kBrickVoxels>(mBends.data() + slot * kBrickVoxels, kBrickVoxels));
  }

  /// The step byte of a whole brick, without kStepBendsBit; kMixed where its voxels differ.
  [[nodiscard]] StepLabel brickLabel(std::int64_t b) const {
    const Vec3i brick = mIndex.brickCoord(b);
    if (const StepLabel label = mLabels->ofBrick(brick); label != StepLabels::kMixed) return label;
    std::array<StepLabel, kBrickVoxels> labels;
    mLabels->ofVoxels(brick, labels);
    const bool same = std::all_of(labels.begin(), labels.end(), [&](StepLabel l) { return l == labels[0]; });
    return same ? labels[0] : StepLabels::kMixed;
  }

  struct OneByte {
    std::int64_t brick;
    std::uint8_t byte;
  };

  /// A brick has step bytes of its own where labels differ inside it, where light bends in a part of it, or where the
  /// optics do. All others have one byte all over, and the most frequent one is the ambient byte.
  void assignSteps(const std::vector<std::int64_t>& opticsBricks) {
    std::vector<OneByte> exceptions; // from the byte of the cube that they lie in
    std::array<std::int64_t, 256> frequency{};
    for (const StepLabels::Cube& cube : mLabels->cubes()) frequency[cube.label] += cube.brickCount();
    for (const std::int64_t b : merged(merged(mFieldBricks, mLabels->mixedBricks()), opticsBricks)) {
      if (const StepLabel label = mLabels->ofBrick(mIndex.brickCoord(b)); label != StepLabels::kMixed)
        --frequency[label];
      const bool varies = mOut.opticsSlots[b] > 0 || mOut.fieldSlots[b] > 0;
      const StepLabel label = varies ? StepLabels::kMixed : brickLabel(b);
      if (label == StepLabels::kMixed) {
        mStepBricks.push_back(b);
        continue;
      }
      const bool bends = mOut.opticsSlots[b] != 0;
      if (bends) mOut.bends[b] = 1;
      exceptions.push_back({b, static_cast<std::uint8_t>(label | (bends ? kernels::kStepBendsBit : 0))});
      ++frequency[exceptions.back().byte];
    }
    mOut.ambientStep =
        static_cast<std::int32_t>(std::max_element(frequency.begin(), frequency.end()) - frequency.begin());
    writeSlots(exceptions);
  }

  void writeSlots(const std::vector<OneByte>& exceptions) {
    const auto ambient = static_cast<std::uint8_t>(mOut.ambientStep);
    for (const StepLabels::Cube& cube : mLabels->cubes())
      if (cube.label != ambient) setStep(cube);
    for (const auto& [brick, byte] : exceptions) mOut.stepSlots[brick] = byte != ambient ? ~std::int32_t{byte} : 0;
    const std::int64_t slots = assignBrickSlots(mStepBricks, mOut.stepSlots);
    mOut.steps.resize(std::size_t(slots) * kernels::kStepVoxels + kernels::kStepPadding);
    std::fill_n(mOut.steps.begin(), kernels::kStepVoxels, ambient);
    std::fill_n(mOut.steps.end() - kernels::kStepPadding, kernels::kStepPadding, std::uint8_t{0});
  }
  void setStep(const StepLabels::Cube& cube) {
    for (int x = cube.first[0]; x <= cube.last[0]; ++x)
      for (int y = cube.first[1]; y <= cube.last[1]; ++y)
        for (std::int64_t b = mIndex.brickIndex({x, y, cube.first[2]}), n = cube.last[2] - cube.first[2]; n >= 0; --n)
          mOut.stepSlots[b++] = ~std::int32_t{cube.label};
  }

  void fillSteps() {
    parallelFor(static_cast<std::int64_t>(mStepBricks.size()), 64, mCtx,
                [&](std::int64_t begin, std::int64_t end, int) {
                  for (std::int64_t i = begin; i < end; ++i) fillStep(mStepBricks[i]);
                });
  }

  void fillStep(std::int64_t b) {
    const Vec3i brick = mIndex.brickCoord(b);
    std::array<std::uint8_t, kBrickVoxels> bends{};
    if (const std::int32_t slot = mOut.fieldSlots[b]; slot > 0)
      std::copy_n(mBends.begin() + static_cast<std::ptrdiff_t>(slot) * kBrickVoxels, kBrickVoxels, bends.begin());
    const std::int32_t optics = mOut.opticsSlots[b];
    if (optics > 0) {
      const std::int32_t* entries = mOut.voxelOptics.data() + std::size_t(optics) * kernels::kStepVoxels;
      for (int i = 0; i < kBrickVoxels; ++i) bends[i] |= entries[i] != 0 ? kernels::kStepBendsBit : 0;
    } else if (optics < 0) {
      bends.fill(kernels::kStepBendsBit);
    }
    std::array<StepLabel, kBrickVoxels> labels;
    if (const StepLabel label = mLabels->ofBrick(brick); label != StepLabels::kMixed)
      labels.fill(label);
    else
      mLabels->ofVoxels(brick, labels);
    std::uint8_t* out = mOut.steps.data() + std::size_t(mOut.stepSlots[b]) * kernels::kStepVoxels;
    std::uint8_t any = 0;
    for (int i = 0; i < kBrickVoxels; ++i) {
      out[i] = labels[i] | bends[i];
      any |= bends[i];
    }
    mOut.bends[b] = any != 0;
  }

  const RunContext& mCtx;
  double mVoxelSize;
  StepFieldOptions mOptions;
  std::shared_ptr<const OpticsBricks> mBricks;
  const BrickGrid<float>& mIndex;
  OpticsBricks mUniform; ///< for what the bricks leave out
  OpticsGrids mOptics;
  std::optional<StepLabels> mLabels;
  std::vector<std::int64_t> mFieldBricks, mStepBricks;
  LargeVector<std::uint8_t> mBends; ///< of the voxels of bricks with fields, by slot
  FlatMediumStorage mOut;
};

} // namespace

std::int64_t assignBrickSlots(std::span<const std::int64_t> bricks, ZeroedTable<std::int32_t>& slots) {
  const auto count = static_cast<std::int64_t>(bricks.size());
  requireFieldSlots(count);
  for (std::int64_t i = 0; i < count; ++i) slots[bricks[i]] = static_cast<std::int32_t>(i + 1);
  return count + 1;
}

FlatMediumStorage flattenMedium(const Medium& medium, const StepFieldOptions& options, const RunContext& ctx) {
  requireTolerances(options);
  if (auto flat = flattenOnDevice(medium, options, ctx)) return std::move(*flat);
  return Flattener(medium, options, ctx).run();
}

} // namespace volcaustic
