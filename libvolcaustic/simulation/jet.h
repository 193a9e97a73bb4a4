// What flows into the box.
#pragma once

#include "simulation/flow.h"
#include "volcaustic/simulation.h"

#include <array>
#include <cstdint>
#include <vector>

namespace volcaustic {

/// A round hole in the middle of the bottom, through which the second fluid enters upwards, and the walls around it.
/// The speed wavers by a few waves that run across the hole, drawn by the seed, of lengths and times that do not depend
/// on the cells.
class Jet {
public:
  Jet(const MixingOptions& options, const Vec3i& cells, double cell, std::uint64_t seed);

  /// The velocity through the walls, and what is beyond bottom and top, at `time` [s].
  void impose(Flow& flow, double time) const;

private:
  struct Wave {
    double x, y, frequency, phase;
  };
  struct Face {
    int i, j;
    double open; ///< part of it that the hole covers
    double x, y; ///< world, from the middle of the hole
  };
  [[nodiscard]] double speed(const Face& face, double time) const;

  double mSpeed, mDisturbance;
  std::array<Wave, 8> mWaves{};
  std::vector<Face> mFaces;
};

} // namespace volcaustic
