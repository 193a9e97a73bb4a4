// A medium built on one machine from the counts of its bodies to the arrays that the kernels read, without a way back
// to the host in between (docs/algorithms/cuda.md, "The medium"). The bodies are those of kernels/; a Machine runs
// them:
//
//   Array<T>                       elements in its memory: data(), size()
//   array<T>(count, what)          not set; zeros<T>() and ones<T>() set all bits; copyOf(host, count, what)
//   forEach(count, body)           body(i);  forEachBlock(count, body): body(block, shared, i), kernels/bricks.h
//   sumUp(numbers)                 each becomes the sum of those before it
//   sortUnique(keys)               sorts, and drops repetitions; returns how many are left
//   fetch(array, begin, count, host), wait()
//
// A CUDA device is one (cuda_medium.cu); the tests have another, of this machine.
#pragma once

#include "backends/flat_storage.h"
#include "backends/medium_plan.h"
#include "backends/optics_bricks.h"
#include "kernels/flattening.h"
#include "kernels/palette.h"
#include "volcaustic/error.h"
#include "volcaustic/run_context.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace volcaustic {

/// A body's counts (kernels::PaintedBody) in a machine's memory.
template <class Machine>
struct CountedBody {
  template <class T>
  using Array = typename Machine::template Array<T>;

  kernels::Int3 first, bricks;
  int log2; ///< of the sub-voxels along a voxel's edge
  Array<kernels::BrickFill> fills;
  Array<std::uint32_t> counted;
  Array<std::uint16_t> counts;
  kernels::PointOptics optics;

  [[nodiscard]] kernels::PaintedBody view() const {
    return {first, bricks, fills.data(), counted.data(), counts.data(), 1.0f / static_cast<float>(1 << (3 * log2)),
            optics};
  }
};

template <class Machine, class T>
T lastOf(Machine& machine, const typename Machine::template Array<T>& array) {
  T last{};
  machine.fetch(array, array.size() - 1, 1, &last);
  machine.wait();
  return last;
}

/// Bodies painted into the ambient medium, and the index smoothed.
template <class Machine>
class PaintedMedium {
public:
  template <class T>
  using Array = typename Machine::template Array<T>;

  /// `bodies` from low priority to high.
  PaintedMedium(Machine& machine, const MediumPlan& plan, std::span<const CountedBody<Machine>> bodies)
      : mMachine(machine), mGrids(plan.grids | kernels::kIndexBit | kernels::kCoverageBit), mAmbient(plan.ambient) {
    mLayout = {plan.dims, {(plan.dims.x + 7) / 8, (plan.dims.y + 7) / 8, (plan.dims.z + 7) / 8}};
    paint(bodies);
    blur(plan.blur, plan.weights);
  }

  [[nodiscard]] Machine& machine() const { return mMachine; }
  [[nodiscard]] const kernels::BrickLayout& layout() const { return mLayout; }
  [[nodiscard]] std::int64_t slots() const { return mSlots; }
  [[nodiscard]] std::int64_t constants() const { return mConstantCount; }
  [[nodiscard]] bool hasOptics() const { return (mGrids & kernels::kOpticsBits) != 0; }
  [[nodiscard]] const Array<std::uint8_t>& varies() const { return mVaries; }

  [[nodiscard]] kernels::PaintedBricks painted() const {
    return {
        mLayout,        mAmbient,      mGrids,           mSlotOf.data(),      mConstants.data(),  mBricks.data(),
        mVaries.data(), mIndex.data(), mCoverage.data(), mAttenuation.data(), mScattering.data(), mAsymmetry.data()};
  }
  [[nodiscard]] kernels::IndexGrid index() const {
    return {mLayout, mAmbient.index, mSmoothSlots.data(), mSmoothConstants.data(), mSmooth.data()};
  }

  /// The grids on the host. \throws Error(Input) when they are beyond the memory limit.
  [[nodiscard]] OpticsBricks download(const RunContext& ctx) const;

private:
  static constexpr const char* kWhat = "the medium's bricks";

