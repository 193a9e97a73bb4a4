// The kernels' step rules from the public options.
#pragma once

#include "kernels/march.h"
#include "volcaustic/photons.h"

namespace volcaustic {

inline kernels::MarchRules marchRules(const PhotonOptions& o) {
  return {static_cast<float>(o.minStep), static_cast<float>(o.maxStep), o.scheme == Scheme::Euler,
          o.lookup == Lookup::Nearest};
}

} // namespace volcaustic
