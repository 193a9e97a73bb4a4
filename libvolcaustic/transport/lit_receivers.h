// What LitReceivers holds.
#pragma once

#include "transport/receiver_light.h"

namespace volcaustic {

struct LitReceiverData {
  ReceiverSet set;
  ReceivedLight light;

  [[nodiscard]] kernels::ReceiverScene scene() const { return set.scene(light.irradiance.data()); }
};

} // namespace volcaustic
