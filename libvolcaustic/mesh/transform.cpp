#include "volcaustic/mesh.h"

#include <algorithm>

namespace volcaustic {

Mesh transformed(Mesh mesh, const Affine& placement) {
  const auto& m = placement;
  for (Vec3d& p : mesh.positions) {
    const Vec3d q = p;
    for (int k = 0; k < 3; ++k) p[k] = m[k][0] * q[0] + m[k][1] * q[1] + m[k][2] * q[2] + m[k][3];
  }
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  if (determinant < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

Box bounds(const Mesh& mesh) {
  if (mesh.triangles.empty()) return {};
  Box box{mesh.positions[mesh.triangles[0][0]], mesh.positions[mesh.triangles[0][0]]};
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle)
      for (int k = 0; k < 3; ++k) {
        box.min[k] = std::min(box.min[k], mesh.positions[corner][k]);
        box.max[k] = std::max(box.max[k], mesh.positions[corner][k]);
      }
  return box;
}

} // namespace volcaustic
