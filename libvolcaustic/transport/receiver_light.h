// Irradiance on receivers, texel by texel: light that came straight, and photons that landed
// (docs/algorithms/receivers.md). The same bits for any number of threads.
#pragma once

#include "kernels/emission.h"
#include "transport/landing_beams.h"
#include "transport/receiver_set.h"
#include "transport/soft_lights.h"
#include "volcaustic/medium.h"

#include <span>
#include <vector>

namespace volcaustic {

/// Three floats (R, G, B) a texel, W/m2. Texels without surface that a lookup on the surface beside them reads have the
/// light of that.
struct ReceivedLight {
  std::vector<float> irradiance; ///< caustic + direct: what kernels::ReceiverScene takes
  std::vector<float> caustic, direct;
};

class ReceiverLight {
public:
  /// The set must live as long.
  ReceiverLight(const ReceiverSet& set, const Domain& domain, const Ambient& ambient, const RunContext& ctx);

  /// Light of a part that met no bend on its way, through one of its rasters: where the raster's ray there bends before
  /// the receiver (entry: distances relative to frame.depth0), photons carry the light. Light beside the raster is
  /// added, too; of six rasters around a light each adds what it sees. A part without rasters (a spot whose cone misses
  /// the domain) still lights receivers: call once with a frame of no cells.
  void addDirect(const LightPart& part, const kernels::EmissionFrame& frame, std::span<const float> entry);

  /// Photons of a raster that landed, one for each cell.
  void addLandings(const kernels::EmissionFrame& frame, std::span<const kernels::Landing> landings);

  /// Once, after all of them.
  [[nodiscard]] ReceivedLight finish();

private:
  void fillBorders(std::vector<float>& light) const;

  const ReceiverSet& mSet;
  Domain mDomain;
  Ambient mAmbient;
  RunContext mCtx;
  std::vector<float> mDirect; ///< W/m2
  std::vector<float> mLanded; ///< W
  TexelPower mUnits;
};

} // namespace volcaustic
