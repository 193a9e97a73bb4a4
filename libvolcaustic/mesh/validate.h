// What every function that takes a Mesh from a caller may rely on.
#pragma once

#include "volcaustic/mesh.h"

namespace volcaustic {

/// \throws Error(Input) "mesh: ..." when a triangle refers to no vertex, a coordinate is not finite, or the groups do
/// not match the triangles.
void requireValid(const Mesh& mesh);

} // namespace volcaustic
