// What a Medium holds: bricks as they were built, in the memory of this machine or of a GPU, or OpenVDB grids once
// somebody has asked for them.
#pragma once

#include "backends/cuda_medium.h"
#include "volcaustic/openvdb.h"
#include "volume/optics.h"

#include <memory>
#include <mutex>
#include <optional>

namespace volcaustic {

class MediumStore {
public:
  explicit MediumStore(MediumGrids grids) : mGrids(std::move(grids)) {}
  /// \pre the bricks' backgrounds are the ambient medium
  MediumStore(OpticsBricks&& bricks, const Domain& domain, const Ambient& ambient, const RunContext& ctx);
  MediumStore(std::shared_ptr<const DeviceBricks> bricks, const Domain& domain, const Ambient& ambient,
              const RunContext& ctx);

  /// Made on the first call, from any thread; the bricks are given up for them, one set after the other.
  [[nodiscard]] const MediumGrids& grids();
  /// Null once there are grids. Those of a GPU are copied on the first call.
  [[nodiscard]] std::shared_ptr<const OpticsBricks> bricks();
  /// Null where the medium was not built on a GPU.
  [[nodiscard]] const std::shared_ptr<const DeviceBricks>& onDevice() const { return mOnDevice; }

private:
  void copyFromDevice();

  std::mutex mMutex;
  std::shared_ptr<const DeviceBricks> mOnDevice;
  std::shared_ptr<OpticsBricks> mBricks;
  std::optional<MediumGrids> mGrids;
  Domain mDomain;
  Ambient mAmbient;
  RunContext mCtx; ///< threads and memory of the conversion
};

/// The medium's bricks, or bricks made of its grids; the coverage is left out then.
std::shared_ptr<const OpticsBricks> bricksOf(const Medium& medium, const RunContext& ctx);

/// Grids of one value.
openvdb::FloatGrid::Ptr constantFloat(const Domain& domain, double value, const char* name);
openvdb::Vec3SGrid::Ptr constantVec3(const Domain& domain, const Rgb& value, const char* name);

} // namespace volcaustic
