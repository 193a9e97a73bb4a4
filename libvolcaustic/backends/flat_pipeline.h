// The arrays of kernels/flat_medium.h from a painted medium, on the machine that has painted it.
#pragma once

#include "backends/medium_pipeline.h"

#include <array>
#include <optional>

namespace volcaustic {

/// What kernels::FlatMedium points at, in a machine's memory.
template <class Machine>
class FlatOnMachine {
public:
  template <class T>
  using Array = typename Machine::template Array<T>;

  FlatOnMachine(const PaintedMedium<Machine>& medium, const kernels::StepRules& rules, float cap)
      : mMachine(medium.machine()), mMedium(medium), mRules(rules), mCap(cap), mBrickCount(medium.layout().count()) {
    packOptics();
    const bool matters = attenuationMatters(mPalette, rules.attenuationTolerance);
    mGrids.emplace(kernels::LabelledGrids{medium.index(), kernels::PaintedAttenuation(medium.painted()), matters});
    buildBand();
    coarsen();
    fillSteps();
    release();
  }

  [[nodiscard]] kernels::FlatMedium view() const {
    kernels::FlatMedium m;
    m.dims = mMedium.layout().dims;
    m.brickDims = mMedium.layout().bricks;
    m.fieldSlots = mFieldSlots.data();
    m.indexOffsets = mIndexOffsets.data();
    m.stepSlots = mStepSlots.data();
    m.opticsSlots = mOpticsSlots.data();
    m.bends = mBends.data();
    m.fields = mFields.data();
    m.steps = mSteps.data();
    m.voxelOptics = mVoxelOptics.data();
    m.optics = mOptics.data();
    m.ambientIndex = mMedium.index().ambient;
    m.ambientStep = mAmbientStep;
    m.cap = mCap;
    m.attenuates = std::any_of(mPalette.begin(), mPalette.end(),
                               [](const kernels::Optics& o) { return kernels::maxComponent(o.attenuation) > 0; });
    m.fieldCount = (mFieldCount + 1) * kernels::kFieldVoxels;
    m.stepCount = (mStepCount + 1) * kernels::kStepVoxels + kernels::kStepPadding;
    m.voxelOpticsCount = mVoxelOpticsCount;
    m.opticsCount = static_cast<std::int64_t>(mPalette.size());
    return m;
  }

  /// A copy on the host. \throws Error(Input) when it is beyond the memory limit.
  [[nodiscard]] FlatMediumStorage download(const RunContext& ctx) const {
    const kernels::FlatMedium m = view();
    FlatMediumStorage flat(m.dims, m.brickDims);
    ctx.requireMemory(static_cast<std::uint64_t>(m.fieldCount) * sizeof(kernels::FieldVoxel) +
                          static_cast<std::uint64_t>(m.stepCount) +
                          static_cast<std::uint64_t>(m.voxelOpticsCount) * sizeof(std::int32_t),
                      "stepField: index field");
    flat.fields.resize(static_cast<std::size_t>(m.fieldCount));
    flat.steps.resize(static_cast<std::size_t>(m.stepCount));
    flat.voxelOptics.resize(static_cast<std::size_t>(m.voxelOpticsCount));
    flat.optics = mPalette;
    flat.ambientIndex = m.ambientIndex;
    flat.ambientStep = m.ambientStep;
    flat.cap = m.cap;
    flat.attenuates = m.attenuates;
    mMachine.fetch(mFieldSlots, 0, mBrickCount, &flat.fieldSlots[0]);
    mMachine.fetch(mIndexOffsets, 0, mBrickCount, &flat.indexOffsets[0]);
    mMachine.fetch(mStepSlots, 0, mBrickCount, &flat.stepSlots[0]);
    mMachine.fetch(mOpticsSlots, 0, mBrickCount, &flat.opticsSlots[0]);
    mMachine.fetch(mBends, 0, mBrickCount, &flat.bends[0]);
    mMachine.fetch(mFields, 0, m.fieldCount, flat.fields.data());
    mMachine.fetch(mSteps, 0, m.stepCount, flat.steps.data());
    mMachine.fetch(mVoxelOptics, 0, m.voxelOpticsCount, flat.voxelOptics.data());
    mMachine.wait();
    return flat;
  }

private:
  static constexpr const char* kWhat = "the medium";
  using Numbers = Array<std::uint32_t>;

  Numbers counts(std::int64_t count) { return mMachine.template zeros<std::uint32_t>(count + 1, kWhat); }
  /// Turns counts into sums and tells the sum of all.
  std::int64_t sumUp(Numbers& numbers) {
    mMachine.sumUp(numbers);
    return lastOf<Machine, std::uint32_t>(mMachine, numbers);
  }

