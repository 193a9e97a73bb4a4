#include "mesh/shells.h"

#include "mesh/nesting.h"
#include "mesh/vector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace volcaustic {

namespace {

/// Area, volume, bounds and edges of all shells. A volume is summed from a corner of its own shell, which keeps the
/// digits of a small one far away.
std::vector<MeshShell> measureShells(const Mesh& mesh, const FaceShells& faces) {
  std::vector<MeshShell> shells(faces.count);
  std::vector<const Vec3d*> origins(faces.count, nullptr);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (faces.shellOf[i] == FaceShells::kNone) continue;
    MeshShell& shell = shells[faces.shellOf[i]];
    const auto& [ia, ib, ic] = mesh.triangles[i];
    const Vec3d &a = mesh.positions[ia], &b = mesh.positions[ib], &c = mesh.positions[ic];
    const Vec3d*& origin = origins[faces.shellOf[i]];
    if (!origin) {
      origin = &a;
      shell.bounds = {a, a};
    }
    const Vec3d normal = cross(difference(b, a), difference(c, a));
    ++shell.triangles;
    shell.area += std::sqrt(dot(normal, normal)) / 2;
    shell.signedVolume += dot(difference(a, *origin), normal) / 6;
    for (const Vec3d* p : {&a, &b, &c})
      for (int k = 0; k < 3; ++k) {
        shell.bounds.min[k] = std::min(shell.bounds.min[k], (*p)[k]);
        shell.bounds.max[k] = std::max(shell.bounds.max[k], (*p)[k]);
      }
  }
  for (const std::uint32_t face : faces.openEdgeFaces) ++shells[faces.shellOf[face]].openEdges;
  for (const std::uint32_t face : faces.inconsistentEdgeFaces) ++shells[faces.shellOf[face]].inconsistentEdges;
  return shells;
}

/// A sheet with a face for each side encloses nothing but rounding errors.
bool isFlat(const MeshShell& shell) {
  constexpr double kRounding = 1e-12;
  return std::abs(shell.signedVolume) <= kRounding * std::pow(shell.area, 1.5);
}

/// For each shell that `wanted` marks the centres of three of its faces, far from each other in the order of the file.
std::vector<NestingProbe> probesFor(const Mesh& mesh, const FaceShells& faces, const std::vector<MeshShell>& shells,
                                    const std::vector<std::uint8_t>& wanted) {
  std::vector<NestingProbe> probes;
  std::vector<std::uint32_t> probeOf(shells.size(), 0);
  for (std::uint32_t s = 0; s < shells.size(); ++s)
    if (wanted[s]) {
      probeOf[s] = static_cast<std::uint32_t>(probes.size());
      probes.push_back({s, {}});
    }
  std::vector<std::uint64_t> seen(shells.size(), 0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t s = faces.shellOf[i];
    if (s == FaceShells::kNone || !wanted[s]) continue;
    const std::uint64_t face = seen[s]++;
    for (std::size_t k = 0; k < NestingProbe::kPoints; ++k) {
      if (face != k * shells[s].triangles / NestingProbe::kPoints) continue;
      const auto& [a, b, c] = mesh.triangles[i];
      for (int axis = 0; axis < 3; ++axis)
        probes[probeOf[s]].points[k][axis] =
            (mesh.positions[a][axis] + mesh.positions[b][axis] + mesh.positions[c][axis]) / 3;
    }
  }
  return probes;
}

/// Depth, encloser and role of the shells that `nests` marks. `enclosedBy` is a number of `shells` yet.
void applyEnclosures(std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& nests,
                     const std::vector<Enclosure>& enclosures) {
  std::vector<int> windingAround(shells.size(), 0);
  for (const auto& [inner, outer, winding] : enclosures) {
    ++shells[inner].depth;
    windingAround[inner] += winding;
  }
  for (const auto& [inner, outer, winding] : enclosures) {
    std::size_t& innermost = shells[inner].enclosedBy;
    if (innermost == MeshShell::kNone || shells[outer].depth > shells[innermost].depth) innermost = outer;
  }
  for (std::size_t s = 0; s < shells.size(); ++s) {
    if (!nests[s]) continue;
    const int inside = windingAround[s] + (shells[s].signedVolume > 0 ? 1 : -1);
    shells[s].role = windingAround[s] == 0 ? ShellRole::Body : inside == 0 ? ShellRole::Cavity : ShellRole::Immersed;
  }
}

