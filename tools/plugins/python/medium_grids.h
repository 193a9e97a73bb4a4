// The numbers of a medium as dense arrays: what needs OpenVDB's own header, in one source file.
#pragma once

#include "arrays.h"

#include <volcaustic/medium.h>

namespace volcaustic::python {

enum class MediumField { Index, Attenuation, Scattering, Coverage, Asymmetry };
constexpr int channelsOf(MediumField field) {
  return field == MediumField::Attenuation || field == MediumField::Scattering ? 3 : 1;
}

/// \param into channelsOf(field) numbers for each voxel of the range, z (and then the channel) fastest
void readField(const Medium& medium, MediumField field, const VoxelRange& range, float* into);

} // namespace volcaustic::python