  void packOptics() {
    const kernels::PaintedBricks painted = mMedium.painted();
    const kernels::OpticsKey ambient(painted.ambient);
    mOpticsSlots = mMachine.template zeros<std::int32_t>(mBrickCount, kWhat);
    std::vector<kernels::OpticsKey> keys{ambient};
    if (mMedium.hasOptics()) {
      Numbers varying = counts(mMedium.slots());
      mMachine.forEach(mMedium.slots(), kernels::MarkVaryingOptics{mMedium.varies().data(), varying.data()});
      mVoxelOpticsCount = (sumUp(varying) + 1) * kernels::kStepVoxels;
      for (std::uint64_t seed = 1;
           !numberOptics({painted, mMedium.constants(), mMedium.slots(), varying.data(), seed}, keys);)
        ++seed;
    } else {
      mVoxelOpticsCount = kernels::kStepVoxels;
      mVoxelOptics = mMachine.template zeros<std::int32_t>(mVoxelOpticsCount, kWhat);
    }
    const auto h = static_cast<float>(mRules.voxelSize);
    for (const kernels::OpticsKey& key : keys)
      mPalette.push_back({kernels::Float3(key.of[0], key.of[1], key.of[2]) * h,
                          kernels::Float3(key.of[3], key.of[4], key.of[5]) * h, key.of[6]});
    mOptics = mMachine.copyOf(mPalette.data(), static_cast<std::int64_t>(mPalette.size()), kWhat);
  }
  /// False when two keys had the same hash.
  bool numberOptics(const kernels::PaletteItems& items, std::vector<kernels::OpticsKey>& keys) {
    const std::int64_t places = mVoxelOpticsCount + items.constants + items.slots;
    requirePlaces(places);
    Array<std::uint64_t> hashes = mMachine.template zeros<std::uint64_t>(places, kPalette);
    forEachKey(items, kernels::WriteHashes{items, hashes.data()});
    const std::int64_t count = mMachine.sortUnique(hashes);
    const kernels::PaletteNumbers numbers{hashes.data(), count};
    Numbers firsts = mMachine.template ones<std::uint32_t>(count, kPalette);
    mVoxelOptics = mMachine.template zeros<std::int32_t>(places, kPalette);
    forEachKey(items, kernels::WriteNumbers{items, numbers, firsts.data(), mVoxelOptics.data()});
    keys.resize(static_cast<std::size_t>(count), keys[0]);
    Array<kernels::OpticsKey> onMachine = mMachine.copyOf(keys.data(), count, kPalette);
    forEachKey(items, kernels::WriteOptics{items, firsts.data(), mVoxelOptics.data(), onMachine.data()});
    Numbers wrong = mMachine.template zeros<std::uint32_t>(1, kPalette);
    forEachKey(items, kernels::CheckOptics{mVoxelOptics.data(), onMachine.data(), wrong.data()});
    mMachine.fetch(onMachine, 0, count, keys.data());
    if (lastOf<Machine, std::uint32_t>(mMachine, wrong) > 0) return false;
    mMachine.forEach(mBrickCount, kernels::PlaceOptics{items, mVoxelOptics.data(), mOpticsSlots.data()});
    return true;
  }
  static void requirePlaces(std::int64_t places) {
    if (places > 0x7fffffff)
      throw Error(ErrorKind::Input, "stepField: optics: more than 2^31 voxels differ; lower the resolution");
  }
  template <class Visit>
  void forEachKey(const kernels::PaletteItems& items, const Visit& visit) {
    mMachine.forEach(items.constants, kernels::ForConstants<Visit>{items, visit});
    mMachine.forEachBlock(items.slots, kernels::ForSlots<Visit>{items, visit});
  }

  void buildBand() {
    mBand = counts(mBrickCount);
    Numbers fieldNumbers = counts(mBrickCount);
    mMachine.forEach(mBrickCount, kernels::MarkBand{*mGrids, mBand.data(), fieldNumbers.data()});
    mBandCount = sumUp(mBand);
    mFieldCount = sumUp(fieldNumbers);
    requireFieldSlots(mFieldCount);
    const Array<std::int64_t> list = mMachine.template array<std::int64_t>(mBandCount, kWhat);
    mMachine.forEach(mBrickCount, kernels::ListBricks{mBand.data(), list.data()});
    mBandBricks = mMachine.template array<kernels::BandBrick>(mBandCount, kWhat);
    mFieldSlots = mMachine.template zeros<std::int32_t>(mBrickCount, kWhat);
    mIndexOffsets = mMachine.template zeros<float>(mBrickCount, kWhat);
    mFields = mMachine.template array<kernels::FieldVoxel>((mFieldCount + 1) * kernels::kFieldVoxels, kWhat);
    mFieldBends = mMachine.template array<std::uint8_t>((mFieldCount + 1) * kernels::kVoxelsOfBrick, kWhat);
    mMachine.forEach(kernels::kFieldVoxels, kernels::SetAll<kernels::FieldVoxel>{mFields.data(), {1, 0, 0, 0}});
    mMachine.forEachBlock(mBandCount,
                          kernels::BuildBandBricks{*mGrids, mRules, list.data(), fieldNumbers.data(),
                                                   mBandBricks.data(), mFieldSlots.data(), mIndexOffsets.data(),
                                                   mFields.data(), mFieldBends.data()});
  }

