// The camera's rays in lanes (docs/algorithms/view.md). Compiled once for each instruction set of lanes.h.
//
// A register holds the rays of neighbouring pixels, a tile of 4x4 or half of one. They meet the same bricks at about
// the same time and end together, so lanes wait little for each other, and branches that skip work for all of them pay.

#include "backends/highway_lanes.h"
#include "backends/lanes.h"

#include <algorithm>

namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET {

namespace {

constexpr int kColumns = 4, kRows = kLanes / kColumns; ///< of pixels in a register

/// The pixels of a register.
struct PixelBlock {
  std::int32_t column, row;

  [[nodiscard]] Double columns() const {
    return lanes([](int i) { return i % kColumns; }) + Double(double(column));
  }
  [[nodiscard]] Double rows() const {
    return lanes([](int i) { return i / kColumns; }) + Double(double(row));
  }

private:
  template <class Of>
  [[nodiscard]] static Double lanes(const Of& of) {
    alignas(64) double numbers[kLanes];
    for (int i = 0; i < kLanes; ++i) numbers[i] = of(i);
    return load(numbers);
  }
};

class Viewer {
public:
  Viewer(const ViewTask& task, ViewCounts& counts) : mTask(task), mCounts(counts) {}

  void run() {
    // Down the columns: rays one above the other share lines of the cache, in which z runs fastest.
    const kernels::CameraFrame& camera = mTask.scene.camera;
    for (std::int32_t c = mTask.column; c < std::min(mTask.column + kViewBlock, camera.width); c += kColumns)
      for (std::int32_t r = mTask.row; r < std::min(mTask.row + kViewBlock, camera.height); r += kRows) look({c, r});
  }

private:
  void look(const PixelBlock& block) {
    const kernels::CameraFrame& camera = mTask.scene.camera;
    const Double columns = block.columns(), rows = block.rows();
    const Mask on = both(narrow(columns) < Float(camera.width), narrow(rows) < Float(camera.height));
    const kernels::PixelSumOf<Float> sum = kernels::gatherPixel<Float>(
        mTask.scene, columns, rows, on, [&](const kernels::RayEnd<Float>& end) { book(end); });
    alignas(64) float numbers[kernels::kPixelPlanes][kLanes];
    mTask.planes.forEach<Float>(sum, [&](int plane, Float v) { store(v, numbers[plane]); });
    for (int plane = 0; plane < kernels::kPixelPlanes; ++plane) write(block, numbers[plane], mTask.planes.of[plane]);
  }

  void write(const PixelBlock& block, const float* numbers, float* plane) const {
    const hn::FixedTag<float, kColumns> four;
    const kernels::CameraFrame& camera = mTask.scene.camera;
    const std::int32_t width = camera.width - block.column;
    float* to = plane + std::int64_t{block.row} * camera.width + block.column;
    for (int r = 0; r < kRows && block.row + r < camera.height; ++r, to += camera.width, numbers += kColumns)
      if (width >= kColumns)
        hn::StoreU(hn::Load(four, numbers), four, to);
      else
        for (int c = 0; c < kColumns && c < width; ++c) to[c] = numbers[c];
  }

  void book(const kernels::RayEnd<Float>& end) {
    alignas(64) std::int32_t steps[kLanes];
    store(end.steps, steps);
    for (const std::int32_t n : steps) mCounts.steps += n;
    mCounts.notFinite += count(end.notFinite);
    mCounts.stepLimit += count(end.stepLimit);
  }

  const ViewTask& mTask;
  ViewCounts& mCounts;
};

} // namespace

void view(const ViewTask& task, ViewCounts& counts) { Viewer(task, counts).run(); }

} // namespace volcaustic::VOLCAUSTIC_INSTRUCTION_SET
