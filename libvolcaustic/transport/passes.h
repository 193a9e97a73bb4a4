// The photon and view passes on a medium that is already flat, so that a Session flattens once for both.
#pragma once

#include "transport/tracers.h"
#include "volcaustic/photons.h"
#include "volcaustic/view.h"
#include "volume/flatten.h"

namespace volcaustic {

/// tracePhotons; `flat` is flattenMedium of `medium`. `state` is what passes in a row share: the choice of a device and
/// the balance between two of them.
PhotonResult tracePhotons(const Medium& medium, const FlatMediumStorage& flat, std::span<const Light> lights,
                          std::span<const Receiver> receivers, const PhotonOptions& options, const RunContext& ctx,
                          std::shared_ptr<TracerState> state = std::make_shared<TracerState>());

/// renderView; likewise.
ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const RadianceVolume& radiance,
                      const LitReceivers& receivers, const Camera& camera, const Background& background,
                      const ViewOptions& options, const RunContext& ctx, const ViewObserver& observer = {});

/// renderView of all light; where each light was traced by itself, it is also viewed by itself: the picture is the sum,
/// with layers of each light, and the observer sees the sum so far after each.
ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const PhotonResult& photons,
                      const Camera& camera, const Background& background, const ViewOptions& options,
                      const RunContext& ctx, const ViewObserver& observer = {});

} // namespace volcaustic
