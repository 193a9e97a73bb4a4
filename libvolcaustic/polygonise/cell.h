// How the crossings of a cell's edges hang together as patches of surface.
#pragma once

#include <array>
#include <cstdint>

namespace volcaustic {

inline constexpr int kCellEdges = 12, kCellFaces = 6;

/// Corner i of a cell is at (i & 1, i >> 1 & 1, i >> 2 & 1) of it.
constexpr int cornerAlong(int axis, int a, int u, int v) {
  return a << axis | u << (axis + 1) % 3 | v << (axis + 2) % 3;
}

/// The edge along `axis` at (u, v) of the two axes after it, cyclically.
constexpr int cellEdge(int axis, int u, int v) { return 4 * axis + u + 2 * v; }
constexpr int edgeAxis(int edge) { return edge / 4; }
/// The corner where an edge begins; it ends in the one with its axis' bit set.
constexpr int edgeCorner(int edge) { return cornerAlong(edge / 4, 0, edge & 1, edge >> 1 & 1); }

/// Patches are loops around the cell: crossed edges, each followed by one that it shares a face with, so that inside
/// lies to the left of the way as seen from outside the cell.
struct CellPatches {
  int count = 0;
  std::array<std::int8_t, kCellEdges> patch; ///< that each edge's crossing belongs to; -1 where there is none
  std::array<std::int8_t, kCellEdges> next;  ///< edge that follows it around the patch
};

/// \param inside bit i: corner i
/// \param joined bit f: on face f = 2 axis + side, whose corners are inside and outside by turns, the two that are
///        inside hang together; of other faces the bit has no meaning
CellPatches cellPatches(unsigned inside, unsigned joined);

/// Bit f: the corners of face f are inside and outside by turns.
unsigned ambiguousFaces(unsigned inside);

/// Bit f: face f is ambiguous, and both pieces of curve in which the surface meets it belong to one patch.
unsigned facesOfOnePatch(unsigned inside, unsigned joined);

/// Corners of face 2 axis + side, around it against the clock as seen from the side that the axis points to.
constexpr int faceCorner(int axis, int side, int k) {
  return cornerAlong(axis, side, k == 1 || k == 2, k == 2 || k == 3);
}

/// Whether the inside corners of an ambiguous face, values a and c, hang together: what bilinear interpolation does
/// between them (Nielson & Hamann, The asymptotic decider, 1991). Both cells at a face come to the same answer: a
/// product does not depend on which of its factors comes first.
inline bool insideJoins(double a, double c, double outsideB, double outsideD) { return a * c >= outsideB * outsideD; }

} // namespace volcaustic
