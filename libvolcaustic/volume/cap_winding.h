// The winding number of the caps of a mesh that does not close, and what it rounds to at the samples of a lattice. See
// winding.h for why that is all that such a mesh needs.
#pragma once

#include "volcaustic/run_context.h"
#include "volcaustic/types.h"
#include "volume/coverage_rows.h"
#include "volume/winding.h"

#include <array>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace volcaustic {

/// A hierarchy of boxes over segments (N = 2) or triangles (N = 3).
template <int N>
struct BoxTree {
  struct Node {
    Vec3d low, high;
    std::uint32_t first, count; // items
    std::uint32_t right = 0;    // second child, the first one being the next node; 0 for a leaf
  };

  explicit BoxTree(std::vector<std::array<Vec3d, N>> primitives);

  std::vector<std::array<Vec3d, N>> items;
  std::vector<Node> nodes;

private:
  std::uint32_t build(std::uint32_t first, std::uint32_t count);
};

/// The winding number of a set of caps, by a hierarchy with dipoles for what is far away (Barill, Dickson, Schmidt,
/// Levin, Jacobson, "Fast winding numbers for soups and clouds", ACM TOG 37(4), 2018).
class CapWinding {
public:
  /// Neither is empty; `edges` bound the caps as a whole.
  CapWinding(std::vector<std::array<Vec3d, 3>> caps, std::vector<std::array<Vec3d, 2>> edges);

  [[nodiscard]] double at(const Vec3d& p) const;
  /// The whole number nearest to at(x) for all x within `radius` of the centre, where one can be guaranteed.
  [[nodiscard]] std::optional<int> nearestWhole(const Vec3d& centre, double radius) const;

private:
  static constexpr double kWholeSphere = 4 * std::numbers::pi;
  struct Dipole {
    Vec3d centroid, areaVector;
    double radius; // of the triangles about the centroid
  };

  class AngleSum;
  void addSolidAngle(std::uint32_t node, const Vec3d& p, AngleSum& sum) const;
  bool touches(std::uint32_t node, const Vec3d& centre, double radius) const;
  double variation(std::uint32_t node, const Vec3d& centre, double radius, double limit) const;

  BoxTree<3> mCaps;
  BoxTree<2> mEdges;
  std::vector<Dipole> mDipoles;     // of the nodes of mCaps
  std::vector<double> mEdgeLengths; // of the nodes of mEdges, summed
  double mReach = 0;                // beyond this distance from the caps' box |at(x)| < 1/2
};

/// What the caps' winding number rounds to at the samples of a lattice, negated: the whole number to add to the winding
/// number of the closed mesh. Decided for the largest octree cubes for which it is provably the same at every sample.
class CapOffsets {
public:
  static constexpr std::int16_t kVaries = std::numeric_limits<std::int16_t>::min();

  CapOffsets(const LoopCaps& caps, const SubLattice& lattice, const RunContext& ctx);

  /// Of a brick of the lattice (z fastest); kVaries where it is not one number.
  [[nodiscard]] std::int16_t ofBrick(std::int64_t brick) const { return mTable[brick]; }
  /// Of every sample of a brick, in row order.
  void ofSamples(const Vec3i& brick, std::vector<std::int16_t>& offsets) const;

private:
  [[nodiscard]] std::optional<std::int16_t> ofCube(const Vec3i& first, int n) const;
  void fillBricks(const Vec3i& first, int n);
  void fillSamples(const Vec3i& origin, const Vec3i& first, int n, std::vector<std::int16_t>& offsets) const;

  SubLattice mLattice;
  CapWinding mWinding;
  Vec3i mBricks{};
  std::vector<std::int16_t> mTable;
};

} // namespace volcaustic
