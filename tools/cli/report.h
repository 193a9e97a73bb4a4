// The one JSON object that --json prints on stdout.
#pragma once

#include <volcaustic/photons.h>
#include <volcaustic/session.h>

#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace volcaustic::cli {

using Json = nlohmann::ordered_json;

/// Highest resident memory of this process so far, in bytes.
std::uint64_t peakMemoryBytes();

Json energyReport(const EnergyBalance& balance);
Json stagesReport(std::span<const StageRun> runs);
/// Photons, steps and what went wrong with them.
Json photonCounts(const EnergyBalance& balance);

/// Prints a value and a line break to stdout.
void printJson(const Json& value);

} // namespace volcaustic::cli
