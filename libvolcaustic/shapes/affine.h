// Affine placements: one after the other, and back.
#pragma once

#include "volcaustic/types.h"

namespace volcaustic {

double determinant(const Affine& placement);
/// The least factor by which a placement stretches lengths.
double leastStretch(const Affine& toWorld);
/// Of an affine placement that flattens nothing.
Affine inverse(const Affine& placement);
/// First `inner`, then `outer`.
Affine product(const Affine& outer, const Affine& inner);

} // namespace volcaustic
