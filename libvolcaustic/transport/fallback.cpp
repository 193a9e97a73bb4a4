#include "transport/fallback.h"

#include "volcaustic/error.h"

#include <vector>

namespace volcaustic {

namespace {

class FallbackTracer final : public PhotonTracer {
public:
  using MakeSecond = std::function<std::unique_ptr<PhotonTracer>(const std::string& error)>;

  FallbackTracer(std::unique_ptr<PhotonTracer> first, MakeSecond makeSecond)
      : mTracer(std::move(first)), mMakeSecond(std::move(makeSecond)) {}

  void emit(const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
            float* entry) override {
    attempt([&] { mTracer->emit(frame, reach, rows, entry); });
    remember({frame, rows, true, Reach(reach)});
  }
  void trace(const kernels::EmissionFrame& frame, RowRange rows, const float* entry) override {
    attempt([&] { mTracer->trace(frame, rows, entry); });
    remember({frame, rows, false, {}});
  }
  void wait() override {
    attempt([&] { mTracer->wait(); });
  }
  void finish() override {
    attempt([&] { mTracer->finish(); });
  }

  [[nodiscard]] bool touched(std::int64_t block) const override { return mTracer->touched(block); }
  void addBlock(std::int64_t block, BlockSums& sums) const override { mTracer->addBlock(block, sums); }
  [[nodiscard]] PhotonTally tally() const override { return mTracer->tally(); }
  [[nodiscard]] std::uint64_t peakBytes() const override { return mTracer->peakBytes(); }

private:
  /// A copy of a RasterReach: the caller's may be gone when it is needed again.
  class Reach {
  public:
    Reach() = default;
    explicit Reach(const kernels::RasterReach& r) : mView(r) {
      const std::size_t tiles = static_cast<std::size_t>(r.columns) * r.rows;
      mNearest.assign(r.nearest, r.nearest + tiles);
      mFarthest.assign(r.farthest, r.farthest + tiles);
    }
    [[nodiscard]] kernels::RasterReach view() const {
      kernels::RasterReach reach = mView;
      reach.nearest = mNearest.data();
      reach.farthest = mFarthest.data();
      return reach;
    }

  private:
    kernels::RasterReach mView;
    std::vector<float> mNearest, mFarthest;
  };

  /// A call that has been carried out.
  struct Done {
    kernels::EmissionFrame frame;
    RowRange rows;
    bool isEmission;
    Reach reach;
  };

  void remember(Done done) {
    if (mMakeSecond) mDone.push_back(std::move(done));
  }

  template <class Call>
  void attempt(const Call& call) {
    try {
      return call();
    } catch (const Error& e) {
      if (e.kind() != ErrorKind::Device || !mMakeSecond) throw;
      mTracer.reset(); // its memory first
      mTracer = mMakeSecond(e.what());
    }
    mMakeSecond = {};
    repeat();
    call();
  }

  /// Everything done so far, once more. First bends are made again: the caller's may be gone.
  void repeat() {
    std::vector<float> entry;
    for (const Done& d : mDone) {
      entry.resize(static_cast<std::size_t>(d.frame.cells()));
      if (d.isEmission)
        mTracer->emit(d.frame, d.reach.view(), d.rows, entry.data());
      else
        mTracer->trace(d.frame, d.rows, entry.data());
    }
    mDone.clear();
  }

  std::unique_ptr<PhotonTracer> mTracer;
  MakeSecond mMakeSecond; ///< empty once it was used
  std::vector<Done> mDone;
};

} // namespace

std::unique_ptr<PhotonTracer>
makeFallbackTracer(std::unique_ptr<PhotonTracer> first,
                   std::function<std::unique_ptr<PhotonTracer>(const std::string& error)> makeSecond) {
  return std::make_unique<FallbackTracer>(std::move(first), std::move(makeSecond));
}

} // namespace volcaustic
