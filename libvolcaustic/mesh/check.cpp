#include "mesh/shells.h"
#include "mesh/topology.h"
#include "mesh/validate.h"
#include "mesh/vector.h"
#include "mesh/weld.h"
#include "volcaustic/mesh.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

/// Volume, area and degenerate faces. Everything relative to the centre of the bounds, which keeps the digits of a mesh
/// far from the origin.
void measure(const Mesh& mesh, const WeldedMesh& welded, MeshReport& report) {
  constexpr double kFlat = 1e-14; // sine of the angle at which a triangle is a line for a double
  const Box& box = report.bounds;
  const Vec3d centre{box.min[0] / 2 + box.max[0] / 2, box.min[1] / 2 + box.max[1] / 2, box.min[2] / 2 + box.max[2] / 2};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vec3d p = difference(mesh.positions[a], centre), q = difference(mesh.positions[b], centre),
                r = difference(mesh.positions[c], centre);
    const Vec3d u = difference(q, p), v = difference(r, p), w = difference(r, q);
    const Vec3d normal = cross(u, v);
    const double twiceArea = std::sqrt(dot(normal, normal));
    report.area += twiceArea / 2;
    report.signedVolume += dot(p, cross(q, r)) / 6;
    const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)});
    if (hasRepeatedCorner(welded.triangles[i]) || twiceArea <= kFlat * longest) ++report.degenerateFaces;
  }
}

} // namespace

MeshReport checkMesh(const Mesh& mesh, const RunContext& ctx) {
  requireValid(mesh);
  // Of a triangle: welded corners, three edge keys, its set and its shell; each edge may be remembered as a defect.
  constexpr std::uint64_t kBytesPerTriangle = 12 + 3 * 8 + 3 * 4 + 3 * 8;
  constexpr std::uint64_t kBytesPerVertex = 4 + 2 * 8; // number, two bucket bounds
  ctx.requireMemory(PositionWelder::bytesFor(mesh.positions.size()) + mesh.positions.size() * kBytesPerVertex +
                        mesh.triangles.size() * kBytesPerTriangle,
                    "checking the mesh");
  MeshReport report;
  report.vertices = mesh.positions.size();
  report.triangles = mesh.triangles.size();
  report.bounds = bounds(mesh);
  const WeldedMesh welded = weld(mesh);
  ctx.throwIfCancelled();
  const FaceShells shells = analyseEdges(welded, report);
  ctx.throwIfCancelled();
  if (shells.mayHaveDuplicates) report.duplicateFaces = countDuplicateFaces(welded);
  report.components = countComponents(welded);
  measure(mesh, welded, report);
  analyseShells(mesh, shells, report, ctx);
  return report;
}

} // namespace volcaustic
