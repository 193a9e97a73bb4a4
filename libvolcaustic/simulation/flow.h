// The fields of an incompressible flow in a box of n cells, on the staggered lattice of Harlow and Welch (1965): each
// component of the velocity in the middle of the faces that it passes, everything else in the middle of cells.
#pragma once

#include "simulation/lattice.h"

#include <array>

namespace volcaustic {

/// Infinite when a value is not finite.
float largestMagnitude(const std::vector<float>& values, const RunContext& ctx);

/// Face i of axis a is between cells i-1 and i. World lengths per second.
struct StaggeredVelocity {
  explicit StaggeredVelocity(const Vec3i& cells)
      : component{Lattice({cells[0] + 1, cells[1], cells[2]}, {0, .5f, .5f}),
                  Lattice({cells[0], cells[1] + 1, cells[2]}, {.5f, 0, .5f}),
                  Lattice({cells[0], cells[1], cells[2] + 1}, {.5f, .5f, 0})} {}

  std::array<Lattice, 3> component;

  [[nodiscard]] Vec3f sample(const Vec3f& p) const {
    return {component[0].sample(p), component[1].sample(p), component[2].sample(p)};
  }
  /// Of any component; infinite when one value is not finite.
  [[nodiscard]] float maxSpeed(const RunContext& ctx) const;
};

/// Of the second fluid, in cell (i, j, k) at node (i, j, k + 1): a layer of nodes below the bottom and one above the
/// top hold what flows in there.
inline Lattice concentrationLattice(const Vec3i& cells) {
  return Lattice({cells[0], cells[1], cells[2] + 2}, {.5f, .5f, -.5f});
}

struct Flow {
  explicit Flow(const Vec3i& dims)
      : cells(dims), velocity(dims), concentration(concentrationLattice(dims)), pressure(dims, {.5f, .5f, .5f}) {}

  Vec3i cells;
  StaggeredVelocity velocity;
  Lattice concentration;
  Lattice pressure; ///< of the step before, times time over density and cell: where the next solve begins
  double owed = 0;  ///< cells of the second fluid that came in and are not there yet (balance)
};

/// `field` carried along `velocity` for a time in which a speed of one passes `cells` cells: MacCormack's scheme on
/// semi-Lagrangian steps (Selle et al. 2008), held between the values that it came from, so that nothing overshoots.
Lattice advected(const Lattice& field, const StaggeredVelocity& velocity, float cells, const RunContext& ctx);

/// Semi-Lagrangian steps lose or gain a little where a field is steep. Gives `next` as much of the second fluid as
/// there was `before` the step and came in since: where both fluids are mixed, by c (1 - c), so that nothing leaves [0,
/// 1].
void balance(Flow& next, const Flow& before, float cells, const RunContext& ctx);

/// Ends of a field along an axis: nothing flows through (Closed), or the outermost values stay (Held).
enum class DiffusionEnds { Closed, Held };

/// One implicit step of diffusion along each axis in turn; `amount` is diffusivity * time / cell^2. Of any length:
/// values stay between the extremes there were, and their sum is kept between closed ends.
void diffuse(Lattice& field, double amount, const std::array<DiffusionEnds, 3>& ends, const RunContext& ctx);

/// Adds swirl * cell * time * (N x w) to the velocity, w = curl v and N the direction to where |w| grows: vorticity
/// confinement (Fedkiw, Stam & Jensen 2001, equation 11). `time` in seconds, swirl in 1/s.
void confineVorticity(StaggeredVelocity& velocity, const Vec3i& cells, double swirl, double time,
                      const RunContext& ctx);

} // namespace volcaustic
