/// \file medium.h
/// From surfaces to a sparse optical medium: refractive index, attenuation, scattering and coverage on OpenVDB grids.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/mesh.h"
#include "volcaustic/run_context.h"
#include "volcaustic/shape.h"
#include "volcaustic/types.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// What light meets inside a body. Coefficients in 1/world, Rec. 709 linear.
struct Material {
  std::string name = "glass";
  double index = 1.5;       ///< refractive index n
  Rgb attenuation{0, 0, 0}; ///< extinction coefficient: absorption + out-scattering
  Rgb scattering{0, 0, 0};  ///< scattering coefficient, at most the attenuation
  double asymmetry = 0;     ///< Henyey-Greenstein mean cosine g, -1 < g < 1
};

/// The same four for everything outside the bodies.
struct Ambient {
  double index = 1;
  Rgb attenuation{0, 0, 0};
  Rgb scattering{0, 0, 0};
  double asymmetry = 0;
};

/// How inside and outside are told apart.
enum class FillRule {
  Auto,   ///< Exact for closed, consistently wound meshes, Winding with a warning for all others
  Exact,  ///< signed crossings along rows of sub-voxels: exact for closed meshes
  Winding ///< generalised winding number (Jacobson 2013): sensible for open and damaged meshes
};

struct VoxeliseOptions {
  int supersample = 4; ///< sub-voxels along a voxel's edge: 1, 2, 4 or 8
  int blur = 9;        ///< width of the separable Gaussian on n in voxels: 1 (none), 3, 5, 7, 9 or 11
  FillRule fill = FillRule::Auto;
};

/// Spacing of the step field: how far a ray may go where the medium hardly changes (VD section 2).
struct StepFieldOptions {
  double indexTolerance = 0.005;      ///< a cube whose range of n is below it is crossed in one step
  double indexTolerance2 = 0.02;      ///< a cube whose range of n is below it is crossed in steps of at most `cap`
  double cap = 2;                     ///< longest step in a capped cube, in voxels
  double attenuationTolerance = 0.01; ///< range of attenuation times voxel edge that still counts as constant
};

/// A closed body in world space, a mesh or a shape, and what it is made of. Where bodies overlap, the higher priority
/// wins; of equal priorities, the later one.
struct Body {
  std::shared_ptr<const Mesh> mesh;
  Material material;
  int priority = 0;
  std::string name; ///< for messages
  Shape shape{};    ///< where it is not empty, in place of a mesh: inside is decided at the samples by the shape itself
};

/// What the triangles of one group of a mesh enclose, where that differs from the rest of the mesh: the wine of a
/// glass.
struct GroupMaterial {
  std::string group; ///< one of Mesh::groupNames
  Material material;
  int priority = 0; ///< as of a Body
};

/// The bodies of a mesh whose groups are made of different materials: the triangles of no listed group first, of
/// material `rest` and priority `priority`, then the listed groups in their order. Groups of equal material and
/// priority (and those equal to the rest) are one body, so that a surface may be split into groups and still be closed.
/// A body without a triangle is left out; without `groups` the mesh itself is the only body. \throws Error(Input)
/// "name: no group is called ..." with the nearest group that the mesh has, or for a group that is listed twice.
VOLCAUSTIC_API std::vector<Body> bodiesByGroup(std::shared_ptr<const Mesh> mesh, const Material& rest, int priority,
                                               std::span<const GroupMaterial> groups, const std::string& name,
                                               const RunContext& ctx = {});

struct MediumGrids; // the OpenVDB grids; see openvdb.h

class MediumStore;

/// An immutable optical medium over a domain. Cheap to copy: what it holds is shared.
class VOLCAUSTIC_API Medium {
public:
  Medium() = default;
  Medium(Domain domain, Ambient ambient, std::shared_ptr<MediumStore> store)
      : mDomain(domain), mAmbient(ambient), mStore(std::move(store)) {}

  [[nodiscard]] const Domain& domain() const { return mDomain; }
  [[nodiscard]] const Ambient& ambient() const { return mAmbient; }
  /// Of a medium that was built here they are made on the first call, from any thread.
  [[nodiscard]] const MediumGrids& grids() const;
  [[nodiscard]] MediumStore& store() const { return *mStore; }
  [[nodiscard]] explicit operator bool() const { return mStore != nullptr; }

private:
  Domain mDomain;
  Ambient mAmbient;
  std::shared_ptr<MediumStore> mStore;
};

/// Domain around a box: `resolution` voxels along its longest side (or the given voxel size), plus `padding` voxels on
/// every side. The box is centred.
/// \throws Error(Usage) when the box is empty or not finite, or the domain is beyond 2^15 voxels along an axis.
VOLCAUSTIC_API Domain domainAround(const Box& world, int resolution, double voxelSize, int padding);

/// Voxelises the bodies and blends their optics into the ambient medium (docs/algorithms/voxelise.md):
/// coverage from supersample^3 sub-voxels near the surfaces, n = ambient + sum of coverage*(n_body - n_outside), the
/// same blend for attenuation, scattering and asymmetry, then the Gaussian on n within the narrow band. Grids in the
/// result: index, attenuation, scattering, coverage (summed over bodies), asymmetry where it varies. \throws
/// Error(Input) for a body that is not finite or, with FillRule::Exact, not closed; Error(Usage) for options.
VOLCAUSTIC_API Medium buildMedium(std::span<const Body> bodies, const Ambient& ambient, const Domain& domain,
                                  const VoxeliseOptions& options = {}, const RunContext& ctx = {});

/// A medium whose optics are functions of the world position, sampled at voxel centres: lenses and gradients that no
/// mesh describes. `index` is called from several threads. Attenuation and scattering are the ambient ones.
VOLCAUSTIC_API Medium sampleMedium(const Domain& domain, const Ambient& ambient,
                                   const std::function<double(const Vec3d& pWorld)>& index, const RunContext& ctx = {});

struct SurfaceOptions {
  std::string grid;              ///< name; empty takes `coverage`, else the first scalar grid
  double isovalue = 0.5;         ///< ignored where `automaticIsovalue`
  bool automaticIsovalue = true; ///< 0.5 for fog volumes and coverage, 0 for level sets
  double adaptivity = 0;         ///< 0 keeps every polygon, 1 merges flat regions the most
  bool sharpen = true;           ///< `coverage` at 0.5: keeps corners, edges, and what is thinner than a voxel
};

/// Iso-surface of a grid of a .vdb or .nvdb file (numbers of any type, or the length of vectors where such a grid is
/// named), in world space, the background's side outside (docs/algorithms/surface.md). Closed and consistently wound.
/// \throws Error(File), Error(Input) naming the file and the grids it does hold.
VOLCAUSTIC_API Mesh surfaceFromVdb(const std::filesystem::path& path, const SurfaceOptions& options = {},
                                   const RunContext& ctx = {});

/// The same of the coverage of a medium built here; `options.grid` does not matter.
VOLCAUSTIC_API Mesh surfaceFromMedium(const Medium& medium, const SurfaceOptions& options = {},
                                      const RunContext& ctx = {});

} // namespace volcaustic
