// Voxelising on a CUDA device: the order of the kernels of cuda_rows.cuh, and the memory they need
// (docs/algorithms/cuda.md).

#include "backends/cuda_memory.cuh"
#include "backends/cuda_rows.cuh"
#include "core/large_memory.h"

#include <algorithm>
#include <array>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace volcaustic {

namespace {

using kernels::Crossing;

constexpr const char* kWhat = "voxelising";
constexpr int kThreads = 128; // of a block whose threads work alone
// Items that one launch tries: between launches the run can be cancelled.
constexpr std::int64_t kLaunchItems = 1 << 22;
// The part of the free memory that pages may take; the rest is for the counts, and for whoever else uses the device.
constexpr double kPagesPart = 0.5;
// Extra crossings that a brick gets room for at first: where surfaces coincide there are more, and the room grows.
constexpr std::int64_t kExtraOfBrick = 8;

std::int64_t blocksFor(std::int64_t threads) { return (threads + kThreads - 1) / kThreads; }

/// Each number becomes the sum of those before it.
template <class T>
void sumUp(DeviceStream& stream, DeviceArray<T>& numbers) {
  std::size_t bytes = 0;
  const auto scan = [&](void* room) {
    check(cub::DeviceScan::ExclusiveSum(room, bytes, numbers.data(), numbers.data(), numbers.size(), stream.get()),
          stream.ordinal(), kWhat);
  };
  scan(nullptr);
  const DeviceArray<std::uint8_t> room(stream, static_cast<std::int64_t>(bytes), kWhat);
  scan(room.data());
}

void sortKeys(DeviceStream& stream, const DeviceArray<ExtraKey>& keys, DeviceArray<ExtraKey>& sorted,
              std::int64_t count) {
  std::size_t bytes = 0;
  const auto sort = [&](void* room) {
    check(cub::DeviceRadixSort::SortKeys(room, bytes, static_cast<const ExtraKey*>(keys.data()), sorted.data(), count,
                                         0, 64, stream.get()),
          stream.ordinal(), kWhat);
  };
  sort(nullptr);
  const DeviceArray<std::uint8_t> room(stream, static_cast<std::int64_t>(bytes), kWhat);
  sort(room.data());
}

/// A mesh in device memory, and its crossings with rows.
class RowCrossings {
public:
  RowCrossings(DeviceStream& stream, const CountTask& task, const RunContext& ctx)
      : mCtx(ctx)
      , mStream(stream)
      , mDone(stream)
      , mInFlight(stream)
      , mLattice{task.bricks[0], task.bricks[1], task.bricks[2], task.log2}
      , mPoints(stream, task.points.data(), static_cast<std::int64_t>(task.points.size()), kMesh)
      , mTriangles(stream, task.triangles.data()->data(), 3 * static_cast<std::int64_t>(task.triangles.size()), kMesh)
      , mFirstOfItems(stream, static_cast<std::int64_t>(task.triangles.size()) + 1, kMesh)
      , mMesh{mPoints.data(), mTriangles.data(), mFirstOfItems.data(),
              static_cast<std::int64_t>(task.triangles.size())} {
    if (mLattice.bricks() >= std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorKind::Device, cudaName(stream.ordinal()) + ": more than 2^32 bricks of voxels; lower the "
                                                                  "resolution or use --device cpu");
    DeviceArray<unsigned> numbers(stream, 1, kMesh);
    numbers.fill(0);
    mFirstOfItems.fill(0);
    launchKernel(stream, countItems, blocksFor(mMesh.count), kThreads, mMesh, mLattice, mFirstOfItems.data(),
                 numbers.data());
    sumUp(stream, mFirstOfItems);
    mFirstOfItems.download(&mItems, mMesh.count, 1);
    numbers.download(&mNumbers, 0, 1);
    wait();
  }

  [[nodiscard]] const DeviceLattice& lattice() const { return mLattice; }

  /// Calls visit(column, crossing) on the device for all crossings.
  template <class Visit>
  void forEach(const Visit& visit) {
    crossAs<double>(visit);
    crossAs<std::int64_t>(visit);
    crossAs<__int128>(visit);
  }
  void wait() {
    mDone.record();
    mDone.wait();
  }

private:
  static constexpr const char* kMesh = "the mesh";

  template <class N, class Visit>
  void crossAs(const Visit& visit) {
    if (!(mNumbers & 1u << kNumbers<N>)) return;
    for (std::int64_t first = 0; first < mItems; first += kLaunchItems)
      mInFlight.launch([&] {
        mCtx.throwIfCancelled();
        const std::int64_t end = std::min(first + kLaunchItems, mItems);
        launchKernel(mStream, crossItems<N, Visit>, blocksFor(end - first), kThreads, mMesh, mLattice, first, end,
                     visit);
      });
  }

