#include "polygonise/cell.h"

namespace volcaustic {

namespace {

/// Of face f: corners around it against the clock as seen from outside the cell, and the edge from each to the next.
struct Face {
  std::array<int, 4> corners, edges;
};

constexpr int edgeBetween(int a, int b) {
  const int low = a & b, bit = a ^ b, axis = bit == 1 ? 0 : bit == 2 ? 1 : 2;
  return cellEdge(axis, low >> (axis + 1) % 3 & 1, low >> (axis + 2) % 3 & 1);
}

constexpr std::array<Face, kCellFaces> makeFaces() {
  std::array<Face, kCellFaces> faces{};
  for (int f = 0; f < kCellFaces; ++f) {
    const int side = f & 1;
    for (int k = 0; k < 4; ++k) faces[f].corners[k] = faceCorner(f / 2, side, side ? k : 3 - k);
    for (int k = 0; k < 4; ++k) faces[f].edges[k] = edgeBetween(faces[f].corners[k], faces[f].corners[(k + 1) % 4]);
  }
  return faces;
}
constexpr std::array<Face, kCellFaces> kFaces = makeFaces();

constexpr bool isInside(unsigned inside, int corner) { return inside >> corner & 1; }

constexpr bool isAmbiguous(unsigned inside, const Face& face) {
  const auto& c = face.corners;
  return isInside(inside, c[0]) == isInside(inside, c[2]) && isInside(inside, c[1]) == isInside(inside, c[3]) &&
         isInside(inside, c[0]) != isInside(inside, c[1]);
}

/// Adds a face's pieces of curve: each begins where the way around the face leaves the inside, and ends where it comes
/// back in. Every edge is walked both ways by its two faces, so it is the beginning of one piece and the end of one.
void linkFace(const Face& face, unsigned inside, bool joined, std::array<std::int8_t, kCellEdges>& next) {
  const auto leaves = [&](int k) {
    return isInside(inside, face.corners[k]) && !isInside(inside, face.corners[(k + 1) % 4]);
  };
  const auto enters = [&](int k) {
    return !isInside(inside, face.corners[k]) && isInside(inside, face.corners[(k + 1) % 4]);
  };
  // Around the outside corner ahead where the inside is joined, else back around the inside one.
  const int step = joined ? 1 : 3;
  for (int k = 0; k < 4; ++k) {
    if (!leaves(k)) continue;
    int to = (k + step) % 4;
    while (!enters(to)) to = (to + step) % 4;
    next[face.edges[k]] = static_cast<std::int8_t>(face.edges[to]);
  }
}

constexpr std::array<std::uint8_t, 256> kAmbiguous = [] {
  std::array<std::uint8_t, 256> all{};
  for (unsigned inside = 0; inside < 256; ++inside)
    for (int f = 0; f < kCellFaces; ++f)
      if (isAmbiguous(inside, kFaces[f])) all[inside] |= static_cast<std::uint8_t>(1u << f);
  return all;
}();

CellPatches linkedPatches(unsigned inside, unsigned joined) {
  CellPatches patches;
  patches.patch.fill(-1);
  patches.next.fill(-1);
  for (int f = 0; f < kCellFaces; ++f) linkFace(kFaces[f], inside, joined >> f & 1, patches.next);
  for (int edge = 0; edge < kCellEdges; ++edge) {
    if (patches.next[edge] < 0 || patches.patch[edge] >= 0) continue;
    for (int e = edge; patches.patch[e] < 0; e = patches.next[e])
      patches.patch[e] = static_cast<std::int8_t>(patches.count);
    ++patches.count;
  }
  return patches;
}

} // namespace

CellPatches cellPatches(unsigned inside, unsigned joined) {
  static const std::array<CellPatches, 256> kPlain = [] {
    std::array<CellPatches, 256> all;
    for (unsigned i = 0; i < 256; ++i) all[i] = linkedPatches(i, 0);
    return all;
  }();
  return (joined & kAmbiguous[inside]) == 0 ? kPlain[inside] : linkedPatches(inside, joined);
}

unsigned ambiguousFaces(unsigned inside) { return kAmbiguous[inside]; }

unsigned facesOfOnePatch(unsigned inside, unsigned joined) {
  const unsigned ambiguous = ambiguousFaces(inside);
  if (ambiguous == 0) return 0;
  const CellPatches patches = cellPatches(inside, joined);
  unsigned faces = 0;
  for (int f = 0; f < kCellFaces; ++f) {
    if (!(ambiguous >> f & 1)) continue;
    // All four edges are crossed; those next to each other around the face end the pieces of both pairings.
    const auto& e = kFaces[f].edges;
    if (patches.patch[e[0]] == patches.patch[e[2]] && patches.patch[e[0]] == patches.patch[e[1]] &&
        patches.patch[e[0]] == patches.patch[e[3]])
      faces |= 1u << f;
  }
  return faces;
}

} // namespace volcaustic
