// The photon pass on a CUDA device: the bodies of kernels/ as they stand, a thread for a photon
// (docs/algorithms/cuda.md).

#include "backends/cuda_arrays.cuh"

namespace volcaustic {

namespace {

using kernels::EmissionBody;
using kernels::EmissionFrame;
using kernels::PhotonBody;

constexpr int kBlock = 128; // threads
// Blocks that a multiprocessor is to hold: threads that hide each other's loads, against registers for each. With 3 a
// thread has 168 and keeps nearly everything in them; with 4 (128) it keeps half a kilobyte in memory.
constexpr int kLeastBlocks = 3;
constexpr int kWarp = 32;
constexpr unsigned kAllLanes = 0xffffffffu;
// A warp takes a tile of the raster, so that its rays stay together.
constexpr int kTileColumns = 8, kTileRows = kWarp / kTileColumns;
// Cells that one launch carries; between launches the run can be cancelled, and tells its progress.
constexpr std::int64_t kLaunchCells = 1 << 20;

/// Photons of a launch that wait to be carried.
struct PhotonQueue {
  std::uint32_t* cells;
  std::uint32_t* count; ///< filled
  std::uint32_t* next;  ///< taken
};

/// Calls visit(cell, inside) for the cells of rows [begin, end), a warp for a tile; lanes beyond the raster come with
/// inside = false, so that all lanes of a warp take part in every call.
template <class Visit>
__device__ void forEachCell(std::int32_t columns, RowRange rows, const Visit& visit) {
  const std::int64_t tileColumns = (columns + kTileColumns - 1) / kTileColumns;
  const std::int64_t tiles = tileColumns * ((rows.end - rows.begin + kTileRows - 1) / kTileRows);
  const int lane = threadIdx.x % kWarp;
  const std::int64_t warps = static_cast<std::int64_t>(gridDim.x) * (kBlock / kWarp);
  for (std::int64_t tile = blockIdx.x * (kBlock / kWarp) + threadIdx.x / kWarp; tile < tiles; tile += warps) {
    const std::int64_t column = tile % tileColumns * kTileColumns + lane % kTileColumns;
    const std::int64_t row = rows.begin + tile / tileColumns * kTileRows + lane / kTileColumns;
    visit(row * columns + column, column < columns && row < rows.end);
  }
}

__global__ void __launch_bounds__(kBlock, kLeastBlocks)
    emitRows(EmissionBody<DeviceSink> body, RowRange rows, DeviceSums sums) {
  DeviceSink sink(sums);
  forEachCell(body.frame.columns, rows, [&](std::int64_t cell, bool inside) {
    if (inside) body(cell, sink);
  });
  sink.addTotals();
}

/// Appends the cells with a bend to the queue, those of a tile side by side.
__global__ void __launch_bounds__(kBlock, kLeastBlocks)
    queuePhotons(const float* entry, std::int32_t columns, RowRange rows, PhotonQueue queue) {
  const unsigned lane = threadIdx.x % kWarp;
  forEachCell(columns, rows, [&](std::int64_t cell, bool inside) {
    const bool bends = inside && entry[cell] != kernels::kNeverBends;
    const unsigned all = __ballot_sync(kAllLanes, bends);
    unsigned first = 0;
    if (lane == 0 && all) first = atomicAdd(queue.count, static_cast<unsigned>(__popc(all)));
    first = __shfl_sync(kAllLanes, first, 0);
    if (bends) queue.cells[first + __popc(all & ((1u << lane) - 1))] = static_cast<std::uint32_t>(cell);
  });
}

/// Each warp takes the next photons of the queue until it is empty.
__global__ void __launch_bounds__(kBlock, kLeastBlocks)
    tracePhotons(PhotonBody<DeviceSink> body, PhotonQueue queue, DeviceSums sums) {
  DeviceSink sink(sums);
  const unsigned count = *queue.count, lane = threadIdx.x % kWarp;
  while (true) {
    unsigned first = 0;
    if (lane == 0) first = atomicAdd(queue.next, static_cast<unsigned>(kWarp));
    first = __shfl_sync(kAllLanes, first, 0);
    if (first >= count) break;
    if (first + lane < count) {
      body(first + lane, sink);
      sink.flush();
    }
  }
  sink.addTotals();
}

/// As many blocks as the device holds at once. \throws Error(Device) where it has no code for the kernel.
template <class... Parameters>
int residentBlocks(void (*kernel)(Parameters...), int ordinal) {
  int perProcessor = 0, processors = 0;
  check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&perProcessor, kernel, kBlock, 0), ordinal,
        "cannot run this build's kernels");
  check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, ordinal), ordinal, "cannot be used");
  return std::max(perProcessor, 1) * std::max(processors, 1);
}

