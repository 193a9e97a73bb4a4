// A medium built and kept on a CUDA device. Compiled without fused multiply-add, so that it has the CPU's bits.

#include "backends/cuda_medium.h"

#include "backends/cuda_counts.cuh"
#include "backends/cuda_machine.cuh"
#include "backends/flat_pipeline.h"

#include <utility>
#include <vector>

namespace volcaustic {

namespace {

/// A device, and what is used under its being current.
class CurrentMachine {
public:
  CurrentMachine(int ordinal, std::uint64_t limit) : mOrdinal(ordinal) {
    const DeviceScope device(ordinal);
    mMachine.emplace(ordinal, limit);
  }
  ~CurrentMachine() {
    release([this] { mMachine.reset(); });
  }
  CurrentMachine(const CurrentMachine&) = delete;
  CurrentMachine& operator=(const CurrentMachine&) = delete;

  [[nodiscard]] int ordinal() const { return mOrdinal; }
  [[nodiscard]] CudaMachine& machine() { return *mMachine; }
  /// Calls work() with the device current, from a destructor.
  template <class Work>
  void release(const Work& work) const noexcept {
    try {
      const DeviceScope device(mOrdinal);
      work();
    } catch (const Error&) { // the device is gone, and its memory with it
    }
  }

private:
  int mOrdinal;
  std::optional<CudaMachine> mMachine;
};

class CudaBricks;

class CudaFlatMedium final : public DeviceFlatMedium {
public:
  CudaFlatMedium(std::shared_ptr<const CudaBricks> bricks, const kernels::StepRules& rules, float cap);
  ~CudaFlatMedium() override;
  [[nodiscard]] int ordinal() const override;
  [[nodiscard]] const kernels::FlatMedium& view() const override { return mView; }
  [[nodiscard]] FlatMediumStorage download(const RunContext& ctx) const { return mFlat->download(ctx); }

private:
  std::shared_ptr<const CudaBricks> mBricks;
  std::optional<FlatOnMachine<CudaMachine>> mFlat;
  kernels::FlatMedium mView;
};

class CudaBricks final : public DeviceBricks, public std::enable_shared_from_this<CudaBricks> {
public:
  CudaBricks(std::shared_ptr<CurrentMachine> machine, const MediumPlan& plan,
             std::span<const CountedBody<CudaMachine>> bodies)
      : mMachine(std::move(machine)) {
    mPainted.emplace(mMachine->machine(), plan, bodies);
    mMachine->machine().wait(); // what fails is known now
  }
  ~CudaBricks() override {
    mMachine->release([this] { mPainted.reset(); });
  }

  [[nodiscard]] OpticsBricks download(const RunContext& ctx) const override {
    const DeviceScope device(mMachine->ordinal());
    return mPainted->download(ctx);
  }
  [[nodiscard]] FlatMediumStorage flatten(const kernels::StepRules& rules, float cap,
                                          const RunContext& ctx) const override {
    ctx.throwIfCancelled();
    const DeviceScope device(mMachine->ordinal());
    auto flat = std::make_shared<const CudaFlatMedium>(shared_from_this(), rules, cap);
    FlatMediumStorage result = flat->download(ctx);
    result.onDevice = std::move(flat);
    return result;
  }

  [[nodiscard]] const CurrentMachine& machine() const { return *mMachine; }
  [[nodiscard]] const PaintedMedium<CudaMachine>& painted() const { return *mPainted; }

private:
  std::shared_ptr<CurrentMachine> mMachine; // outlives the arrays
  std::optional<PaintedMedium<CudaMachine>> mPainted;
};

CudaFlatMedium::CudaFlatMedium(std::shared_ptr<const CudaBricks> bricks, const kernels::StepRules& rules, float cap)
    : mBricks(std::move(bricks)) {
  mFlat.emplace(mBricks->painted(), rules, cap);
  mView = mFlat->view();
}
CudaFlatMedium::~CudaFlatMedium() {
  mBricks->machine().release([this] { mFlat.reset(); });
}
int CudaFlatMedium::ordinal() const { return mBricks->machine().ordinal(); }

class CudaMediumBuilder final : public DeviceMediumBuilder {
public:
  CudaMediumBuilder(std::uint64_t memoryLimit, int ordinal)
      : mMachine(std::make_shared<CurrentMachine>(ordinal, memoryLimit)) {}
  ~CudaMediumBuilder() override {
    mMachine->release([this] { mBodies.clear(); });
  }

  bool add(const CountTask& mesh, const Vec3i& first, const kernels::PointOptics& optics,
           const RunContext& ctx) override {
    const DeviceScope device(mMachine->ordinal());
    DeviceCounts counts = countOnDevice(mMachine->machine().stream(), mesh, ctx);
    mBodies.push_back({{first[0], first[1], first[2]},
                       {mesh.bricks[0], mesh.bricks[1], mesh.bricks[2]},
                       mesh.log2,
                       std::move(counts.fills),
                       std::move(counts.counted),
                       std::move(counts.counts),
                       optics});
    return counts.any;
  }
  void add(const BodyCounts& counts, const kernels::PointOptics& optics) override {
    const DeviceScope device(mMachine->ordinal());
    CudaMachine& machine = mMachine->machine();
    const auto copyOf = [&](const auto& host) {
      return machine.copyOf(host.data(), static_cast<std::int64_t>(host.size()), "the counts of samples");
    };
    mBodies.push_back({counts.first, counts.bricks, counts.log2, copyOf(counts.fills), copyOf(counts.counted),
                       copyOf(counts.counts), optics});
  }
  std::shared_ptr<const DeviceBricks> finish(const MediumPlan& plan) override {
    const DeviceScope device(mMachine->ordinal());
    auto bricks = std::make_shared<const CudaBricks>(mMachine, plan, mBodies);
    mBodies.clear();
    return bricks;
  }

private:
  std::shared_ptr<CurrentMachine> mMachine;
  std::vector<CountedBody<CudaMachine>> mBodies;
};

} // namespace

std::unique_ptr<DeviceMediumBuilder> makeCudaMediumBuilder(std::uint64_t memoryLimit, int ordinal) {
  return std::make_unique<CudaMediumBuilder>(memoryLimit, ordinal);
}

} // namespace volcaustic
