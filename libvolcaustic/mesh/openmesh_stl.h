// Binary STL through OpenMesh's writer, the one of its writers that loses nothing of what its format can hold
// (docs/algorithms/mesh_io.md has what the others do).
#pragma once

#include "volcaustic/mesh.h"

#include <ostream>

namespace volcaustic {

/// Writes a valid mesh whose coordinates fit a float. Whether the stream took it is for the caller to ask the stream.
void writeStlBinary(std::ostream& stream, const Mesh& mesh);

} // namespace volcaustic
