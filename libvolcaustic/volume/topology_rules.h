// What the level set of a surface becomes where parts meet.
#pragma once

#include "volcaustic/topology.h"
#include "volume/topology_region.h"

#include <algorithm>

namespace volcaustic {

/// Lengths as chosen, in place of zeros.
struct TopologyLengths {
  double voxelSize, gap, blend, neck;
};

struct LevelSet {
  BlockGrid grid;
  std::vector<float> value;          ///< distance from the new surface, negative inside
  std::vector<std::uint8_t> changed; ///< 1 at nodes near either surface where the old one cannot stay
  [[nodiscard]] bool anyChange() const { return std::find(changed.begin(), changed.end(), 1) != changed.end(); }
};

/// `everywhere` holds the whole surface, not only where something changes.
LevelSet mergedParts(const SurfaceParts& parts, const TopologyLengths& lengths, bool everywhere, const RunContext& ctx);
/// Of part `part` beside all others.
LevelSet keptApart(const SurfaceParts& parts, std::size_t part, const TopologyLengths& lengths, bool everywhere,
                   const RunContext& ctx);
/// Of part `part` alone; `parts` holds nothing else.
LevelSet splitAtNecks(const SurfaceParts& parts, const TopologyLengths& lengths, bool everywhere,
                      const RunContext& ctx);

/// The level set of the only part as it is, up to `limit`.
LevelSet measuredPart(BlockGrid grid, const SurfaceParts& parts, double limit, const RunContext& ctx);

/// Distance from the change at each node, less `margin`: negative where the surface is made anew.
std::vector<float> distanceFromChange(const LevelSet& levelSet, double margin, const RunContext& ctx);

} // namespace volcaustic
