// A MeshReport as JSON.
#pragma once

#include "report.h"

#include <volcaustic/mesh.h>

namespace volcaustic::cli {

/// "body", "cavity", ...
const char* nameOf(ShellRole role);

/// All of the report, and what follows from it: {triangles, components, closed, openEdges, ..., fill: "exact" or
/// "winding", fillReason, remarks, shells: [{triangles, role, signedVolume, ...}]}.
Json surfaceReport(const MeshReport& report);

} // namespace volcaustic::cli
