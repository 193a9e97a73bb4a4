/// \file medium.h
/// From surfaces to a sparse optical medium: refractive index, attenuation, scattering and coverage on OpenVDB grids.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/mesh.h"
#include "volcaustic/run_context.h"
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

/// A closed body in world space and what it is made of. Where bodies overlap, the higher priority wins; of equal
/// priorities, the later one.
struct Body {
  std::shared_ptr<const Mesh> mesh;
  Material material;
  int priority = 0;
  std::string name; ///< for messages
};

struct MediumGrids; // the OpenVDB grids; see openvdb.h

/// An immutable optical medium over a domain. Cheap to copy: grids are shared.
class VOLCAUSTIC_API Medium {
public:
  Medium() = default;
  Medium(Domain domain, Ambient ambient, std::shared_ptr<const MediumGrids> grids)
      : mDomain(domain), mAmbient(ambient), mGrids(std::move(grids)) {}

  [[nodiscard]] const Domain& domain() const { return mDomain; }
  [[nodiscard]] const Ambient& ambient() const { return mAmbient; }
  [[nodiscard]] const MediumGrids& grids() const { return *mGrids; }
  [[nodiscard]] explicit operator bool() const { return mGrids != nullptr; }

private:
  Domain mDomain;
  Ambient mAmbient;
  std::shared_ptr<const MediumGrids> mGrids;
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
};

/// Iso-surface of a scalar grid of a .vdb or .nvdb file, oriented outwards, in world space.
/// \throws Error(File), Error(Input) naming the file and the grids it does hold.
VOLCAUSTIC_API Mesh surfaceFromVdb(const std::filesystem::path& path, const SurfaceOptions& options = {},
                                   const RunContext& ctx = {});

/// Iso-surface at coverage one half of a medium built here.
VOLCAUSTIC_API Mesh surfaceFromMedium(const Medium& medium, double isovalue = 0.5, double adaptivity = 0);

} // namespace volcaustic
