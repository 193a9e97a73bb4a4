/// \file photons.h
/// Light sources, the photon pass, and the volume of light that it makes.
#pragma once

#include "volcaustic/background.h"
#include "volcaustic/export.h"
#include "volcaustic/medium.h"
#include "volcaustic/receivers.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

enum class LightType {
  Directional, ///< parallel light of a given irradiance
  Point,       ///< equal intensity in all directions
  Spot,        ///< a point light that shines into a cone
  Environment, ///< what is around the domain, from all directions
  Area         ///< a flat lamp that shines from its front, evenly bright from everywhere (Lambert's law)
};

struct Light {
  std::string name;
  LightType type = LightType::Directional;
  /// World space, any length: propagation of directional light, axis of a spot, where an area light faces.
  Vec3d direction{0, 0, -1};
  Rgb irradiance{1, 1, 1}; ///< W/m2 on a plane that faces the light; directional lights
  Vec3d position{0, 0, 2}; ///< world space; point lights and spots, the middle of an area light
  Rgb intensity{1, 1, 1};  ///< W/sr; point lights, on their axis spots and area lights (radiance times area)
  double outerAngle = 30;  ///< half the opening angle of a spot's cone, degrees, above 0 and at most 90
  double innerAngle = 20;  ///< within this angle of the axis a spot has its whole intensity; at most the outer one
  /// Angular diameter of a directional light's disc in the sky, degrees (the sun's is 0.53); 0 gives sharp shadows.
  double angle = 0;
  /// Of the ball that a point light or spot is, world; it looks evenly bright from everywhere. 0 gives sharp shadows.
  double radius = 0;
  double width = 1, height = 1; ///< of an area light, world
  Vec3d across{
      1, 0,
      0}; ///< of an area light: where its width goes, world space, any length; what is along `direction` is left out
  bool round = false; ///< an area light is an ellipse in its rectangle
  Rgb scale{1, 1, 1}; ///< multiplies the light of the environment
  /// Sharp lights that stand for an environment, an area light, or a light with an angle or a radius; they share its
  /// photons. 0 takes 64 for an environment, 16 for others.
  int samples = 0;
  /// What an environment shines with, visible or not; its map must be read already (readEnvironment). A Session sets it
  /// to the scene's background.
  Background environment{};
};
inline constexpr int kMostLightSamples = 1024;

/// How a photon is carried along d/ds(n dx/ds) = grad n.
enum class Scheme {
  DriftKickDrift, ///< second order, symplectic, one lookup a step: half a drift, the kick n grad n, half a drift
  Euler           ///< VD equations (6) and (7)
};

/// How n and its gradient are read between voxel centres.
enum class Lookup {
  Trilinear, ///< of the eight voxel centres around
  Nearest    ///< of the voxel that the photon is in
};

struct PhotonOptions {
  std::array<int, 2> grid{1024, 1024}; ///< raster through which each light sees the domain's box
  Scheme scheme = Scheme::DriftKickDrift;
  Lookup lookup = Lookup::Trilinear;
  double minStep = 1;    ///< shortest step, in voxels
  double maxStep = 64;   ///< longest step, in voxels
  int maxSteps = 20000;  ///< a photon that needs more is cut off and counted
  double cutoff = 1e-4;  ///< a photon is cut off below this fraction of its first power
  bool roulette = false; ///< below the cutoff play Russian roulette, which keeps the estimate unbiased
  bool jitter = false;   ///< move each photon inside its raster cell, by a hash of seed and cell
  bool smooth = true;    ///< 3x3x3 Gaussian on the finished volume; keeps its total
  /// Each light is traced by itself, as if there were no other, and kept in PhotonResult::lights.
  bool separate = false;
  /// Reflect photons, too, where the index changes within a few voxels, by the chance that Fresnel's equations give
  /// (docs/algorithms/fresnel.md). Else surfaces let all light through that is not totally reflected.
  bool fresnel = false;
};

/// Where the power went, in watts for each channel, and what it took. Everything is summed exactly, so that the figures
/// do not depend on the number of threads.
struct EnergyBalance {
  Rgb emitted{0, 0, 0};   ///< by all lights into the domain's box
  Rgb absorbed{0, 0, 0};  ///< turned to heat
  Rgb scattered{0, 0, 0}; ///< scattered out of the photons' paths (what the view pass shows)
  Rgb escaped{0, 0, 0};   ///< left the box
  Rgb received{0, 0, 0};  ///< landed on receivers
  Rgb cutOff{0, 0, 0};    ///< dropped at the power threshold or the step limit (net of roulette)
  /// Absorbed + scattered power once more, from the volume itself: the sum of attenuation * fluence * voxel volume over
  /// the photons' deposits. It agrees with absorbed + scattered of the traced photons when the deposits are right.
  Rgb tracedLoss{0, 0, 0};
  Rgb depositedLoss{0, 0, 0};

