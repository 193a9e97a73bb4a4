// Who renders pictures: the interface of a machine that adds samples to the pixels of tiles.
#pragma once

#include "backends/flat_storage.h"
#include "backends/view_tables.h"

#include <memory>
#include <span>

namespace volcaustic {

/// Samples firstSample to endSample - 1 of the pixels of these tiles, which are numbered by rows.
struct ViewPass {
  std::int32_t firstSample, endSample;
  std::span<const std::int32_t> tiles;
};

class ViewTracer {
public:
  virtual ~ViewTracer() = default;
  /// The planes hold the pass afterwards. A pixel's samples come in order, those from 0 on first. Progress is told as
  /// the stage "view".
  virtual ViewCounts add(const ViewPass& pass) = 0;
};

/// On this machine's cores, on an instruction set. The scene's arrays and the planes have to live as long.
std::unique_ptr<ViewTracer> makeCpuViewer(const kernels::ViewScene& scene, const kernels::PixelPlanes& planes,
                                          const LaneSet& lanes, const RunContext& ctx);
/// On a CUDA device; `tables` are those of the scene, `there` its medium where that was built, if it was on a GPU.
/// \throws Error(Device).
std::unique_ptr<ViewTracer> makeCudaViewer(const kernels::ViewScene& scene, const ViewTables& tables,
                                           std::shared_ptr<const DeviceFlatMedium> there,
                                           const kernels::PixelPlanes& planes, const RunContext& ctx, int ordinal);

} // namespace volcaustic
