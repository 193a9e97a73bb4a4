// What the camera's rays read beside the medium: where they have to look closely, and light in the form that is fast to
// read (view_light.h). Made once a picture; holds voxels for the bricks that scatter varying light and for no other.
#pragma once

#include "backends/lanes.h"
#include "core/large_memory.h"
#include "core/zeroed_table.h"
#include "volcaustic/run_context.h"

#include <array>
#include <map>
#include <vector>

namespace volcaustic {

class ViewTables {
public:
  /// The arrays that the arguments point at have to live as long. \throws Error(Input) beyond the memory limit.
  ViewTables(const kernels::FlatMedium& medium, const kernels::FluenceField& caustic,
             const kernels::DirectField& direct, const LaneSet& lanes, const RunContext& ctx);

  [[nodiscard]] kernels::ViewLight light() const;
  [[nodiscard]] const kernels::ViewPlan& plan() const { return mPlan; }
  /// Elements behind the pointers of light() and plan(), for whoever copies them to another machine; of lamps, those
  /// that entries of the direct light lead to.
  struct LampCounts {
    std::int32_t sets = 0, setLamps = 0, lamps = 0;
  };
  [[nodiscard]] LampCounts lampCounts() const;
  [[nodiscard]] std::int64_t brickCount() const { return mMedium.brickCount(); }
  [[nodiscard]] std::int64_t lightVoxelCount() const { return static_cast<std::int64_t>(mLight.size()); }
  [[nodiscard]] std::int64_t planVoxelCount() const { return static_cast<std::int64_t>(mPlanVoxels.size()); }

private:
  enum Part { Caustic, Direct, Towards };
  static constexpr int kParts = 3;
  struct Job {
    std::int64_t brick;
    std::int32_t slot;
    Part part;
    bool lamps; ///< whether direct light comes from lamps alone, and is not in voxels
  };
  using Words = std::array<std::uint32_t, 4>;

  void findKinds(const RunContext& ctx);
  void assignSlots(const RunContext& ctx);
  void assign(std::int64_t brick);
  void pack(const LaneSet& lanes, const RunContext& ctx);
  void packOne(const Job& job, const LaneSet& lanes);
  void addLamps(std::int64_t brick, bool directions, const LaneSet& lanes, CornerLight& light) const;
  void fillVoxels(const RunContext& ctx);
  void makePlan(const RunContext& ctx);
  [[nodiscard]] kernels::GridBox box() const;
  [[nodiscard]] std::int32_t planOf(std::int64_t brick) const;
  /// Whether light of lamps varies so much in a brick that it has to be looked at voxel by voxel.
  [[nodiscard]] bool lampsVary(std::int32_t set, const kernels::Int3& brick) const;
  [[nodiscard]] kernels::Int3 coord(std::int64_t brick) const;
  /// The brick and its neighbours on the high sides (x: 4, y: 2, z: 1), or on the low ones; itself where the domain
  /// ends.
  [[nodiscard]] std::array<std::int64_t, 8> around(std::int64_t brick, int side) const;
  /// The same value in all of a brick's voxels and in those around it, or null.
  [[nodiscard]] static const kernels::FluenceVoxel* constantOf(const kernels::FluenceField& field,
                                                               const std::array<std::int64_t, 8>& bricks);

  const kernels::FlatMedium mMedium;
  const kernels::FluenceField mCaustic;
  const kernels::DirectField mDirect;
  bool mDirected = false; ///< whether anything has asymmetry
  ZeroedTable<std::uint8_t> mKinds;
  ZeroedTable<std::int32_t> mEntries[kParts], mBricks;
  LargeVector<kernels::HalfVoxel> mLight;
  LargeVector<std::int32_t> mPlanVoxels;
  std::vector<std::int64_t> mBusy; ///< bricks
  std::vector<Job> mJobs;
  std::map<std::pair<Part, Words>, std::int64_t> mConstants;        ///< first brick of each value
  std::vector<std::pair<std::int64_t, std::int64_t>> mSame[kParts]; ///< bricks, and those whose entries they share
  std::int64_t mSlots = 1;
  CornerVoxels mCorners[8]; ///< by the axes along which a brick is the domain's last
  kernels::ViewPlan mPlan;
};

} // namespace volcaustic
