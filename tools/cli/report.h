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
/// Gives freed memory back and starts peakMemoryBytes() afresh, where the system allows it.
void resetPeakMemory();

Json energyReport(const EnergyBalance& balance);
Json stagesReport(std::span<const StageRun> runs);
/// Photons, steps and what went wrong with them.
Json photonCounts(const EnergyBalance& balance);

/// Prints a value and a line break to stdout.
void printJson(const Json& value);
/// The same to a file, written beside it and renamed when whole. \throws Error(File).
void writeJson(const std::string& path, const Json& value);

} // namespace volcaustic::cli
