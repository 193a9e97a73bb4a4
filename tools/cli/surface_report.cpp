#include "surface_report.h"

namespace volcaustic::cli {

namespace {

Json boxReport(const Box& box) { return {{"min", box.min}, {"max", box.max}}; }

Json shellReport(const MeshShell& shell) {
  return {{"triangles", shell.triangles},
          {"role", nameOf(shell.role)},
          {"closed", shell.closed()},
          {"openEdges", shell.openEdges},
          {"inconsistentEdges", shell.inconsistentEdges},
          {"signedVolume", shell.signedVolume},
          {"area", shell.area},
          {"bounds", boxReport(shell.bounds)},
          {"depth", shell.depth},
          {"enclosedBy", shell.enclosedBy == MeshShell::kNone ? Json() : Json(shell.enclosedBy)}};
}

} // namespace

const char* nameOf(ShellRole role) {
  switch (role) {
  case ShellRole::Open:
    return "open";
  case ShellRole::Flat:
    return "flat";
  case ShellRole::Body:
    return "body";
  case ShellRole::Cavity:
    return "cavity";
  case ShellRole::Immersed:
    break;
  }
  return "immersed";
}

Json surfaceReport(const MeshReport& r) {
  const FillRoute route = fillRoute(r);
  Json shells = Json::array();
  for (const MeshShell& shell : r.shells) shells.push_back(shellReport(shell));
  return {{"vertices", r.vertices},
          {"triangles", r.triangles},
          {"components", r.components},
          {"closed", r.closedAndConsistent()},
          {"fill", route.exact ? "exact" : "winding"},
          {"fillReason", route.reason},
          {"openEdges", r.openEdges},
          {"inconsistentEdges", r.inconsistentEdges},
          {"flippedFaces", r.flippedFaces},
          {"unorientablePatches", r.unorientablePatches},
          {"nonManifoldEdges", r.nonManifoldEdges},
          {"duplicateFaces", r.duplicateFaces},
          {"degenerateFaces", r.degenerateFaces},
          {"signedVolume", r.signedVolume},
          {"area", r.area},
          {"bounds", boxReport(r.bounds)},
          {"shellCount", r.shellCount},
          {"closedShells", r.closedShells},
          {"cavities", r.cavities},
          {"immersedShells", r.immersedShells},
          {"flatShells", r.flatShells},
          {"inwardBodies", r.inwardBodies},
          {"nestingComplete", r.nestingComplete},
          {"shells", std::move(shells)},
          {"remarks", shellRemarks(r)}};
}

} // namespace volcaustic::cli
