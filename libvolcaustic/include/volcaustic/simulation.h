/// \file simulation.h
/// Two built-in sources of motion for examples and tests: rigid bodies, and the mixing of two refractive fluids.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/mesh.h"
#include "volcaustic/placement.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// A body that falls, rolls and collides.
struct RigidBody {
  std::string name;
  std::shared_ptr<const Mesh> mesh; ///< its convex hull collides where it moves, its triangles where it is fixed
  Placement placement;              ///< at the first frame; its scale and shear stay
  Vec3d velocity{0, 0, 0};          ///< world per second
  Vec3d spin{0, 0, 0};              ///< angular velocity in world axes, degrees per second
  double density = 1;               ///< mass per volume; only ratios matter
  double friction = 0.7;            ///< Coulomb's coefficient of a pair of bodies is the product of theirs
  double restitution = 0.5;         ///< part of the speed that is left after a collision; of a pair, the product
  bool fixed = false;               ///< stays where it is: floors and walls
};

struct RigidBodyOptions {
  Vec3d gravity{0, 0, -9.81};  ///< world per second squared
  double framesPerSecond = 24; ///< of what is returned
  int steps = 20;              ///< of the simulation for each frame
};

/// The placement of each body at each of `frames` frames, the first of which is as given: result[frame][body]. Bullet's
/// sequential impulses; the same bits for the same input. Rotations go on from frame to frame without leaps, so that
/// they can be keyed. \throws Error(Usage) for options and numbers out of range, Error(Input) for a moving mesh that is
/// not closed or has no volume; Error(Cancelled).
VOLCAUSTIC_API std::vector<std::vector<Placement>> simulateRigidBodies(std::span<const RigidBody> bodies, int frames,
                                                                       const RigidBodyOptions& options = {},
                                                                       const RunContext& ctx = {});

/// Two fluids that mix in a box: a jet of the second enters through a hole in the bottom and rises (or sinks) in the
/// first, stirred by its own turbulence. Bottom and sides are walls; the top is open, and as much leaves there as
/// enters.
struct MixingOptions {
  Vec3d center{0, 0, 0};       ///< of the box, world
  Vec3d size{1, 1, 1};         ///< its edges, world; the shorter ones to the nearest whole cell
  int resolution = 64;         ///< cells along the longest side
  double framesPerSecond = 24; ///< of time between calls of advance
  double inflow = 0.6;         ///< speed of the jet, world per second
  double inflowRadius = 0.12;  ///< of the jet at the bottom, world
  double buoyancy = 1;         ///< upward acceleration of the pure second fluid, world per second squared
  double viscosity = 0;        ///< kinematic, world squared per second
  double diffusion = 0;        ///< of the concentration, world squared per second
  double swirl = 0.3;          ///< vorticity confinement (Fedkiw et al. 2001), 1/s: brings small eddies back; 0 is none
  double disturbance = 0.1;    ///< random part of the jet's velocity, by the context's seed
};

/// Incompressible flow: MacCormack advection on a staggered grid, pressure by conjugate gradients; frames are OpenVDB
/// grids. The same bits for the same options and seed (docs/algorithms/simulation.md).
class VOLCAUSTIC_API MixingSimulation {
public:
  /// \throws Error(Usage) for options out of range, Error(Input) for more cells than the memory limit allows.
  explicit MixingSimulation(const MixingOptions& options, const RunContext& ctx = {});
  ~MixingSimulation();
  MixingSimulation(MixingSimulation&&) noexcept;
  MixingSimulation& operator=(MixingSimulation&&) noexcept;

  /// To the next frame, in as many steps as the fastest flow asks for. \throws Error(Cancelled), which leaves it at a
  /// state from which it can go on.
  void advance();
  [[nodiscard]] int frame() const;            ///< number of calls of advance
  [[nodiscard]] const Domain& domain() const; ///< the cells
  /// Parts of the second fluid in cell (i, j, k), 0 to 1.
  [[nodiscard]] float concentration(const Vec3i& cell) const;
  /// Largest |div v| * cell / |v|max after the last step: what the pressure solve left.
  [[nodiscard]] double divergence() const;
  /// Writes grids `concentration` (Float, fog volume) and `velocity` (Vec3f, staggered, world per second) as a .vdb:
  /// whole or not at all, and the same bytes for the same frame. \throws Error(Usage) for another extension,
  /// Error(File).
  void write(const std::filesystem::path& path) const;

private:
  struct State;
  std::unique_ptr<State> mState;
};

} // namespace volcaustic