  void coarsen() {
    mLabels.emplace(kernels::LabelPyramid{*mGrids, mRules, mBand.data(), mBandBricks.data(), {}, {}, 1});
    kernels::LabelPyramid& p = *mLabels;
    p.dims[0] = mMedium.layout().bricks;
    const auto cubes = [](const kernels::Int3& d) { return kernels::BrickLayout{{}, d}.count(); };
    for (; p.count < kernels::LabelPyramid::kMostLevels && cubes(p.dims[p.count - 1]) > 1; ++p.count) {
      const kernels::Int3 fine = p.dims[p.count - 1];
      p.dims[p.count] = {(fine.x + 1) / 2, (fine.y + 1) / 2, (fine.z + 1) / 2};
      mCubes.push_back(mMachine.template array<kernels::CubeState>(cubes(p.dims[p.count]), kWhat));
      p.levels[p.count] = mCubes.back().data();
      mMachine.forEach(mCubes.back().size(),
                       kernels::CoarsenCubes{*mGrids, mRules, p.count + 3, fine, p.dims[p.count],
                                             p.count == 1 ? mBand.data() : nullptr, mBandBricks.data(),
                                             p.levels[p.count - 1], mCubes.back().data()});
    }
  }

  void fillSteps() {
    constexpr std::int64_t kBytes = 256;
    const Array<std::uint16_t> bytes = mMachine.template array<std::uint16_t>(mBrickCount, kWhat);
    Numbers frequency = mMachine.template zeros<std::uint32_t>(kBytes, kWhat), own = counts(mBrickCount);
    mBends = mMachine.template array<std::uint8_t>(mBrickCount, kWhat);
    mMachine.forEach(mBrickCount, kernels::ClassifySteps{*mLabels, mFieldSlots.data(), mOpticsSlots.data(),
                                                         bytes.data(), frequency.data(), own.data(), mBends.data()});
    std::array<std::uint32_t, kBytes> most{};
    mMachine.fetch(frequency, 0, kBytes, most.data());
    mStepCount = sumUp(own);
    mAmbientStep = static_cast<std::int32_t>(std::max_element(most.begin(), most.end()) - most.begin());
    const Array<std::int64_t> list = mMachine.template array<std::int64_t>(mStepCount, kWhat);
    mStepSlots = mMachine.template array<std::int32_t>(mBrickCount, kWhat);
    mMachine.forEach(mBrickCount,
                     kernels::PlaceSteps{bytes.data(), own.data(), mAmbientStep, mStepSlots.data(), list.data()});
    const std::int64_t first = kernels::kStepVoxels, count = (mStepCount + 1) * first + kernels::kStepPadding;
    mSteps = mMachine.template zeros<std::uint8_t>(count, kWhat);
    mMachine.forEach(first, kernels::SetAll<std::uint8_t>{mSteps.data(), static_cast<std::uint8_t>(mAmbientStep)});
    mMachine.forEachBlock(mStepCount,
                          kernels::FillSteps{*mLabels, mFieldSlots.data(), mOpticsSlots.data(), mVoxelOptics.data(),
                                             mFieldBends.data(), list.data(), mSteps.data(), mBends.data()});
  }

  /// Of what only the building needs.
  void release() {
    mBand = {};
    mBandBricks = {};
    mFieldBends = {};
    mCubes.clear();
  }

  static constexpr const char* kPalette = "the palette of optics";

  Machine& mMachine;
  const PaintedMedium<Machine>& mMedium;
  const kernels::StepRules mRules;
  const float mCap;
  const std::int64_t mBrickCount;
  std::optional<kernels::LabelledGrids> mGrids;
  std::optional<kernels::LabelPyramid> mLabels;
  std::int64_t mVoxelOpticsCount = 0, mBandCount = 0, mFieldCount = 0, mStepCount = 0;
  std::int32_t mAmbientStep = 0;
  std::vector<kernels::Optics> mPalette;
  Numbers mBand;
  Array<kernels::BandBrick> mBandBricks;
  std::vector<Array<kernels::CubeState>> mCubes;
  Array<std::int32_t> mOpticsSlots, mVoxelOptics, mFieldSlots, mStepSlots;
  Array<float> mIndexOffsets;
  Array<kernels::FieldVoxel> mFields;
  Array<std::uint8_t> mFieldBends, mSteps, mBends;
  Array<kernels::Optics> mOptics;
};

} // namespace volcaustic
