// Handles: points in balls are placed, the rest of the surface follows.
#pragma once

#include "deform/held_system.h"
#include "deform/surface.h"
#include "volcaustic/deform.h"

#include <optional>

namespace volcaustic {

inline constexpr int kNoHandle = -1;

/// Points with a handle are held, those that hang together with them are free, all others outside.
/// \param handleOf of each point, or kNoHandle
std::vector<PointRole> rolesUnder(const DeformSurface& surface, const std::vector<int>& handleOf);

/// Solves for the free points again and again; the factorisation depends on roles and method alone.
class HandleSolver {
public:
  HandleSolver(DeformMethod method, std::vector<PointRole> roles) : mMethod(method), mRoles(std::move(roles)) {}

  [[nodiscard]] bool fits(DeformMethod method, const std::vector<PointRole>& roles) const {
    return method == mMethod && roles == mRoles;
  }

  /// Moves `points`, whose present shape is that to be kept. A component whose handles all hold still stays as it is,
  /// bit by bit. \param handles by their numbers in `handleOf`
  void solve(std::vector<Vec3d>& points, const DeformSurface& surface, std::span<const Deformer> handles,
             const std::vector<int>& handleOf, int iterations, const RunContext& ctx);

private:
  void followRigidly(std::vector<Vec3d>& moved, const std::vector<Vec3d>& points, const DeformSurface& surface,
                     std::span<const Deformer> handles, const std::vector<int>& handleOf, int iterations,
                     const RunContext& ctx);
  void followSmoothly(std::vector<Vec3d>& moved, const std::vector<Vec3d>& points, const RunContext& ctx);

  DeformMethod mMethod;
  std::vector<PointRole> mRoles;
  std::optional<HeldSystem> mSystem; // made when a handle moves first
};

} // namespace volcaustic