  const RunContext& mCtx;
  DeviceStream& mStream;
  DeviceEvent mDone;
  FewInFlight mInFlight;
  DeviceLattice mLattice;
  DeviceArray<double> mPoints;
  DeviceArray<std::uint32_t> mTriangles;
  DeviceArray<std::int64_t> mFirstOfItems;
  DeviceMesh mMesh;
  std::int64_t mItems = 0;
  unsigned mNumbers = 0;
};

/// The bricks that triangles cross, numbered in order.
class TouchedBricks {
public:
  TouchedBricks(DeviceStream& stream, RowCrossings& crossings)
      : mSlots(stream, crossings.lattice().bricks() + 1, kBricks) {
    const DeviceLattice& lattice = crossings.lattice();
    mSlots.fill(0);
    crossings.forEach(MarkBricks{mSlots.data(), lattice.bricksZ});
    sumUp(stream, mSlots);
    const DeviceArray<std::uint32_t> first(stream, lattice.columns() + 1, kBricks);
    launchKernel(stream, slotsOfColumns, blocksFor(lattice.columns() + 1), kThreads,
                 static_cast<const std::uint32_t*>(mSlots.data()), lattice, first.data());
    mFirstOfColumn.resize(static_cast<std::size_t>(lattice.columns()) + 1);
    first.download(mFirstOfColumn.data(), 0, first.size());
    crossings.wait();
  }

  [[nodiscard]] const std::uint32_t* slots() const { return mSlots.data(); }
  /// Touched bricks before a column.
  [[nodiscard]] std::uint32_t before(std::int64_t column) const { return mFirstOfColumn[column]; }
  /// Of columns [begin, end).
  [[nodiscard]] std::int64_t within(std::int64_t begin, std::int64_t end) const {
    return std::int64_t{before(end)} - before(begin);
  }

private:
  static constexpr const char* kBricks = "the table of bricks";

  DeviceArray<std::uint32_t> mSlots;
  std::vector<std::uint32_t> mFirstOfColumn;
};

template <class Word>
struct ColumnKernels {
  void (*fill)(ColumnSweep<Word>);
  void (*count)(ColumnSweep<Word>);
  int threads;
};
/// Columns of bricks, as many at a time as memory holds pages for.
template <class Word>
class ColumnCounter {
public:
  ColumnCounter(DeviceStream& stream, RowCrossings& crossings, const ColumnKernels<Word>& kernels,
                const RunContext& ctx)
      : mCtx(ctx), mStream(stream), mCrossings(crossings), mKernels(kernels), mTouched(stream, crossings) {}

  void run(const TakeBricks& take) {
    const std::int64_t columns = lattice().columns(), room = roomForPages();
    for (std::int64_t begin = 0; begin < columns;) {
      std::int64_t end = begin + 1;
      while (end < columns && mTouched.within(begin, end + 1) <= room && end - begin < kMostColumns) ++end;
      if (mTouched.within(begin, end) > room) refuse(mTouched.within(begin, end));
      count(begin, end, take);
      mCtx.progress("voxelise", static_cast<double>(end) / static_cast<double>(columns));
      begin = end;
    }
  }

private:
  static constexpr const char* kPages = "the rows of sub-voxels";
  static constexpr const char* kExtra = "crossings at the same sample";
  static constexpr const char* kCounts = "the counts of samples";
  static constexpr std::int64_t kMostColumns = std::numeric_limits<std::int32_t>::max(); // blocks of a launch

  [[nodiscard]] const DeviceLattice& lattice() const { return mCrossings.lattice(); }
  [[nodiscard]] std::int32_t rows() const { return 1 << (2 * lattice().brickLog2()); }
  [[nodiscard]] std::uint64_t pageBytes() const {
    return 2 * static_cast<std::uint64_t>(rows()) * sizeof(Word) + sizeof(ExtraRange) +
           kExtraOfBrick * sizeof(ExtraKey);
  }
  [[nodiscard]] std::int64_t roomForPages() const {
    const std::uint64_t limit = mCtx.effectiveMemoryLimit(), used = mStream.usedBytes();
    const std::uint64_t bytes =
        std::min(static_cast<std::uint64_t>(kPagesPart * static_cast<double>(mStream.freeBytes())),
                 limit > used ? limit - used : 0);
    return static_cast<std::int64_t>(bytes / pageBytes());
  }
  [[noreturn]] void refuse(std::int64_t pages) const {
    throw Error(ErrorKind::Device, cudaName(mStream.ordinal()) + ": out of memory for " + kPages + " (" +
                                       std::to_string((static_cast<std::uint64_t>(pages) * pageBytes()) >> 20) +
                                       " MiB asked for); lower the resolution, raise --memory-limit or use --device "
                                       "cpu");
  }

  /// Columns [begin, end), whose pages fit.
  void count(std::int64_t begin, std::int64_t end, const TakeBricks& take) {
    const std::int64_t pages = mTouched.within(begin, end), bricks = (end - begin) * lattice().bricksZ;
    mCtx.requireMemory(static_cast<std::uint64_t>(bricks), "voxelising: bricks from the GPU");
    mHostFills.assign(static_cast<std::size_t>(bricks), BrickFill::Empty);
    mHostCounts.clear();
    if (pages > 0) {
      DeviceArray<Word> words(mStream, pages * 2 * rows(), kPages);
      sweep({begin, end, lattice().bricksZ, rows(), mTouched.slots(), mTouched.before(begin), words.data()}, words);
    }
    take({begin * lattice().bricksZ, mHostFills, mHostCounts});
  }

