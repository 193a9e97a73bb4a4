#include "mesh_report.h"

#include "surface_report.h"

#include <fmt/format.h>

namespace volcaustic::cli {

Json bodyReport(const Body& body, const MeshReport& report) {
  Json json = {{"name", body.name}, {"index", body.material.index}, {"priority", body.priority}};
  json.update(surfaceReport(report));
  return json;
}

void sayBody(Console& console, const Body& body, const MeshReport& report) {
  const FillRoute route = fillRoute(report);
  console.say(fmt::format("{}: {} triangles, {} shells, index {:g}, priority {}; filled by the {} rule: {}", body.name,
                          report.triangles, report.shellCount, body.material.index, body.priority,
                          route.exact ? "exact" : "winding", route.reason));
  for (std::size_t i = 0; i < report.shells.size(); ++i) {
    const MeshShell& shell = report.shells[i];
    console.say(fmt::format("  shell {}: {}, {} triangles, signed volume {:.6g}", i, nameOf(shell.role),
                            shell.triangles, shell.signedVolume) +
                (shell.enclosedBy == MeshShell::kNone ? "" : fmt::format(", inside shell {}", shell.enclosedBy)));
  }
  for (const std::string& remark : shellRemarks(report)) console.say("  " + remark);
}

} // namespace volcaustic::cli
