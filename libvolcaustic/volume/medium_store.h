// What a Medium holds: bricks as they were built, or OpenVDB grids once somebody has asked for them.
#pragma once

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

  /// Made on the first call, from any thread; the bricks are given up for them, one set after the other.
  [[nodiscard]] const MediumGrids& grids();
  /// Null once there are grids.
  [[nodiscard]] std::shared_ptr<const OpticsBricks> bricks() const;

private:
  mutable std::mutex mMutex;
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
