#include "transport/fallback.h"

#include "volcaustic/error.h"

#include <algorithm>
#include <vector>

namespace volcaustic {

namespace {

class FallbackTracer final : public PhotonTracer {
public:
  using MakeSecond = std::function<std::unique_ptr<PhotonTracer>(const std::string& error)>;

  FallbackTracer(std::unique_ptr<PhotonTracer> first, MakeSecond makeSecond)
      : mTracer(std::move(first)), mMakeSecond(std::move(makeSecond)) {}

  void emit(const kernels::EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
            const RasterCells& cells) override {
    attempt([&] { mTracer->emit(frame, reach, rows, cells); });
    remember({frame, rows, true, Reach(reach), copyOf(frame, rows, cells.stops)});
  }
  void trace(const kernels::EmissionFrame& frame, RowRange rows, const RasterCells& cells) override {
    attempt([&] { mTracer->trace(frame, rows, cells); });
    remember({frame, rows, false, {}, {}});
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
    std::vector<float> stops; ///< of the rows; empty without receivers
  };

  [[nodiscard]] std::vector<float> copyOf(const kernels::EmissionFrame& frame, RowRange rows,
                                          const float* stops) const {
    if (!stops || !mMakeSecond) return {};
    return {stops + std::int64_t{rows.begin} * frame.columns, stops + std::int64_t{rows.end} * frame.columns};
  }

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

  /// Everything done so far, once more. First bends are made again: the caller's may be gone. Landings are not: the
  /// caller has had them.
  void repeat() {
    std::vector<float> entry, stops;
    for (const Done& d : mDone) {
      entry.resize(static_cast<std::size_t>(d.frame.cells()));
      if (d.isEmission) {
        stops.resize(d.stops.empty() ? 0 : entry.size());
        std::copy(d.stops.begin(), d.stops.end(), stops.data() + std::int64_t{d.rows.begin} * d.frame.columns);
        mTracer->emit(d.frame, d.reach.view(), d.rows, {entry.data(), d.stops.empty() ? nullptr : stops.data()});
      } else {
        mTracer->trace(d.frame, d.rows, entry.data());
      }
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
