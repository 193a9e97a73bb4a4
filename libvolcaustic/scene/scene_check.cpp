#include "scene/scene_check.h"

#include "core/nearest_word.h"
#include "scene/json_document.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace volcaustic {

namespace {

double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d difference(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// For a Material or the Ambient.
template <class Optics>
void checkOptics(const Optics& optics, const std::string& pointer, const SceneSource& source) {
  for (int channel = 0; channel < 3; ++channel)
    if (optics.scattering[channel] > optics.attenuation[channel])
      source.fail(pointer + "/scattering/" + std::to_string(channel),
                  excerpt(optics.scattering[channel]) + " is more than the attenuation, " +
                      excerpt(optics.attenuation[channel]) + ", which includes it; lower it or raise the attenuation");
}

void checkVolume(const Scene& scene, const SceneSource& source) {
  const SceneVolume& volume = scene.volume;
  checkOptics(volume.ambient, "/volume", source);
  if (!volume.file.empty()) {
    if (!scene.objects.empty()) source.fail("/volume/file", "takes the place of the objects; remove it or /objects");
    return;
  }
  if (!volume.automatic) {
    for (int axis = 0; axis < 3; ++axis)
      if (!(volume.bounds.max[axis] > volume.bounds.min[axis]))
        source.fail("/volume/bounds/max/" + std::to_string(axis), "must be above bounds/min/" + std::to_string(axis));
  } else if (std::none_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& o) { return o.visible; })) {
    source.fail("/volume/bounds", "\"auto\" needs a visible object; add one to /objects, or give min and max");
  }
}

void checkMaterialName(const std::string& material, const std::vector<std::string>& names, const std::string& pointer,
                       const SceneSource& source) {
  if (std::find(names.begin(), names.end(), material) != names.end()) return;
  source.fail(pointer + "/material",
              "no material is called " + excerpt(material) + "; " +
                  (names.empty() ? "add it to /materials"
                                 : "the nearest known one is " + excerpt(nearestWord(material, names))));
}

/// Which groups there are, only the mesh knows.
void checkGroups(const SceneObject& object, const std::vector<std::string>& materials, const std::string& pointer,
                 const SceneSource& source) {
  std::set<std::string> listed;
  for (std::size_t i = 0; i < object.groups.size(); ++i) {
    const std::string here = pointer + "/groups/" + std::to_string(i);
    checkMaterialName(object.groups[i].material, materials, here, source);
    if (!listed.insert(object.groups[i].name).second)
      source.fail(here + "/name", excerpt(object.groups[i].name) + " is listed twice; remove one of the two");
  }
}

void checkDeformation(const SceneObject& object, const std::string& pointer, const SceneSource& source) {
  if (!object.volumeFile.empty()) {
    if (!object.deform.empty())
      source.fail(pointer + "/deform", "deforms surfaces, which a volume has none of; remove it");
    if (object.topology.topology != Topology::Free)
      source.fail(pointer + "/topology", "is that of surfaces, which a volume has none of; remove it");
  }
  for (std::size_t i = 0; i < object.deform.size(); ++i) {
    const Deformer& d = object.deform[i];
    const std::string here = pointer + "/deform/" + std::to_string(i);
    if (!(d.radius > 0)) source.fail(here + "/radius", "must be above 0: it says which vertices are meant");
    if (d.type == DeformerType::Twist && dot(d.direction, d.direction) == 0)
      source.fail(here + "/direction", "has no length; give the axis of the twist, as [0, 0, 1]");
    if (d.type == DeformerType::Smooth && !(d.strength >= 0 && d.strength <= 1))
      source.fail(here + "/strength", excerpt(d.strength) + " is not a part of smooth; give 0 to 1");
  }
}

/// Which grids there are, only the file knows.
void checkVolumeObject(const SceneObject& object, const std::string& pointer, const SceneSource& source) {
  if (!object.meshFile.empty()) source.fail(pointer + "/volume", "stands beside a mesh; make two objects of them");
  if (!object.groups.empty()) source.fail(pointer + "/groups", "are those of a mesh; remove them");
  if (object.grids.empty())
    source.fail(pointer + "/grids", "are missing; say what a grid is, as [{\"name\": \"density\", \"property\": "
                                    "\"attenuation\"}]");
  std::set<OpticalProperty> listed;
  for (std::size_t i = 0; i < object.grids.size(); ++i)
    if (!listed.insert(object.grids[i].property).second)
      source.fail(pointer + "/grids/" + std::to_string(i) + "/property",
                  "is that of another grid too; remove one, or make two objects of the volume");
  if (listed.contains(OpticalProperty::Asymmetry) && !listed.contains(OpticalProperty::Scattering))
    source.fail(pointer + "/grids", "give asymmetry without scattering; say what scatters too");
}

void checkMeshObject(const SceneObject& object, const std::vector<std::string>& materials, const std::string& pointer,
                     const SceneSource& source) {
  if (object.meshFile.empty()) source.fail(pointer + "/mesh", "is missing; give a mesh file, or a shape or a volume");
  if (!object.grids.empty()) source.fail(pointer + "/grids", "are those of a volume; remove them");
  checkMaterialName(object.material, materials, pointer, source);
  checkGroups(object, materials, pointer, source);
}

