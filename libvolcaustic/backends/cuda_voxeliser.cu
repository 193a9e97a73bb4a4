// Voxelising on a CUDA device: the order of the kernels of cuda_rows.cuh, and the memory they need
// (docs/algorithms/cuda.md).

#include "backends/cuda_counts.cuh"
#include "backends/cuda_rows.cuh"
#include "backends/cuda_scans.cuh"

#include <algorithm>
#include <array>
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
    sumUp(stream, mFirstOfItems, kWhat);
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
    sumUp(stream, mSlots, kWhat);
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

  DeviceCounts run() {
    const std::int64_t columns = lattice().columns(), room = roomForPages();
    for (std::int64_t begin = 0; begin < columns;) {
      std::int64_t end = begin + 1;
      while (end < columns && mTouched.within(begin, end + 1) <= room && end - begin < kMostColumns) ++end;
      if (mTouched.within(begin, end) > room) refuse(mTouched.within(begin, end));
      count(begin, end);
      mCtx.progress("voxelise", static_cast<double>(end) / static_cast<double>(columns));
      begin = end;
    }
    return joined();
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
  void count(std::int64_t begin, std::int64_t end) {
    const std::int64_t pages = mTouched.within(begin, end), bricks = (end - begin) * lattice().bricksZ;
    Part part{DeviceArray<kernels::BrickFill>(mStream, bricks, kCounts),
              DeviceArray<std::uint32_t>(mStream, bricks + 1, kCounts), DeviceArray<std::uint16_t>(mStream, 0, kCounts),
              bricks, 0};
    part.fills.fill(0);
    part.counted.fill(0);
    if (pages > 0) {
      DeviceArray<Word> words(mStream, pages * 2 * rows(), kPages);
      sweep({begin, end, lattice().bricksZ, rows(), mTouched.slots(), mTouched.before(begin), words.data()}, words,
            part);
    }
    mParts.push_back(std::move(part));
  }

  /// The bricks of some columns.
  struct Part {
    DeviceArray<kernels::BrickFill> fills;
    DeviceArray<std::uint32_t> counted;
    DeviceArray<std::uint16_t> counts;
    std::int64_t bricks, countedBricks;
  };

  /// Fills and counts of the pages' columns.
  void sweep(const DevicePages<Word>& pages, DeviceArray<Word>& words, Part& part) {
    const std::int64_t columns = pages.endColumn - pages.firstColumn;
    const Extra extra = sortedExtra(setBits(pages, words), mTouched.within(pages.firstColumn, pages.endColumn));
    ColumnSweep<Word> view{pages, extra.view(), part.fills.data(), part.counted.data(), nullptr};
    launchKernel(mStream, mKernels.fill, columns, mKernels.threads, view);
    sumUp(mStream, part.counted, kWhat);
    std::uint32_t countedBricks = 0;
    part.counted.download(&countedBricks, part.bricks, 1);
    mCrossings.wait();
    part.countedBricks = countedBricks;
    part.counts = DeviceArray<std::uint16_t>(mStream, part.countedBricks * kVoxelsOfBrick, kCounts);
    view.counts = part.counts.data();
    launchKernel(mStream, mKernels.count, columns, mKernels.threads, view);
  }

  /// All parts, one after the other.
  DeviceCounts joined() {
    std::int64_t bricks = 0, countedBricks = 0;
    for (const Part& part : mParts) {
      bricks += part.bricks;
      countedBricks += part.countedBricks;
    }
    DeviceCounts all;
    if (mParts.size() == 1) {
      all = {std::move(mParts[0].fills), std::move(mParts[0].counted), std::move(mParts[0].counts), false};
    } else {
      all = {DeviceArray<kernels::BrickFill>(mStream, bricks, kCounts),
             DeviceArray<std::uint32_t>(mStream, bricks + 1, kCounts),
             DeviceArray<std::uint16_t>(mStream, countedBricks * kVoxelsOfBrick, kCounts), false};
      std::int64_t brick = 0;
      std::uint32_t counted = 0;
      for (Part& part : mParts) {
        all.fills.copyFrom(part.fills, brick, part.bricks);
        all.counts.copyFrom(part.counts, std::int64_t{counted} * kVoxelsOfBrick, part.countedBricks * kVoxelsOfBrick);
        launchKernel(mStream, shiftNumbers, blocksFor(part.bricks + 1), kThreads,
                     static_cast<const std::uint32_t*>(part.counted.data()), part.bricks + 1, counted,
                     all.counted.data() + brick);
        brick += part.bricks;
        counted += static_cast<std::uint32_t>(part.countedBricks);
        part = {};
      }
    }
    all.any = anyInside(all, bricks, countedBricks * kVoxelsOfBrick);
    return all;
  }
  bool anyInside(const DeviceCounts& all, std::int64_t bricks, std::int64_t voxels) {
    DeviceArray<unsigned> found(mStream, 1, kCounts);
    found.fill(0);
    launchKernel(mStream, findFull, blocksFor(bricks), kThreads,
                 static_cast<const kernels::BrickFill*>(all.fills.data()), bricks, found.data());
    if (voxels > 0)
      launchKernel(mStream, findCounts, blocksFor(voxels), kThreads,
                   static_cast<const std::uint16_t*>(all.counts.data()), voxels, found.data());
    unsigned any = 0;
    found.download(&any, 0, 1);
    mCrossings.wait();
    return any != 0;
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
    sortKeys(mStream, found.keys, sorted, found.count, kWhat);
    launchKernel(mStream, splitExtra, blocksFor(found.count), kThreads, static_cast<const ExtraKey*>(sorted.data()),
                 extra.view());
    return extra;
  }

  const RunContext& mCtx;
  DeviceStream& mStream;
  RowCrossings& mCrossings;
  const ColumnKernels<Word> mKernels;
  const TouchedBricks mTouched;
  std::vector<Part> mParts;
};

template <int Log2>
DeviceCounts runColumns(DeviceStream& stream, RowCrossings& crossings, const RunContext& ctx) {
  using Shape = ColumnShape<Log2>;
  return ColumnCounter<typename Shape::Word>(stream, crossings,
                                             {fillColumns<Log2>, countColumns<Log2>, Shape::kThreads}, ctx)
      .run();
}

} // namespace

DeviceCounts countOnDevice(DeviceStream& stream, const CountTask& task, const RunContext& ctx) {
  RowCrossings crossings(stream, task, ctx);
  constexpr DeviceCounts (*kOfWidth[])(DeviceStream&, RowCrossings&, const RunContext&) = {
      runColumns<0>, runColumns<1>, runColumns<2>, runColumns<3>};
  return kOfWidth[task.log2](stream, crossings, ctx);
}

} // namespace volcaustic
