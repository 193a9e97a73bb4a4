#include "simulation/flow.h"

#include <cmath>

namespace volcaustic {

namespace {

using VectorField = std::array<Lattice, 3>;

Lattice inCells(const Vec3i& cells) { return Lattice(cells, {.5f, .5f, .5f}); }

/// Half the difference of the values on both sides, to the last node at the walls.
float slope(const Lattice& f, int axis, Vec3i node) {
  const int at = node[axis];
  node[axis] = std::min(at + 1, f.dims()[axis] - 1);
  const float high = f.at(node[0], node[1], node[2]);
  node[axis] = std::max(at - 1, 0);
  return .5f * (high - f.at(node[0], node[1], node[2]));
}

VectorField inMiddles(const StaggeredVelocity& velocity, const Vec3i& cells, const RunContext& ctx) {
  VectorField middle{inCells(cells), inCells(cells), inCells(cells)};
  forEachRow(cells, ctx, [&](int j, int k) {
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < cells[0]; ++i) {
        const Lattice& faces = velocity.component[a];
        const std::size_t face = faces.index(i, j, k);
        middle[a].at(i, j, k) = .5f * (faces.values()[face] + faces.values()[face + faces.stride(a)]);
      }
  });
  return middle;
}

VectorField curl(const VectorField& v, const Vec3i& cells, const RunContext& ctx) {
  VectorField w{inCells(cells), inCells(cells), inCells(cells)};
  forEachRow(cells, ctx, [&](int j, int k) {
    for (int i = 0; i < cells[0]; ++i)
      for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        w[a].at(i, j, k) = slope(v[c], b, {i, j, k}) - slope(v[b], c, {i, j, k});
      }
  });
  return w;
}

/// N x w, where lengths are in cells.
VectorField confinement(const VectorField& w, const Vec3i& cells, const RunContext& ctx) {
  Lattice strength = inCells(cells);
  for (std::size_t n = 0; n < strength.size(); ++n)
    strength.values()[n] = std::hypot(w[0].values()[n], w[1].values()[n], w[2].values()[n]);
  VectorField force{inCells(cells), inCells(cells), inCells(cells)};
  forEachRow(cells, ctx, [&](int j, int k) {
    for (int i = 0; i < cells[0]; ++i) {
      Vec3f towards;
      for (int a = 0; a < 3; ++a) towards[a] = slope(strength, a, {i, j, k});
      const float length = std::hypot(towards[0], towards[1], towards[2]);
      if (length < 1e-20f) continue;
      const std::size_t n = strength.index(i, j, k);
      for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        force[a].values()[n] = (towards[b] * w[c].values()[n] - towards[c] * w[b].values()[n]) / length;
      }
    }
  });
  return force;
}

} // namespace

void confineVorticity(StaggeredVelocity& velocity, const Vec3i& cells, double swirl, double time,
                      const RunContext& ctx) {
  if (swirl <= 0) return;
  const VectorField force = confinement(curl(inMiddles(velocity, cells, ctx), cells, ctx), cells, ctx);
  // The cell of equation 11 and that of the curl's differences cancel.
  const float half = static_cast<float>(.5 * swirl * time);
  for (int a = 0; a < 3; ++a) {
    Lattice& faces = velocity.component[a];
    forEachRow(faces.dims(), ctx, [&](int j, int k) {
      for (int i = 0; i < faces.dims()[0]; ++i) {
        Vec3i cell{i, j, k};
        if (cell[a] == 0 || cell[a] == cells[a]) continue; // walls
        const float above = force[a].at(i, j, k);
        --cell[a];
        faces.at(i, j, k) += half * (above + force[a].at(cell[0], cell[1], cell[2]));
      }
    });
  }
}

} // namespace volcaustic
