// Winding numbers of closed shells at a few points of each other: which shell lies inside which.
#pragma once

#include "mesh/topology.h"

#include <array>
#include <span>
#include <vector>

namespace volcaustic {

/// Shell `outer` winds `winding` times around all of `inner`.
struct Enclosure {
  std::uint32_t inner, outer;
  int winding;
};

/// A closed shell to be nested: its number, and points on it that stand for the whole of it.
struct NestingProbe {
  static constexpr std::size_t kPoints = 3;
  std::uint32_t shell;
  std::array<Vec3d, kPoints> points;
};

struct NestingLimits {
  std::uint64_t pointTests; ///< of a triangle against a point
  std::uint64_t crossings;
};

/// Casts a ray along z from every point of every probe through the triangles of the shells in `isClosed`, and lists the
/// enclosures, by inner shell. A shell that only some of the points are inside of does not enclose. False when a limit
/// was reached; the list is empty then.
bool findEnclosures(const Mesh& mesh, const FaceShells& faces, std::span<const MeshShell> shells,
                    std::span<const std::uint8_t> isClosed, std::span<const NestingProbe> probes,
                    const NestingLimits& limits, std::vector<Enclosure>& enclosures, const RunContext& ctx);

} // namespace volcaustic