/// What its nodes may be was checked when they were read.
void checkShapeObject(const SceneObject& object, const std::vector<std::string>& materials, const std::string& pointer,
                      const SceneSource& source) {
  if (!object.meshFile.empty() || !object.volumeFile.empty())
    source.fail(pointer + "/shape", "stands beside a mesh or a volume; make two objects of them");
  if (!object.groups.empty())
    source.fail(pointer + "/groups", "are those of a mesh; make an object of each part of the shape");
  if (!object.grids.empty()) source.fail(pointer + "/grids", "are those of a volume; remove them");
  checkMaterialName(object.material, materials, pointer, source);
}

void checkObjects(const Scene& scene, const SceneSource& source) {
  std::vector<std::string> names;
  for (const Material& material : scene.materials) {
    checkOptics(material, "/materials/" + pointerToken(material.name), source);
    names.push_back(material.name);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const std::string pointer = "/objects/" + std::to_string(i);
    if (!object.shape.empty())
      checkShapeObject(object, names, pointer, source);
    else if (object.volumeFile.empty())
      checkMeshObject(object, names, pointer, source);
    else
      checkVolumeObject(object, pointer, source);
    checkDeformation(object, pointer, source);
    for (int axis = 0; axis < 3; ++axis)
      if (object.placement.scale[axis] == 0)
        source.fail(pointer + "/scale/" + std::to_string(axis), "0 makes the object flat; give another value");
  }
}

void checkLights(const Scene& scene, const SceneSource& source) {
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const Light& light = scene.lights[i];
    const std::string pointer = "/lights/" + std::to_string(i);
    const bool area = light.type == LightType::Area;
    const bool aims = area || light.type == LightType::Directional || light.type == LightType::Spot;
    if (aims && dot(light.direction, light.direction) == 0)
      source.fail(pointer + "/direction", "has no length; say where the light goes, as [0, 0, -1]");
    const double along = dot(light.direction, light.across),
                 most = dot(light.direction, light.direction) * dot(light.across, light.across);
    if (area && along * along >= (1 - 1e-12) * most)
      source.fail(pointer + "/across", "is along direction, or has no length; say where the light's width goes");
    if (light.type == LightType::Spot && light.innerAngle > light.outerAngle)
      source.fail(pointer + "/innerAngle", "is above outerAngle; give an angle from 0 to that");
  }
  if (!scene.photons.separate) return;
  try {
    (void)lightLayers(scene.lights);
  } catch (const Error& e) {
    source.fail("/lights", e.what());
  }
}

void checkReceivers(const Scene& scene, const SceneSource& source) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.receivers.size(); ++i) {
    const SceneReceiver& r = scene.receivers[i];
    const std::string pointer = "/receivers/" + std::to_string(i);
    if (r.name.find_first_of("/\\:*?\"<>|") != std::string::npos || r.name.starts_with('.'))
      source.fail(pointer + "/name", excerpt(r.name) + " cannot be the name of a light map's file; give a plain word");
    if (!r.name.empty() && !names.insert(r.name).second)
      source.fail(pointer + "/name", excerpt(r.name) + " is another receiver's, too; give one of them another name");
    const bool square = r.meshFile.empty() && !r.mesh;
    for (int axis = 0; axis < (square ? 2 : 3); ++axis)
      if (r.placement.scale[axis] == 0)
        source.fail(pointer + "/scale/" + std::to_string(axis), "0 leaves no surface; give another value");
  }
}

void checkCamera(const Camera& camera, const SceneSource& source) {
  const Vec3d view = difference(camera.target, camera.position);
  const double viewLength = std::sqrt(dot(view, view)), upLength = std::sqrt(dot(camera.up, camera.up));
  if (viewLength == 0) source.fail("/camera/target", "is where the camera is; give a point in front of it");
  if (upLength == 0) source.fail("/camera/up", "has no length; give a direction, as [0, 0, 1]");
  // One ten-millionth of a radian from the line of sight leaves no digits to tell the sides of the picture apart.
  if (1 - std::abs(dot(view, camera.up)) / (viewLength * upLength) < 5e-15)
    source.fail("/camera/up", "points along the line of sight; give a direction across it");
}

} // namespace

void checkScene(const Scene& scene, const SceneSource& source) {
  checkVolume(scene, source);
  checkObjects(scene, source);
  checkLights(scene, source);
  checkReceivers(scene, source);
  if (scene.stepField.indexTolerance2 < scene.stepField.indexTolerance)
    source.fail("/stepField/indexTolerance2", "must not be below indexTolerance; raise it or lower the other");
  if (scene.photons.maxStep < scene.photons.minStep)
    source.fail("/photons/maxStep", "must not be below minStep; raise it or lower the other");
  checkCamera(scene.camera, source);
  if (scene.frames.last < scene.frames.first)
    source.fail("/frames/last", "is before the first; give at least " + std::to_string(scene.frames.first));
  if (dot(scene.background.up, scene.background.up) == 0)
    source.fail("/background/up", "has no length; give a direction, as [0, 0, 1]");
}

} // namespace volcaustic
