// The sections of a scene file in documented order; the fields inside them are described in volcaustic/options.h.
// Reader, writer and schema are visitors of this one description.
#pragma once

#include "scene/scene_source.h"
#include "volcaustic/options.h"
#include "volcaustic/scene.h"

namespace volcaustic {

/// A visitor has three members: section(key, object, text) for an object, list(key, vector, text) for an array of
/// objects, named(key, vector, text) for an object whose keys are the `name` of each element.
template <class Visitor>
void describeScene(Visitor&& visit, Scene& scene) {
  visit.section("volume", scene.volume, "the box that light is computed in, and what fills it outside the objects");
  visit.named("materials", scene.materials, "what objects are made of, by name");
  visit.list("objects", scene.objects, "bodies that bend light, and volumes made by others");
  visit.list("lights", scene.lights, "sources of photons");
  visit.list("receivers", scene.receivers, "opaque diffuse surfaces: they collect light, cast shadows and are seen");
  visit.section("voxelise", scene.voxelise, "from surfaces to voxels");
  visit.section("stepField", scene.stepField, "how far light may go in one step");
  visit.section("photons", scene.photons, "the photon pass");
  visit.section("camera", scene.camera, "where the picture is taken from");
  visit.section("background", scene.background, "what is around the box: a gradient, or a map of all directions");
  visit.section("view", scene.view, "the camera pass");
  visit.section("frames", scene.frames, "the frames of the animation");
}

} // namespace volcaustic
