// Light of many parallel lamps in and around a brick that all of them light as a whole: the suns of an environment.
#pragma once

#include "backends/lanes.h"
#include "kernels/lamp.h"

#include <array>

namespace volcaustic {

/// Parallel light in a thin medium is smooth: it is evaluated at three points along each axis and interpolated by
/// parabolas, which is good to 1e-4 of a lamp's light, and to 1e-2 where it turns from one face of the domain's box to
/// another, which no two lamps do at the same place. One brick at a time: add all lamps, then spread.
class ManyLamps {
public:
  /// From so many lamps on it is worth it.
  static constexpr int kFewest = 8;
  /// Whether its light is smooth enough.
  static bool takes(const kernels::Lamp& lamp);

  /// `low` is the first voxel of the brick.
  ManyLamps(const kernels::Int3& low, const kernels::Int3& dims);
  void add(const kernels::Lamp& lamp);
  /// Adds the light to the voxels of LaneSet::lightAround: kAroundVoxels times eight numbers.
  void spread(float* sums) const;

private:
  static constexpr int kPoints = 3;

  /// An axis: the first and the last of the voxels that are in the domain, and the one that is first in any case.
  struct Axis {
    int from, to, low;
    Axis(int firstOfBrick, int dim);
    [[nodiscard]] float point(int number) const;
    /// Of the three points for voxel k of ten.
    [[nodiscard]] std::array<float, kPoints> weights(int k) const;
  };

  Axis mX, mY, mZ;
  float mLight[kPoints][kPoints][kPoints][8] = {}; ///< as in `sums`
};

} // namespace volcaustic
