// Poisson's equation on the cells of a box: its matrix, and a multigrid cycle that nearly inverts it.
#pragma once

#include "simulation/lattice.h"

#include <array>
#include <vector>

namespace volcaustic {

/// Cells of a box of which those along one line across the axes have one width (finite volumes). The walls are closed
/// but for the top, where the pressure is zero.
struct PoissonLevel {
  /// Along one axis. `couple[i]` is one over the distance of the middles of cells i-1 and i; 0 at both ends.
  struct Axis {
    std::vector<float> width, couple;
    float open = 0; ///< one over the distance of the last middle to an open end
  };

  PoissonLevel(std::array<Axis, 3> axes, const Vec3i& dims);
  static PoissonLevel finest(const Vec3i& cells);
  /// Pairs of cells become one.
  [[nodiscard]] PoissonLevel coarser() const;

  [[nodiscard]] std::size_t size() const { return solution.size(); }
  /// result = A x, A being positive definite: flow out of each cell for the potential x.
  void multiply(const std::vector<float>& x, std::vector<float>& result, const RunContext& ctx) const;
  /// One Gauss-Seidel sweep over cells of even (colour 0) or odd i + j + k.
  void relax(int colour, const RunContext& ctx);
  /// The coarser right side: what is left of this level's equations, summed over each pair of pairs of pairs.
  void restrictTo(PoissonLevel& coarse, const RunContext& ctx);
  /// Adds the coarser solution.
  void prolongFrom(const PoissonLevel& coarse, const RunContext& ctx);

  Vec3i dims;
  std::array<Axis, 3> axes;
  std::vector<float> solution, right;

private:
  struct Row;
  [[nodiscard]] Row row(int j, int k) const;
  std::vector<float> mResidual;
};

/// One V-cycle, which is a symmetric positive definite matrix: the preconditioner of conjugate gradients.
class Multigrid {
public:
  explicit Multigrid(const Vec3i& cells);

  [[nodiscard]] const PoissonLevel& finest() const { return mLevels.front(); }
  /// result = nearly A^-1 right.
  void cycle(const std::vector<float>& right, std::vector<float>& result, const RunContext& ctx);

private:
  void cycleFrom(std::size_t level, const RunContext& ctx);

  std::vector<PoissonLevel> mLevels;
};

} // namespace volcaustic
