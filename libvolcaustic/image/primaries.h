// Colours of one set of primaries in another.
#pragma once

#include "image/colour.h"

#include <optional>
#include <vector>

namespace volcaustic {

/// From linear colours of primaries x, y of red, green, blue and white to Rec. 709's, white to white (Bradford).
/// Nothing where these are Rec. 709's own, none are given, or they span no colours: some programs write zeros.
std::optional<ColourMatrix> rec709From(const std::vector<float>& chromaticities);

} // namespace volcaustic
