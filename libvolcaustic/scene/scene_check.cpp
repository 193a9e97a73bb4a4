#include "scene/scene_check.h"

#include "core/nearest_word.h"
#include "scene/json_document.h"

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

void checkObjects(const Scene& scene, const SceneSource& source) {
  std::vector<std::string> names;
  for (const Material& material : scene.materials) {
    checkOptics(material, "/materials/" + pointerToken(material.name), source);
    names.push_back(material.name);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const std::string pointer = "/objects/" + std::to_string(i);
    checkMaterialName(object.material, names, pointer, source);
    checkGroups(object, names, pointer, source);
    for (int axis = 0; axis < 3; ++axis)
      if (object.placement.scale[axis] == 0)
        source.fail(pointer + "/scale/" + std::to_string(axis), "0 makes the object flat; give another value");
  }
}

void checkLights(const Scene& scene, const SceneSource& source) {
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const Light& light = scene.lights[i];
    const std::string pointer = "/lights/" + std::to_string(i);
    if (light.type != LightType::Point && dot(light.direction, light.direction) == 0)
      source.fail(pointer + "/direction", "has no length; say where the light goes, as [0, 0, -1]");
    if (light.type == LightType::Spot && light.innerAngle > light.outerAngle)
      source.fail(pointer + "/innerAngle", "is above outerAngle; give an angle from 0 to that");
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
  if (scene.stepField.indexTolerance2 < scene.stepField.indexTolerance)
    source.fail("/stepField/indexTolerance2", "must not be below indexTolerance; raise it or lower the other");
  if (scene.photons.maxStep < scene.photons.minStep)
    source.fail("/photons/maxStep", "must not be below minStep; raise it or lower the other");
  checkCamera(scene.camera, source);
}

} // namespace volcaustic
