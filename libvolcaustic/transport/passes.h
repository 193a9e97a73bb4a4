// The photon and view passes on a medium that is already flat, so that a Session flattens once for both.
#pragma once

#include "volcaustic/photons.h"
#include "volcaustic/view.h"
#include "volume/flatten.h"

namespace volcaustic {

/// tracePhotons; `flat` is flattenMedium of `medium`.
PhotonResult tracePhotons(const Medium& medium, const FlatMediumStorage& flat, std::span<const Light> lights,
                          const PhotonOptions& options, const RunContext& ctx);

/// renderView; likewise.
ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const RadianceVolume& radiance,
                      const Camera& camera, const Background& background, const ViewOptions& options,
                      const RunContext& ctx);

} // namespace volcaustic