/// A pass on one device, which must be current on the calling thread for every member.
class CudaPass {
public:
  CudaPass(const TracerSetup& setup, const RunContext& ctx, int ordinal)
      : mCtx(ctx)
      , mRules(setup.rules)
      , mEmitBlocks(residentBlocks(emitRows, ordinal))
      , mQueueBlocks(residentBlocks(queuePhotons, ordinal))
      , mTraceBlocks(residentBlocks(tracePhotons, ordinal))
      , mStream(ordinal, "photons")
      , mMedium(mStream, setup.medium, setup.onDevice)
      , mReceivers(mStream, setup.rules.receivers)
      , mLight(mStream, setup, ctx)
      , mQueueEnds(mStream, 2, kQueue)
      , mInFlight(mStream)
      , mDone(mStream) {}

  void emit(const EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows, const RasterCells& cells) {
    mEntry.prepare(mStream, frame);
    const std::int64_t tiles = static_cast<std::int64_t>(reach.columns) * reach.rows;
    const DeviceArray<float> nearest(mStream, reach.nearest, tiles, kRaster);
    const DeviceArray<float> farthest(mStream, reach.farthest, tiles, kRaster);
    const std::int64_t from = std::int64_t{rows.begin} * frame.columns;
    DeviceArray<float> stops;
    if (cells.stops) stops = DeviceArray<float>(mStream, cells.stops + from, cellsOf(frame, rows), kRaster);
    EmissionBody<DeviceSink> body{};
    body.medium = mMedium.view();
    body.frame = frame;
    body.view = kernels::rasterView(frame);
    body.reach = {reach.columns, reach.rows, nearest.data(), farthest.data()};
    body.entry = mEntry.data();
    body.stops = stops.data();
    body.stopsFrom = from;
    forEachLaunch(frame, rows, {}, [&](RowRange part) {
      launch(emitRows, std::min(mEmitBlocks, blocksFor(frame, part)), body, part, mLight.view());
    });
    mEntry.know(rows);
    mEntry.download(rows, cells.entry);
    wait();
  }

  void trace(const EmissionFrame& frame, RowRange rows, const RasterCells& cells) {
    mEntry.prepare(mStream, frame);
    mEntry.fetch(rows, cells.entry);
    const std::int64_t room = rowsOfLaunch(frame) * frame.columns;
    if (!mQueue.data() || mQueue.size() < room) {
      mQueue = {}; // before the new one is asked for
      mQueue = DeviceArray<std::uint32_t>(mStream, room, kQueue);
    }
    const PhotonQueue queue{mQueue.data(), mQueueEnds.data(), mQueueEnds.data() + 1};
    PhotonBody<DeviceSink> body{};
    body.medium = mMedium.view();
    body.frame = frame;
    body.entry = mEntry.data();
    body.cells = mQueue.data();
    body.rules = mRules;
    body.rules.receivers = mReceivers.view();
    const std::int64_t from = std::int64_t{rows.begin} * frame.columns, count = cellsOf(frame, rows);
    DeviceArray<kernels::Landing> landings;
    if (cells.landings) {
      landings = DeviceArray<kernels::Landing>(mStream, cells.landings + from, count, kRaster);
      body.landings = landings.data();
      body.landingsFrom = from;
    }
    forEachLaunch(frame, rows, "photons", [&](RowRange part) {
      const int needed = blocksFor(frame, part);
      mQueueEnds.fill(0);
      launch(queuePhotons, std::min(mQueueBlocks, needed), static_cast<const float*>(mEntry.data()), frame.columns,
             part, queue);
      launch(tracePhotons, std::min(mTraceBlocks, needed), body, queue, mLight.view());
    });
    if (!cells.landings) return;
    landings.download(cells.landings + from, 0, count);
    wait();
  }

  void wait() {
    mDone.record();
    mDone.wait();
  }
  void finish() { mLight.download(mStream, mDone, mCtx); }

  [[nodiscard]] const DeviceLight& light() const { return mLight; }
  [[nodiscard]] std::uint64_t peakBytes() const { return mStream.peakBytes(); }

private:
  static constexpr const char* kQueue = "the photon queue";
  static constexpr const char* kRaster = "the light raster";