  std::int64_t photonsEmitted = 0; ///< raster cells that see the box
  std::int64_t photonsTraced = 0;  ///< of these, met the refracting region
  std::int64_t photonsAtStepLimit = 0;
  std::int64_t photonsNotFinite = 0;
  std::int64_t steps = 0;
  std::int64_t voxelsCrossed = 0;

  /// |emitted - all others| / emitted, the worst channel.
  [[nodiscard]] double relativeImbalance() const;
};

struct RadianceBricks; // internal storage

/// Light in a domain: fluence of the direct and the caustic part, and mean direction. Immutable, cheap to copy.
class VOLCAUSTIC_API RadianceVolume {
public:
  RadianceVolume() = default;
  RadianceVolume(Domain domain, std::shared_ptr<const RadianceBricks> bricks)
      : mDomain(domain), mBricks(std::move(bricks)) {}
  [[nodiscard]] const Domain& domain() const { return mDomain; }
  [[nodiscard]] const RadianceBricks& bricks() const { return *mBricks; }
  [[nodiscard]] explicit operator bool() const { return mBricks != nullptr; }

  /// Fluence in W/m2 of voxel (i, j, k): all light, or one part of it. Zero outside the domain.
  [[nodiscard]] Vec3f fluence(const Vec3i& voxel) const;
  [[nodiscard]] Vec3f causticFluence(const Vec3i& voxel) const;
  [[nodiscard]] Vec3f directFluence(const Vec3i& voxel) const;
  /// Luminance-weighted mean propagation direction, length at most 1.
  [[nodiscard]] Vec3f direction(const Vec3i& voxel) const;

private:
  Domain mDomain;
  std::shared_ptr<const RadianceBricks> mBricks;
};

/// What a part of a pass took.
struct PassPart {
  std::string name;
  double ms = 0;
};

struct PhotonResult {
  RadianceVolume radiance;
  LitReceivers receivers;
  EnergyBalance balance;
  std::vector<PassPart> parts;        ///< in the order in which they ran
  std::uint64_t sumsBytes = 0;        ///< the most memory that the sums of the photons' light took, on whatever machine
  std::string light{};                ///< of one light by itself: its name in lightLayers
  std::vector<PhotonResult> lights{}; ///< with PhotonOptions::separate: what each light gave by itself
};

/// What the layers and grids of each light by itself are called: by its name, in which every character but ASCII
/// letters, digits, - and _ is replaced by _; light0, light1, ... where it has none. \throws Error(Usage) "lights[i]
/// (name): ..." for names that are not told apart.
VOLCAUSTIC_API std::vector<std::string> lightLayers(std::span<const Light> lights);

/// Sends photons from every light through the medium and collects their fluence (docs/algorithms/photons.md).
/// Light that never meets a bend is evaluated, not traced; it is the direct part. Light ends at receivers, inside the
/// domain's box or beyond it.
/// \throws Error(Usage) for options and lights out of range, Error(Cancelled).
VOLCAUSTIC_API PhotonResult tracePhotons(const Medium& medium, std::span<const Light> lights,
                                         const StepFieldOptions& stepField = {}, const PhotonOptions& options = {},
                                         const RunContext& ctx = {}, std::span<const Receiver> receivers = {});

/// A ray in world space and where it went: what the closed-form tests and curious people look at.
struct TracedRay {
  Vec3d position;             ///< in: start; out: where it left the domain's box
  Vec3d direction;            ///< unit
  double opticalMomentum = 0; ///< out: |v|, equal to n along an exact path
  double length = 0;          ///< in: geometric length after which to stop, 0 for none; out: the length of the path
  int steps = 0;              ///< out
  bool left = false;          ///< out: true when it left the box, false at the length or the step limit
};
/// Carries rays through the medium with the very kernels of the photon pass; nothing is deposited. Rays start inside
/// the domain's box (or on its faces) with |v| = n there.
VOLCAUSTIC_API void traceRays(const Medium& medium, std::span<TracedRay> rays, const StepFieldOptions& stepField = {},
                              const PhotonOptions& options = {}, const RunContext& ctx = {});

} // namespace volcaustic
