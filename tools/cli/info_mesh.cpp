// info: meshes.
#include "info_report.h"
#include "surface_report.h"
#include "text_table.h"

#include <volcaustic/deform.h>
#include <volcaustic/mesh.h>

#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

constexpr std::size_t kShownRows = 16; // of a table, unless --verbose asks for all
constexpr std::size_t kShownPairs = 4; // of triangles, likewise

std::string vec(const Vec3d& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]); }

std::string sizeOf(const Box& box) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g}", box.max[0] - box.min[0], box.max[1] - box.min[1],
                     box.max[2] - box.min[2]);
}

/// Rows to print of `count`; says how many stay away.
std::size_t shownOf(std::size_t count, bool all) { return all ? count : std::min(count, kShownRows); }
void printOmitted(std::uint64_t omitted, const char* what, bool all) {
  if (omitted > 0) fmt::print("  and {} more {}{}\n", omitted, what, all ? "" : "; --verbose shows more of them");
}

const char* roleText(const MeshShell& s) {
  return s.role == ShellRole::Open && s.openEdges == 0 ? "misoriented" : nameOf(s.role);
}

void printShells(const MeshReport& r, bool all) {
  if (r.shellCount < 2) return;
  using enum TextTable::Align;
  TextTable table(
      {{"shell"}, {"triangles"}, {"signed volume"}, {"area"}, {"size"}, {"open edges"}, {"role", Left}, {"in shell"}});
  const std::size_t shown = shownOf(r.shells.size(), all);
  for (std::size_t i = 0; i < shown; ++i) {
    const MeshShell& s = r.shells[i];
    table.add({fmt::format("{}", i), fmt::format("{}", s.triangles), fmt::format("{:.5g}", s.signedVolume),
               fmt::format("{:.5g}", s.area), sizeOf(s.bounds), fmt::format("{}", s.openEdges), roleText(s),
               s.enclosedBy == MeshShell::kNone ? "-" : fmt::format("{}", s.enclosedBy)});
  }
  fmt::print("{}", table.text("  "));
  printOmitted(r.shellCount - shown, "shells of less area", all);
}

void printGroups(const Json& groups, bool all) {
  if (groups.empty()) return;
  using enum TextTable::Align;
  TextTable table({{"group", Left}, {"triangles"}, {"signed volume"}, {"closed by itself", Left}});
  const std::size_t shown = shownOf(groups.size(), all);
  for (std::size_t i = 0; i < shown; ++i)
    table.add({plain(groups[i]["name"].get<std::string>()),
               fmt::format("{}", groups[i]["triangles"].get<std::size_t>()),
               fmt::format("{:.5g}", groups[i]["signedVolume"].get<double>()),
               groups[i]["closed"].get<bool>() ? "yes" : "no"});
  fmt::print("{}", table.text("  "));
  printOmitted(groups.size() - shown, "groups", all);
}

void printMesh(const std::string& path, const MeshReport& r, const Json& groups, bool all) {
  const FillRoute route = fillRoute(r);
  fmt::print("{}: mesh, {} vertices, {} triangles, {}\n", path, r.vertices, r.triangles,
             r.closedAndConsistent() ? "closed" : "not closed");
  fmt::print("  size           {} world units\n", sizeOf(r.bounds));
  fmt::print("  box            {} to {}\n", vec(r.bounds.min), vec(r.bounds.max));
  fmt::print("  signed volume  {:.8g} world^3; area {:.8g} world^2\n", r.signedVolume, r.area);
  fmt::print("  edges          {} open, {} inconsistently wound, {} non-manifold\n", r.openEdges, r.inconsistentEdges,
             r.nonManifoldEdges);
  fmt::print("  faces          {} flipped, {} duplicate, {} degenerate\n", r.flippedFaces, r.duplicateFaces,
             r.degenerateFaces);
  fmt::print("  shells         {}, of which {} closed; components {}\n", r.shellCount, r.closedShells, r.components);
  fmt::print("{}",
             wrapped("  --fill auto    ", (route.exact ? "exact: " : "generalised winding number: ") + route.reason));
  for (const std::string& remark : shellRemarks(r)) fmt::print("{}", wrapped("  note           ", remark));
  printShells(r, all);
  printGroups(groups, all);
}

void printSelfIntersections(const SelfIntersections& found, bool all) {
  if (!found.any()) {
    fmt::print("  through itself nowhere\n");
    return;
  }
  fmt::print("  through itself {} pairs of triangles, in {} to {}\n", found.pairs, vec(found.bounds.min),
             vec(found.bounds.max));
  const std::size_t shown = all ? found.examples.size() : std::min(found.examples.size(), kShownPairs);
  for (std::size_t i = 0; i < shown; ++i)
    fmt::print("                 {} and {}\n", found.examples[i][0], found.examples[i][1]);
  printOmitted(found.pairs - shown, "pairs", all);
}

Json selfIntersectionReport(const SelfIntersections& found) {
  Json report{{"pairs", found.pairs}, {"examples", found.examples}};
  if (found.any()) report["bounds"] = {{"min", found.bounds.min}, {"max", found.bounds.max}};
  return report;
}

/// A group with a material of its own is a body of its own, so it should close.
Json groupReport(const Mesh& mesh, const RunContext& ctx) {
  Json groups = Json::array();
  if (mesh.triangleGroup.empty()) return groups;
  const std::vector<Mesh> parts = splitByGroup(mesh, ctx);
  for (std::size_t g = 0; g < parts.size(); ++g) {
    const MeshReport r = checkMesh(parts[g], ctx);
    groups.push_back({{"name", mesh.groupNames[g]},
                      {"triangles", r.triangles},
                      {"closed", r.closedAndConsistent()},
                      {"signedVolume", r.signedVolume}});
  }
  return groups;
}

} // namespace

Json meshInfo(const std::string& path, bool selfIntersections, Job& job) {
  const Mesh mesh = readMesh(path, job.context());
  const MeshReport report = checkMesh(mesh, job.context());
  Json groups = groupReport(mesh, job.context());
  if (!job.json()) printMesh(path, report, groups, job.console().isVerbose());
  Json entry{{"kind", "mesh"}};
  entry.update(surfaceReport(report));
  entry["groups"] = std::move(groups);
  if (selfIntersections) {
    const SelfIntersections found = findSelfIntersections(mesh, job.context());
    if (!job.json()) printSelfIntersections(found, job.console().isVerbose());
    entry["selfIntersections"] = selfIntersectionReport(found);
  }
  return entry;
}

} // namespace volcaustic::cli
