#include "group_material.h"

#include "named_settings.h"

#include <volcaustic/error.h>

namespace volcaustic::cli {

GroupMaterial parseGroup(const std::string& text, const Material& rest) {
  const std::string place = "--group " + text;
  const std::size_t colon = text.rfind(':');
  if (colon == text.npos || colon == 0)
    throw Error(ErrorKind::Usage, place + ": has no NAME:KEY=VALUE; write it as wine:ior=1.33,priority=1");
  GroupMaterial group{{}, rest, 0};
  group.group = nameAndSettings("--group", text, [&](FieldSetter& setter) {
    describe(setter, group.material);
    setter("priority", group.priority, FieldDoc{"where bodies overlap the higher one wins", "", -1e6, 1e6});
  });
  requirePhysical(group.material, place);
  return group;
}

void requirePhysical(const Material& material, const std::string& place) {
  for (std::size_t channel = 0; channel < material.scattering.size(); ++channel)
    if (material.scattering[channel] > material.attenuation[channel])
      throw Error(ErrorKind::Usage,
                  place + ": scattering is more than attenuation, which includes it; lower it or raise the other");
}

} // namespace volcaustic::cli
