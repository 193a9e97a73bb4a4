/// \file deform.h
/// Deformation of triangle meshes by handles and brushes, and what runs through itself afterwards.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/mesh.h"
#include "volcaustic/placement.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace volcaustic {

enum class DeformerType {
  Handle,  ///< vertices in a ball are placed; the rest of the surface follows (DeformMethod)
  Push,    ///< brush: moves the surface by `strength` along `direction`, against its mean normal where that is zero
  Pull,    ///< brush: the opposite of Push
  Inflate, ///< brush: moves each vertex by `strength` along its own normal
  Twist,   ///< brush: turns by `strength` degrees about `direction` through the centre
  Smooth   ///< brush: `strength` from 0 to 1 of the way to a fair surface (Taubin 1995, which does not shrink it)
};

/// One step of a deformation. Space is that of the mesh as it was before all steps.
struct Deformer {
  DeformerType type = DeformerType::Handle;
  Vec3d center{0, 0, 0};
  /// Of the ball of vertices, by their positions before all steps: a handle holds all in it alike, a brush fades from
  /// its centre as (1 - (d/radius)^2)^2, which ends smoothly.
  double radius = 0.1;
  Vec3d direction{0, 0, 0}; ///< any length
  double strength = 0;      ///< length, degrees of Twist, part of Smooth
  Placement placement;      ///< of a handle, about its centre; as it is, the handle holds still
};

/// How a surface follows its handles.
enum class DeformMethod {
  AsRigidAsPossible, ///< Sorkine, Alexa 2007: local rotations, so that details keep their shape
  Laplacian          ///< Sorkine et al. 2004 without rotations: one linear solve, for small movements
};

struct DeformOptions {
  DeformMethod method = DeformMethod::AsRigidAsPossible;
  int iterations = 10; ///< of local rotations and global positions
};

/// Deforms one mesh again and again. Handles that stay where they are and only change their placement share one
/// factorisation, so each further call costs back substitutions alone. The result depends on the arguments of the call
/// alone, bit by bit.
class VOLCAUSTIC_API MeshDeformer {
public:
  /// \throws Error(Input) for a mesh that is not valid.
  explicit MeshDeformer(std::shared_ptr<const Mesh> rest);
  ~MeshDeformer();
  MeshDeformer(MeshDeformer&&) noexcept;
  MeshDeformer& operator=(MeshDeformer&&) noexcept;

  [[nodiscard]] const std::shared_ptr<const Mesh>& rest() const;
  /// The rest mesh after all steps, in their order; handles that follow each other act together. Connectivity and
  /// groups stay as they are. Parts of the surface that no handle holds stay where they are.
  /// \throws Error(Usage) "deform[i]: ..." for a radius, a direction or a strength that has no meaning, and for a
  /// handle that holds no vertex; Error(Cancelled).
  [[nodiscard]] Mesh deform(std::span<const Deformer> steps, const DeformOptions& options = {},
                            const RunContext& ctx = {});

private:
  struct State;
  std::unique_ptr<State> mState;
};

/// The same at once.
VOLCAUSTIC_API Mesh deformed(const Mesh& mesh, std::span<const Deformer> steps, const DeformOptions& options = {},
                             const RunContext& ctx = {});

/// Where a surface runs through itself: pairs of triangles that share a point which is no vertex or edge of both.
struct SelfIntersections {
  static constexpr std::size_t kListed = 64;
  std::uint64_t pairs = 0;
  std::vector<std::array<std::uint32_t, 2>> examples; ///< the first kListed pairs, in order of their triangles
  Box bounds;                                         ///< of all triangles in pairs; zeros where there is none
  [[nodiscard]] bool any() const { return pairs != 0; }
};

/// Exact in its decisions (vertices of equal position count as one). \throws Error(Input) for a mesh that is not valid.
VOLCAUSTIC_API SelfIntersections findSelfIntersections(const Mesh& mesh, const RunContext& ctx = {});

} // namespace volcaustic
