// A ray of the camera: what it carries, what all rays share, and what they meet at their ends.
#pragma once

#include "kernels/background.h"
#include "kernels/camera.h"
#include "kernels/fresnel.h"
#include "kernels/pixel_filter.h"
#include "kernels/receivers.h"
#include "kernels/view_light.h"

namespace volcaustic::kernels {

struct ViewRules {
  MarchRules march;
  float step = 1;
  std::int32_t maxSteps = 20000;
  float cameraIndex = 1;  ///< n at the camera
  float ambientIndex = 1; ///< n beyond the box
  bool fresnel = false;   ///< rays are reflected, too, where the index changes within a few voxels (fresnel.h)
  Environment background; ///< beyond the box
};

/// What a brick holds for rays of the camera, in the low bits of ViewPlan::bricks.
inline constexpr std::int32_t kPlanBusy = 1; ///< light may bend in it, or its optics change; it has voxels
inline constexpr std::int32_t kPlanFine = 2; ///< scatters light that varies from voxel to voxel
inline constexpr std::int32_t kPlanLit = 4;  ///< scatters light
/// The other bits: a busy brick's slot in ViewPlan::voxels, or the entry in FlatMedium::optics of one that is not busy.
inline constexpr int kPlanShift = 3;

/// Where rays have to look closely.
struct ViewPlan {
  const std::int32_t* bricks = nullptr;
  /// 512 for each busy brick, z fastest: a step byte (flat_medium.h), and above its eight bits an entry of
  /// FlatMedium::optics.
  const std::int32_t* voxels = nullptr;
  GridBox box; ///< beyond it a ray meets nothing
};

/// All that a pixel depends on.
struct ViewScene {
  FlatMedium medium;
  ViewLight light;
  ViewPlan plan;
  ReceiverScene receivers;
  CameraFrame camera;
  ViewRules rules;
  PixelSampler sampler;
};

/// What became of rays.
template <class F>
struct RayEnd {
  MaskOf<F> notFinite, stepLimit;
};

/// A reflected ray that waits until the one it left has come to its end.
template <class F>
struct WaitingRay {
  RayOf<F> ray{{F(0), F(0), F(0)}, {F(1), F(0), F(0)}};
  Vec3<F> share{F(0), F(0), F(0)}; ///< of what it sees, that reaches the camera
  F rise{0};                       ///< of the crossing that it comes from
};

/// What follows a camera's ray through surfaces that reflect.
template <class F>
struct ViewMirrors {
  SurfaceCrossing<F> crossing;
  WaitingRay<F> waiting[2];

  template <class Visit>
  VOLCAUSTIC_HD void forEach(const Visit& visit) {
    crossing.forEach(visit);
    for (WaitingRay<F>& w : waiting) {
      for (Vec3<F>* v : {&w.ray.x, &w.ray.v, &w.share}) visit(v->x), visit(v->y), visit(v->z);
      visit(w.rise);
    }
  }
};
inline constexpr int kViewMirrorsNumbers = kSurfaceCrossingNumbers + 2 * 10;

/// A ray on its way from the camera.
template <class F>
struct ViewRay {
  RayOf<F> ray;
  Vec3<F> transmitted{F(1), F(1), F(1)}, caustic{F(0), F(0), F(0)}, direct{F(0), F(0), F(0)};
  /// Of the background and of receivers; and the share of the rays that came to the background.
  Vec3<F> background{F(0), F(0), F(0)}, receiver{F(0), F(0), F(0)}, through{F(0), F(0), F(0)};
  F travelled{0}, depth{3.0e38f};
  IntOf<F> steps{0};
  /// The way ahead through a brick that is not busy, 0 where none is known; the plan's word for the brick; and the way
  /// ahead through the plan's box.
  F clear{0};
  IntOf<F> plan{0};
  F box{0};
  /// The optics of the last step, and what stands in the table for them.
  IntOf<F> optics{-1};
  Vec3<F> attenuation{F(0), F(0), F(0)}, scattering{F(0), F(0), F(0)};
  F asymmetry{0};
  ViewMirrors<F> mirrors;

  /// Calls visit(i, number) for each number of it.
  template <class Visit>
  VOLCAUSTIC_HD void forEach(const Visit& visit) {
    int i = 0;
    for (Vec3<F>* v : {&ray.x, &ray.v, &transmitted, &caustic, &direct, &background, &receiver, &through, &attenuation,
                       &scattering}) {
      visit(i++, v->x);
      visit(i++, v->y);
      visit(i++, v->z);
    }
    for (F* v : {&travelled, &depth, &clear, &box, &asymmetry}) visit(i++, *v);
    for (IntOf<F>* v : {&steps, &plan, &optics}) visit(i++, *v);
    mirrors.forEach([&](F& v) { visit(i++, v); });
  }
};
inline constexpr int kViewRayNumbers = 38 + kViewMirrorsNumbers;

/// Adds the light of receivers to the rays that meet them, which end there.
template <class F>
VOLCAUSTIC_HD inline void receive(const ViewScene& scene, ViewRay<F>& r, const ReceiverHit<F>& hit,
                                  const MaskOf<F>& on) {
  const Vec3<F>& v = r.ray.v;
  const F inverse = inverseRoot(dot(v, v)), index = F(scene.rules.cameraIndex) * inverse;
  const Vec3<F> light = receiverRadiance<F>(scene.receivers, hit, v, on) * (index * index);
  r.receiver = select<F>(on, r.receiver + r.transmitted * light, r.receiver);
  r.transmitted = select<F>(on, Vec3<F>(F(0)), r.transmitted);
}

/// Adds a share of the background in the direction v to the rays `on`.
template <class F>
VOLCAUSTIC_HD inline void seeBackground(const ViewScene& scene, ViewRay<F>& r, const Vec3<F>& v, const Vec3<F>& share,
                                        const MaskOf<F>& on) {
  const float ratio = scene.rules.cameraIndex / scene.rules.ambientIndex;
  if (!any(on)) return;
  const Vec3<F> towards = v * inverseRoot(dot(v, v));
  const Vec3<F> light = share * scene.rules.background.radiance<F>(towards) * F(ratio * ratio);
  r.background = select<F>(on, r.background + light, r.background);
  r.through = select<F>(on, r.through + share, r.through);
}

/// Adds what is beyond the box to the rays `on` that have left it: receivers, else the background.
template <class F>
VOLCAUSTIC_HD inline void arrive(const ViewScene& scene, ViewRay<F>& r, const MaskOf<F>& on) {
  if (scene.receivers.any()) {
    const MaskOf<F> looks = both(on, maxComponent(r.transmitted) > F(0));
    const Vec3<F> towards = r.ray.v * inverseRoot(dot(r.ray.v, r.ray.v));
    const ReceiverHit<F> hit =
        nearestHit<F>(scene.receivers, r.ray.x, towards, F(-kReceiverOverlap), F(3.0e38f), looks, true);
    const MaskOf<F> lands = found(hit);
    if (any(lands)) {
      receive(scene, r, hit, lands);
      r.depth = select(lands, smaller(r.depth, r.travelled + hit.distance), r.depth);
    }
  }
  seeBackground(scene, r, r.ray.v, r.transmitted, on);
}

} // namespace volcaustic::kernels
