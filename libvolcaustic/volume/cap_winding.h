// The winding number of the caps of a mesh that does not close. See winding.h for why that is all that such a mesh
// needs.
#pragma once

#include "volcaustic/types.h"
#include "volume/solid_angle.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace volcaustic {

/// A hierarchy of boxes over segments (N = 2) or triangles (N = 3), one in each leaf.
template <int N>
struct BoxTree {
  struct Node {
    Vec3d low, high;
    std::uint32_t first, count; // items
    std::uint32_t right = 0;    // second child, the first one being the next node; 0 for a leaf
  };

  explicit BoxTree(std::vector<Weighted<N>> primitives);

  std::vector<Weighted<N>> items;
  std::vector<Node> nodes;

private:
  std::uint32_t build(std::uint32_t first, std::uint32_t count);
};

/// The winding number of a set of caps: exact for what is near, groups of triangles for what is far away.
class CapWinding {
public:
  /// `edges` bound the caps as a whole, and are at least one. Unit: any; coordinates below 2^41.
  CapWinding(const std::vector<std::array<Vec3d, 3>>& caps, const std::vector<std::array<Vec3d, 2>>& edges);

  [[nodiscard]] double at(const Vec3d& p) const;
  /// roundedWinding(at(x)) of all x within `radius` of the centre, where it can be guaranteed to be one number.
  [[nodiscard]] std::optional<int> wholeWithin(const Vec3d& centre, double radius) const;

  /// Names of groups of caps, and of single ones.
  using Group = std::uint32_t;
  static constexpr std::array<Group, 1> kAll{0};
  /// Adds to the points, which lie within `radius` of the centre, what is smooth within `clearance` of it, and lists
  /// single caps, which are not.
  void addFar(std::span<const Group> groups, const Vec3d& centre, double radius, double clearance, PointSums& points,
              std::vector<Group>& near) const;
  void addNear(std::span<const Group> near, PointSums& points) const;
  [[nodiscard]] const WeightedTriangle& cap(Group single) const { return mCaps.items[mCaps.nodes[single].first]; }

  /// The most that the winding number of near caps changes from the centre to anywhere within `radius` of it; infinite
  /// where one has a side there. \pre none of them crosses that ball
  [[nodiscard]] double nearChange(std::span<const Group> near, const Vec3d& centre, double radius) const;

  /// Names of groups of boundary edges, and of single ones. Away from the caps a winding number's gradient is at most
  /// the sum of l / (4 pi d^2) over the edges, of length l at distance d, or 1 / (4 d) for a long one. Adds to
  /// `gradient` the most that edges further than `clearance` from the centre contribute within `radius` of it, and
  /// lists the others singly.
  void addFarEdges(std::span<const Group> edges, const Vec3d& centre, double radius, double clearance, double& gradient,
                   std::vector<Group>& near) const;
  /// The most that near edges contribute within `radius` of the centre; infinite where one reaches into it.
  [[nodiscard]] double nearGradient(std::span<const Group> near, const Vec3d& centre, double radius) const;

private:
  struct Ball {
    Vec3d centre;
    double radius, clearance;
  };
  void addGroups(Group group, const Ball& ball, PointSums& points, std::vector<Group>& near) const;
  bool touches(Group group, const Vec3d& centre, double radius) const;
  void addEdges(Group group, const Ball& ball, double& gradient, std::vector<Group>& near) const;
  [[nodiscard]] double edgeGradient(Group group, double distance) const;

  BoxTree<3> mCaps;
  BoxTree<2> mEdges;
  std::vector<AreaMoments> mMoments; // of the nodes of mCaps
  std::vector<double> mEdgeLengths;  // of the nodes of mEdges, summed
  double mReach = 0;                 // beyond this distance from the caps' box |at(x)| < 1/2
};

/// The whole number nearest to a winding number; of two that are equally near within 2^-12, which covers the errors of
/// at(), the one nearer to zero.
constexpr int roundedWinding(double w) {
  constexpr double kHalf = 0.5 - 0x1p-12;
  const double magnitude = (w < 0 ? -w : w) + kHalf;
  const int whole = static_cast<int>(magnitude < 32767 ? magnitude : 32767);
  return w < 0 ? -whole : whole;
}

/// roundedWinding(x) of all x that differ from w by no more than `change`, where it is one number.
std::optional<int> oneWhole(double w, double change);

/// From a point to a triangle.
double distanceToTriangle(const Vec3d& p, const std::array<Vec3d, 3>& t);
/// From a point to the nearest of a triangle's sides.
double distanceToRim(const Vec3d& p, const std::array<Vec3d, 3>& t);

} // namespace volcaustic
