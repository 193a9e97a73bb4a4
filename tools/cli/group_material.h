// --group NAME:ior=1.33,priority=1: what the triangles of one group of a mesh enclose.
#pragma once

#include <volcaustic/medium.h>

#include <string>

namespace volcaustic::cli {

/// "NAME:KEY=VALUE,..." with the keys of a material (volcaustic/options.h), `ior` for index, and `priority`; RGB is
/// three numbers as 0.1/0.2/0.3 or one for all. What is not given is as in `rest`, the priority 0. NAME may hold
/// colons. \throws Error(Usage) with the keys there are.
GroupMaterial parseGroup(const std::string& text, const Material& rest);

/// \throws Error(Usage) "place: ..." when more is scattered than attenuated.
void requirePhysical(const Material& material, const std::string& place);

} // namespace volcaustic::cli
