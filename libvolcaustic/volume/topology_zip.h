// Joins the curves at which two surfaces end.
#pragma once

#include "volcaustic/types.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace volcaustic {

using Curves = std::vector<std::vector<std::uint32_t>>;

/// How each segment of the curves is divided once both surfaces share them.
struct ZippedCurves {
  /// Vertices of the added curves that are one with a vertex of the fixed ones.
  std::unordered_map<std::uint32_t, std::uint32_t> sameAs;
  /// By the vertex that a segment starts at: what lies between it and the next one.
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> inFixed, inAdded;
};

/// Lays each added curve onto the fixed curve along it, which it runs against, and moves its vertices there. False
/// where the curves are not pairs of neighbours nearer than `reach`.
bool zipCurves(const Curves& fixed, const Curves& added, double reach, std::vector<Vec3d>& positions,
               ZippedCurves& zipped);

} // namespace volcaustic
