// What a photon pass books besides the fluence: power by outcome and counts.
//
// A sink is what bodies write to. It provides
//   void deposit(Int3 voxel, Float3 powerLength, Float3 direction)   W*voxel, and direction weighted by its luminance
//   void tally(Outcome, Double3 power)                               W
//   void count(Counter, std::int64_t)
// and sums in integers, so that no order of calls changes the result.
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

enum class Outcome : int { Emitted, Absorbed, Scattered, Escaped, Received, CutOff, TracedLoss, Count };
enum class Counter : int { Emitted, Traced, StepLimit, NotFinite, Steps, VoxelsCrossed, Count };

/// Splits lost power into scattered and absorbed by the albedo of each channel.
template <class Sink>
VOLCAUSTIC_HD inline void tallyLoss(Sink& sink, const Optics& o, const Double3& loss) {
  const auto albedo = [](float s, float t) { return t > 0 ? static_cast<double>(s) / static_cast<double>(t) : 0.0; };
  const Double3 scattered{loss.x * albedo(o.scattering.x, o.attenuation.x),
                          loss.y * albedo(o.scattering.y, o.attenuation.y),
                          loss.z * albedo(o.scattering.z, o.attenuation.z)};
  sink.tally(Outcome::Scattered, scattered);
  sink.tally(Outcome::Absorbed, loss - scattered);
}

} // namespace volcaustic::kernels