/// Sets the roles of all shells. Returns false when there are so many that only the `largest` were compared.
bool nestShells(const Mesh& mesh, const FaceShells& faces, const std::vector<std::size_t>& largest,
                std::vector<MeshShell>& shells, const RunContext& ctx) {
  constexpr NestingLimits kAll{1 << 26, 1 << 22}; // some tenths of a second
  constexpr NestingLimits kLargest{std::numeric_limits<std::uint64_t>::max(), 1 << 22};
  std::vector<std::uint8_t> nests(shells.size(), 0);
  for (std::size_t s = 0; s < shells.size(); ++s) {
    if (!shells[s].closed()) continue;
    nests[s] = !isFlat(shells[s]);
    shells[s].role = nests[s] ? ShellRole::Body : ShellRole::Flat;
  }
  std::vector<Enclosure> enclosures;
  bool complete = true;
  if (std::accumulate(nests.begin(), nests.end(), std::size_t{0}) > 1)
    complete = findEnclosures(mesh, faces, shells, nests, probesFor(mesh, faces, shells, nests), kAll, enclosures, ctx);
  if (!complete) {
    std::vector<std::uint8_t> few(shells.size(), 0);
    for (const std::size_t s : largest) few[s] = nests[s];
    findEnclosures(mesh, faces, shells, few, probesFor(mesh, faces, shells, few), kLargest, enclosures, ctx);
  }
  applyEnclosures(shells, nests, enclosures);
  return complete;
}

std::vector<std::size_t> largestShells(const std::vector<MeshShell>& shells) {
  std::vector<std::size_t> order(shells.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto listed = order.begin() + static_cast<std::ptrdiff_t>(std::min(order.size(), MeshReport::kListedShells));
  // Coordinates near the end of the doubles make areas that are no number; they come last.
  const auto area = [&](std::size_t i) { return std::isnan(shells[i].area) ? -1 : shells[i].area; };
  std::partial_sort(order.begin(), listed, order.end(),
                    [&](std::size_t a, std::size_t b) { return area(a) != area(b) ? area(a) > area(b) : a < b; });
  order.erase(listed, order.end());
  return order;
}

} // namespace

void analyseShells(const Mesh& mesh, const FaceShells& faces, MeshReport& report, const RunContext& ctx) {
  constexpr std::uint64_t kBytesPerShell = sizeof(MeshShell) + sizeof(NestingProbe) + 64;
  ctx.requireMemory(faces.count * kBytesPerShell, "checking the parts of the mesh");
  std::vector<MeshShell> shells = measureShells(mesh, faces);
  const std::vector<std::size_t> largest = largestShells(shells);
  report.nestingComplete = nestShells(mesh, faces, largest, shells, ctx);
  for (const MeshShell& shell : shells) {
    report.closedShells += shell.closed();
    report.cavities += shell.role == ShellRole::Cavity;
    report.immersedShells += shell.role == ShellRole::Immersed;
    report.flatShells += shell.role == ShellRole::Flat;
    report.inwardBodies += shell.role == ShellRole::Body && shell.signedVolume < 0;
  }
  for (const std::size_t s : largest) {
    MeshShell& shell = report.shells.emplace_back(shells[s]);
    const auto listed = std::find(largest.begin(), largest.end(), shell.enclosedBy);
    shell.enclosedBy = listed == largest.end() ? MeshShell::kNone : static_cast<std::size_t>(listed - largest.begin());
  }
}

} // namespace volcaustic
