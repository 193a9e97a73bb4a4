// The pressure that keeps a flow's volume.
#pragma once

#include "simulation/flow.h"
#include "simulation/multigrid.h"

namespace volcaustic {

/// Largest |div v| * cell.
double largestDivergence(const StaggeredVelocity& velocity, const Vec3i& cells, const RunContext& ctx = {});

class PressureSolver {
public:
  explicit PressureSolver(const Vec3i& cells);

  /// Takes from the velocity the gradient of a pressure, so that as much flows into each cell as out of it, to a ten
  /// thousandth of the fastest flow. Flow through the bottom and the sides stays as it is, through the top it follows
  /// from a pressure of zero there. Conjugate gradients; returns their iterations.
  int project(Flow& flow, const RunContext& ctx);

private:
  Multigrid mMultigrid;
  std::vector<float> mResidual, mDirection, mPreconditioned, mProduct;
};

} // namespace volcaustic