  void paint(std::span<const CountedBody<Machine>> bodies) {
    std::vector<kernels::PaintedBody> views;
    for (const CountedBody<Machine>& body : bodies) views.push_back(body.view());
    const Array<kernels::PaintedBody> onMachine =
        mMachine.copyOf(views.data(), static_cast<std::int64_t>(views.size()), kWhat);
    const kernels::PaintedBodies all{onMachine.data(), static_cast<std::int32_t>(views.size())};
    const std::int64_t bricks = mLayout.count();
    Array<std::uint32_t> voxels = mMachine.template zeros<std::uint32_t>(bricks + 1, kWhat);
    Array<std::uint32_t> constants = mMachine.template zeros<std::uint32_t>(bricks + 1, kWhat);
    mMachine.forEach(bricks, kernels::ClassifyPainted{mLayout, all, voxels.data(), constants.data()});
    mMachine.sumUp(voxels);
    mMachine.sumUp(constants);
    mSlots = lastOf<Machine, std::uint32_t>(mMachine, voxels);
    mConstantCount = lastOf<Machine, std::uint32_t>(mMachine, constants);
    requireFieldSlots(mSlots); // which keeps all numbers below within their bits
    allocate();
    const kernels::PaintedBricks out = painted();
    mMachine.forEach(bricks, kernels::PlacePainted{out, all, voxels.data(), constants.data()});
    mMachine.forEachBlock(mSlots, kernels::PaintVoxels{out, all});
  }
  void allocate() {
    const std::int64_t voxels = mSlots * kernels::kVoxelsOfBrick;
    const auto ofGrid = [&](std::uint8_t grid) { return mGrids & grid ? voxels : 0; };
    mSlotOf = mMachine.template array<std::int32_t>(mLayout.count(), kWhat);
    mConstants = mMachine.template array<kernels::PointOptics>(mConstantCount, kWhat);
    mBricks = mMachine.template array<std::int64_t>(mSlots, kWhat);
    mVaries = mMachine.template array<std::uint8_t>(mSlots, kWhat);
    mIndex = mMachine.template array<float>(voxels, kWhat);
    mCoverage = mMachine.template array<float>(voxels, kWhat);
    mAttenuation = mMachine.template array<kernels::Float3>(ofGrid(kernels::kAttenuationBit), kWhat);
    mScattering = mMachine.template array<kernels::Float3>(ofGrid(kernels::kScatteringBit), kWhat);
    mAsymmetry = mMachine.template array<float>(ofGrid(kernels::kAsymmetryBit), kWhat);
  }

  void blur(int width, const kernels::BlurWeights& weights) {
    switch (width / 2) {
    case 0:
      return blurBy<0>(weights);
    case 1:
      return blurBy<1>(weights);
    case 2:
      return blurBy<2>(weights);
    case 3:
      return blurBy<3>(weights);
    case 4:
      return blurBy<4>(weights);
    default:
      return blurBy<5>(weights);
    }
  }
  template <int Radius>
  void blurBy(const kernels::BlurWeights& weights) {
    const std::int64_t bricks = mLayout.count();
    const kernels::PaintedIndex in(painted());
    Array<std::uint32_t> marks = mMachine.template zeros<std::uint32_t>(bricks + 1, kWhat);
    mMachine.forEach(bricks, kernels::MarkBlurred{in, marks.data()});
    mMachine.sumUp(marks);
    const std::int64_t listed = lastOf<Machine, std::uint32_t>(mMachine, marks);
    const Array<std::int64_t> list = mMachine.template array<std::int64_t>(listed, kWhat);
    mSmoothSlots = mMachine.template array<std::int32_t>(bricks, kWhat);
    mSmoothConstants = mMachine.template array<float>(bricks, kWhat);
    mMachine.forEach(bricks,
                     kernels::ListBlurred{in, marks.data(), list.data(), mSmoothSlots.data(), mSmoothConstants.data()});
    Array<std::uint32_t> numbers = mMachine.template zeros<std::uint32_t>(listed + 1, kWhat);
    kernels::BlurBricks<Radius> body{in, weights, list.data(), numbers.data(), nullptr, mSmoothSlots.data(), nullptr};
    mMachine.forEachBlock(listed, body);
    mMachine.sumUp(numbers);
    mSmoothCount = lastOf<Machine, std::uint32_t>(mMachine, numbers);
    mSmooth = mMachine.template array<float>(mSmoothCount * kernels::kVoxelsOfBrick, "the smoothed index");
    body.numbers = numbers.data();
    body.voxels = mSmooth.data();
    mMachine.forEachBlock(listed, body);
  }

