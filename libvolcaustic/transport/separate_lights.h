// Lights one by one, and their sums (docs/algorithms/photons.md, "Lights by themselves").
#pragma once

#include "volcaustic/photons.h"

#include <vector>

namespace volcaustic {

/// The context of pass `number` of `count`: its progress is a part of all of them, and its memory what the results
/// before it leave.
RunContext shareOf(const RunContext& ctx, int number, int count, const std::vector<PhotonResult>& before);

/// All light of lights that were traced one by one; PhotonResult::lights holds them.
PhotonResult sumOf(std::vector<PhotonResult> lights, const Domain& domain, const RunContext& ctx);

} // namespace volcaustic
