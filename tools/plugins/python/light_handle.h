// Arguments that stand for light: a photon pass, or its volume alone.
#pragma once

#include "call.h"
#include "handles.h"
#include "keywords.h"

#include <memory>
#include <vector>
#include <volcaustic/photons.h>
#include <volcaustic/view.h>

namespace volcaustic::python {

using PhotonsHandle = std::shared_ptr<const PhotonResult>;

/// \throws TypeError for what is neither a PhotonResult nor a RadianceVolume.
struct LightArgument {
  explicit LightArgument(py::handle given);
  RadianceVolume radiance;
  LitReceivers receivers;
  PhotonsHandle photons; ///< null for a volume alone
};

/// \throws Error(Usage) for light of another domain than the medium's.
void requireSameDomain(const RadianceVolume& light, const Medium& medium);
/// Receivers with their meshes in memory. Reads files: call it without the interpreter's lock.
std::vector<Receiver> receiversFrom(const std::vector<SceneReceiver>& receivers, const RunContext& ctx);
/// With its map in memory.
Background withMap(Background background, const RunContext& ctx);

} // namespace volcaustic::python