  /// Fills of the pages' columns, and counts, to the host.
  void sweep(const DevicePages<Word>& pages, DeviceArray<Word>& words) {
    const std::int64_t columns = pages.endColumn - pages.firstColumn, bricks = columns * pages.bricksZ;
    const Extra extra = sortedExtra(setBits(pages, words), mTouched.within(pages.firstColumn, pages.endColumn));
    DeviceArray<BrickFill> fills(mStream, bricks, kCounts);
    DeviceArray<std::uint32_t> counted(mStream, bricks + 1, kCounts);
    fills.fill(0);
    counted.fill(0);
    ColumnSweep<Word> view{pages, extra.view(), fills.data(), counted.data(), nullptr};
    launchKernel(mStream, mKernels.fill, columns, mKernels.threads, view);
    sumUp(mStream, counted);
    std::uint32_t countedBricks = 0;
    counted.download(&countedBricks, bricks, 1);
    mCrossings.wait();
    const std::int64_t numbers = std::int64_t{countedBricks} * kVoxelsOfBrick;
    mCtx.requireMemory(static_cast<std::uint64_t>(numbers) * sizeof(std::uint16_t), "voxelising: counts from the GPU");
    const DeviceArray<std::uint16_t> counts(mStream, numbers, kCounts);
    view.counts = counts.data();
    launchKernel(mStream, mKernels.count, columns, mKernels.threads, view);
    mHostCounts.resize(static_cast<std::size_t>(numbers));
    fills.download(mHostFills.data(), 0, bricks);
    counts.download(mHostCounts.data(), 0, numbers);
    mCrossings.wait();
  }

  struct ExtraKeys {
    DeviceArray<ExtraKey> keys;
    std::int64_t count;
  };
  /// Sets the pages' bits. \return the crossings that found theirs taken
  ExtraKeys setBits(const DevicePages<Word>& pages, DeviceArray<Word>& words) {
    DeviceArray<unsigned long long> found(mStream, 1, kExtra);
    for (std::int64_t room = kExtraOfBrick * mTouched.within(pages.firstColumn, pages.endColumn);;) {
      DeviceArray<ExtraKey> keys(mStream, room, kExtra);
      words.fill(0);
      found.fill(0);
      mCrossings.forEach(SetBits<Word>{pages, {keys.data(), found.data(), room}});
      unsigned long long count = 0;
      found.download(&count, 0, 1);
      mCrossings.wait();
      const auto needed = static_cast<std::int64_t>(count); // the same every time: all but one for each bit
      if (needed <= room) return {std::move(keys), needed};
      room = needed;
    }
  }

  struct Extra {
    DeviceArray<Crossing> crossings;
    DeviceArray<ExtraRange> ranges;
    std::int64_t count;
    [[nodiscard]] DeviceExtra view() const { return {crossings.data(), ranges.data(), count}; }
  };
  Extra sortedExtra(const ExtraKeys& found, std::int64_t pages) {
    Extra extra{DeviceArray<Crossing>(mStream, found.count, kExtra), DeviceArray<ExtraRange>(mStream, pages, kExtra),
                found.count};
    extra.ranges.fill(0);
    if (found.count == 0) return extra;
    DeviceArray<ExtraKey> sorted(mStream, found.count, kExtra);
    sortKeys(mStream, found.keys, sorted, found.count);
    launchKernel(mStream, splitExtra, blocksFor(found.count), kThreads, static_cast<const ExtraKey*>(sorted.data()),
                 extra.view());
    return extra;
  }

  const RunContext& mCtx;
  DeviceStream& mStream;
  RowCrossings& mCrossings;
  const ColumnKernels<Word> mKernels;
  const TouchedBricks mTouched;
  LargeVector<BrickFill> mHostFills;
  LargeVector<std::uint16_t> mHostCounts;
};

template <int Log2>
void runColumns(DeviceStream& stream, RowCrossings& crossings, const TakeBricks& take, const RunContext& ctx) {
  using Shape = ColumnShape<Log2>;
  ColumnCounter<typename Shape::Word>(stream, crossings, {fillColumns<Log2>, countColumns<Log2>, Shape::kThreads}, ctx)
      .run(take);
}

} // namespace

void countOnCuda(const CountTask& task, const TakeBricks& take, const RunContext& ctx, int ordinal) {
  const DeviceScope device(ordinal);
  DeviceStream stream(ordinal, kWhat);
  RowCrossings crossings(stream, task, ctx);
  constexpr void (*kOfWidth[])(DeviceStream&, RowCrossings&, const TakeBricks&,
                               const RunContext&) = {runColumns<0>, runColumns<1>, runColumns<2>, runColumns<3>};
  kOfWidth[task.log2](stream, crossings, take, ctx);
}

} // namespace volcaustic
