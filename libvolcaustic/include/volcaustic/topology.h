/// \file topology.h
/// What becomes of surfaces that meet: run through each other, are kept apart, merge, or split.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/mesh.h"
#include "volcaustic/run_context.h"

#include <cstdint>

namespace volcaustic {

enum class Topology {
  Free,  ///< surfaces may run through each other: nothing is done
  Keep,  ///< parts that meet stay apart: each gives way until `gap` is between them
  Merge, ///< parts that meet or come nearer than `blend` become one, with a smooth blend
  Split  ///< necks thinner than `neck` are cut
};

/// Parts are the closed shells of a mesh. Lengths in the mesh's units.
struct TopologyOptions {
  Topology topology = Topology::Free;
  double gap = 0;       ///< left between parts that are kept apart; 0 takes two voxels
  double blend = 0;     ///< width of the blend; 0 joins them sharply
  double neck = 0;      ///< thickness below which parts are cut; 0 takes four voxels
  double voxelSize = 0; ///< of the level set where surfaces change; 0 takes half the mean edge of the triangles
};

struct TopologyResult {
  Mesh mesh;
  std::uint64_t keptTriangles = 0; ///< of the mesh as it was, corner by corner
  std::uint64_t newTriangles = 0;
  std::uint64_t partsBefore = 0, partsAfter = 0; ///< closed shells
};

/// Changes the surface by a level set where parts meet (or necks are thin), and nowhere else: triangles farther away
/// are kept with their corners as they are, and both are joined without a crack. A mesh where nothing has to be done
/// comes back unchanged (docs/algorithms/topology.md).
/// \throws Error(Input) for a mesh that is not closed and consistently wound, Error(Usage) for options, Error(Input)
/// for voxels too small for the memory limit; Error(Cancelled).
VOLCAUSTIC_API TopologyResult controlTopology(const Mesh& mesh, const TopologyOptions& options,
                                              const RunContext& ctx = {});

} // namespace volcaustic