  Machine& mMachine;
  kernels::BrickLayout mLayout;
  std::uint8_t mGrids;
  kernels::PointOptics mAmbient;
  std::int64_t mSlots = 0, mConstantCount = 0, mSmoothCount = 0;
  Array<std::int32_t> mSlotOf, mSmoothSlots;
  Array<kernels::PointOptics> mConstants;
  Array<std::int64_t> mBricks;
  Array<std::uint8_t> mVaries;
  Array<float> mIndex, mCoverage, mAsymmetry, mSmoothConstants, mSmooth;
  Array<kernels::Float3> mAttenuation, mScattering;
};

/// A grid on the host from a machine's: voxels of each slot, of which those of a constant brick may be given too.
template <class T, class ConstantOf>
BrickGrid<T> gridFrom(const Vec3i& dims, const T& ambient, std::span<const std::int32_t> slots,
                      const LargeVector<T>& voxels, const ConstantOf& constantOf) {
  BrickGrid<T> grid(dims, ambient);
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < grid.brickCount(); ++b)
    if (const T* constant = constantOf(b))
      grid.setConstant(b, *constant);
    else
      varying.push_back(b);
  grid.activate(varying, Fill::Later);
  for (const std::int64_t b : varying)
    std::memcpy(grid.voxels(b).data(), voxels.data() + (std::size_t(slots[b]) - 1) * kBrickVoxels,
                kBrickVoxels * sizeof(T));
  return grid;
}

template <class Machine>
OpticsBricks PaintedMedium<Machine>::download(const RunContext& ctx) const {
  const auto fetch = [&]<class T, class Host>(const Array<T>& array, std::int64_t count, LargeVector<Host>& host) {
    static_assert(sizeof(T) == sizeof(Host));
    ctx.requireMemory(static_cast<std::uint64_t>(count) * sizeof(T), "the medium from the GPU");
    host.resize(static_cast<std::size_t>(count));
    mMachine.fetch(array, 0, count, reinterpret_cast<T*>(host.data()));
    mMachine.wait();
  };
  const Vec3i dims{mLayout.dims.x, mLayout.dims.y, mLayout.dims.z};
  LargeVector<std::int32_t> slots;
  LargeVector<kernels::PointOptics> constants;
  LargeVector<std::uint8_t> varies;
  fetch(mSlotOf, mLayout.count(), slots);
  fetch(mConstants, mConstantCount, constants);
  fetch(mVaries, mSlots, varies);

  const auto painted = [&]<class T, class Host>(std::uint8_t bit, const Array<T>& array,
                                                T kernels::PointOptics::*member, Host) {
    LargeVector<Host> voxels;
    fetch(array, mSlots * kernels::kVoxelsOfBrick, voxels);
    const auto asHost = [](const T& value) { return reinterpret_cast<const Host*>(&value); };
    return gridFrom<Host>(dims, *asHost(mAmbient.*member), slots, voxels, [&](std::int64_t b) -> const Host* {
      if (slots[b] == 0) return asHost(mAmbient.*member);
      if (slots[b] < 0) return asHost(constants[-slots[b] - 1].*member);
      return varies[slots[b] - 1] & bit ? nullptr : &voxels[(std::size_t(slots[b]) - 1) * kBrickVoxels];
    });
  };
  OpticsBricks optics;
  using Point = kernels::PointOptics;
  optics.coverage = painted(kernels::kCoverageBit, mCoverage, &Point::coverage, float{});
  if (mGrids & kernels::kAttenuationBit)
    optics.attenuation = painted(kernels::kAttenuationBit, mAttenuation, &Point::attenuation, Vec3f{});
  if (mGrids & kernels::kScatteringBit)
    optics.scattering = painted(kernels::kScatteringBit, mScattering, &Point::scattering, Vec3f{});
  if (mGrids & kernels::kAsymmetryBit)
    optics.asymmetry = painted(kernels::kAsymmetryBit, mAsymmetry, &Point::asymmetry, float{});

  LargeVector<float> smooth, smoothConstants;
  fetch(mSmoothSlots, mLayout.count(), slots);
  fetch(mSmoothConstants, mLayout.count(), smoothConstants);
  fetch(mSmooth, mSmoothCount * kernels::kVoxelsOfBrick, smooth);
  optics.index = gridFrom<float>(dims, mAmbient.index, slots, smooth,
                                 [&](std::int64_t b) { return slots[b] == 0 ? &smoothConstants[b] : nullptr; });
  return optics;
}

} // namespace volcaustic
