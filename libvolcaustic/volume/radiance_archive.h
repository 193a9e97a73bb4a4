// A radiance volume as bytes, to the bit.
#pragma once

#include "core/byte_archive.h"
#include "volume/radiance_bricks.h"

namespace volcaustic {

void writeBytes(ByteWriter& out, const RadianceBricks& light);
/// \param light of the same dims, dark. \throws std::out_of_range, Error(Input) beyond the memory limit.
void readBytes(ByteReader& in, RadianceBricks& light, const RunContext& ctx);

} // namespace volcaustic
