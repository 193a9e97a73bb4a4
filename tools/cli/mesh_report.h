// What mesh2vdb says of the bodies that it filled.
#pragma once

#include "console.h"
#include "report.h"

#include <volcaustic/medium.h>

namespace volcaustic::cli {

/// {name, index, priority, and all of surfaceReport}.
Json bodyReport(const Body& body, const MeshReport& report);
/// The same in lines for people.
void sayBody(Console& console, const Body& body, const MeshReport& report);

} // namespace volcaustic::cli
