// Puts the new surface of a level set in place of the old one, and joins them where the old one stays.
#pragma once

#include "volume/topology_rules.h"

#include <optional>

namespace volcaustic {

/// A surface made anew in part. Vertices below the count of the welded surface's are its own; the others follow.
struct RemadeSurface {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::vector<std::uint32_t> kept;        ///< triangles of the welded surface that stay corner by corner
  std::vector<Vec3d> positions;           ///< of the welded surface, then new ones
  std::vector<TriangleCorners> triangles; ///< new ones
  std::vector<std::uint32_t> cutFrom;     ///< of each new one: the old triangle that it is a piece of, or kNone
};

struct StitchRules {
  /// The closest point of the old surface that may stay, near a point of the new one.
  std::function<ClosestPoint(const Vec3d& p, double within)> closestOld;
  /// Whether old surface that no change touches stays, told by a point just outside of it.
  std::function<bool(const Vec3d& p)> stays;
};

/// Replaces `faces` of the surface where `level` is negative by the level set's contour. Empty where the two surfaces
/// do not end alike; another level may do.
std::optional<RemadeSurface> stitched(const WeldedSurface& surface, const std::vector<std::uint32_t>& faces,
                                      const LevelSet& set, const std::vector<float>& level, const StitchRules& rules,
                                      const RunContext& ctx);

/// Replaces `faces` as a whole.
RemadeSurface replaced(const WeldedSurface& surface, const LevelSet& set, const StitchRules& rules,
                       const RunContext& ctx);

} // namespace volcaustic
