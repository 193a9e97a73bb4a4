// What each shell of a mesh encloses, and which shell lies inside which.
#pragma once

#include "mesh/topology.h"

namespace volcaustic {

/// Measures the shells, nests the closed ones, and fills in what the report says of shells.
/// \throws Error(Input) beyond the memory limit, Error(Cancelled).
void analyseShells(const Mesh& mesh, const FaceShells& faces, MeshReport& report, const RunContext& ctx);

} // namespace volcaustic