  static std::int64_t cellsOf(const EmissionFrame& frame, RowRange rows) {
    return std::int64_t{rows.end - rows.begin} * frame.columns;
  }
  static std::int64_t rowsOfLaunch(const EmissionFrame& frame) {
    return std::clamp<std::int64_t>(kLaunchCells / frame.columns / kTileRows * kTileRows, kTileRows,
                                    std::max(frame.rows, kTileRows));
  }
  /// Blocks that have a tile each of their warps can start with.
  static int blocksFor(const EmissionFrame& frame, RowRange rows) {
    const std::int64_t tiles = static_cast<std::int64_t>((frame.columns + kTileColumns - 1) / kTileColumns) *
                               ((rows.end - rows.begin + kTileRows - 1) / kTileRows);
    constexpr int kTilesOfBlock = kBlock / kWarp;
    return static_cast<int>(std::clamp<std::int64_t>((tiles + kTilesOfBlock - 1) / kTilesOfBlock, 1, 1 << 30));
  }

  /// Calls submit(part) for the rows part by part, with few parts in flight; between them the run can be cancelled, and
  /// tells its progress under `stage`.
  template <class Submit>
  void forEachLaunch(const EmissionFrame& frame, RowRange rows, std::string_view stage, const Submit& submit) {
    const auto step = static_cast<std::int32_t>(rowsOfLaunch(frame));
    for (std::int32_t row = rows.begin; row < rows.end;) {
      const RowRange part{row, rows.end - row > step ? row + step : rows.end};
      mInFlight.launch([&] {
        if (stage.empty())
          mCtx.throwIfCancelled();
        else
          mCtx.progress(stage, static_cast<double>(row - rows.begin) / (rows.end - rows.begin));
        submit(part);
      });
      row = part.end;
    }
  }

  template <class... Parameters, class... Arguments>
  void launch(void (*kernel)(Parameters...), int blocks, const Arguments&... arguments) {
    launchKernel(mStream, kernel, blocks, kBlock, arguments...);
  }

  const RunContext mCtx;
  const kernels::PhotonRules mRules;
  const int mEmitBlocks, mQueueBlocks, mTraceBlocks;
  DeviceStream mStream; // the arrays below are freed in its order
  DeviceMedium mMedium;
  DeviceReceivers mReceivers;
  DeviceLight mLight;
  DeviceEntry mEntry;
  DeviceArray<std::uint32_t> mQueue, mQueueEnds; ///< cells; filled, taken
  FewInFlight mInFlight;
  DeviceEvent mDone;
};

/// The pass behind the interface, with its device current while it works.
class CudaTracer final : public PhotonTracer {
public:
  CudaTracer(const TracerSetup& setup, const RunContext& ctx, int ordinal) : mOrdinal(ordinal) {
    const DeviceScope device(mOrdinal);
    mPass = std::make_unique<CudaPass>(setup, ctx, ordinal);
    mPass->wait(); // an upload that fails is known now
  }
  ~CudaTracer() override {
    try {
      const DeviceScope device(mOrdinal);
      mPass.reset();
    } catch (const Error&) { // the device is gone, and its memory with it
    }
  }

  void emit(const EmissionFrame& frame, const kernels::RasterReach& reach, RowRange rows,
            const RasterCells& cells) override {
    if (rows.begin >= rows.end) return;
    const DeviceScope device(mOrdinal);
    mPass->emit(frame, reach, rows, cells);
  }
  void trace(const EmissionFrame& frame, RowRange rows, const RasterCells& cells) override {
    if (rows.begin >= rows.end) return;
    const DeviceScope device(mOrdinal);
    mPass->trace(frame, rows, cells);
  }
  void wait() override {
    const DeviceScope device(mOrdinal);
    mPass->wait();
  }
  void finish() override {
    const DeviceScope device(mOrdinal);
    mPass->finish();
  }

  [[nodiscard]] bool touched(std::int64_t block) const override { return mPass->light().touched(block); }
  void addBlock(std::int64_t block, BlockSums& sums) const override { mPass->light().addBlock(block, sums); }
  [[nodiscard]] PhotonTally tally() const override { return mPass->light().tally(); }
  [[nodiscard]] std::uint64_t peakBytes() const override { return mPass->peakBytes(); }

private:
  const int mOrdinal;
  std::unique_ptr<CudaPass> mPass;
};

} // namespace

std::unique_ptr<PhotonTracer> makeCudaTracer(const TracerSetup& setup, const RunContext& ctx, int ordinal) {
  return std::make_unique<CudaTracer>(setup, ctx, ordinal);
}

} // namespace volcaustic
