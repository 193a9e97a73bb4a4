#include "scene/scene_json.h"

namespace volcaustic {

namespace {

/// Glass in thin fog under a slanted beam: the smallest scene whose caustic is worth looking at.
Scene startingPoint() {
  Scene scene;
  scene.volume.margin = 0.75;
  scene.volume.ambient.attenuation = {0.05, 0.05, 0.05};
  scene.volume.ambient.scattering = {0.05, 0.05, 0.05};
  scene.volume.ambient.asymmetry = 0.3;
  scene.materials.front().attenuation = {0.02, 0.01, 0.02};

  SceneObject glass;
  glass.name = "glass";
  glass.meshFile = "mesh.obj";
  scene.objects.push_back(glass);

  Light sun;
  sun.name = "sun";
  sun.direction = {0.3, 0.2, -1};
  sun.irradiance = {10, 9.5, 9};
  scene.lights.push_back(sun);
  return scene;
}

} // namespace

std::string sceneTemplate() {
  Json document = sceneDocument(startingPoint());
  document["animation"] = Json::object();
  return prettyText(document, &sceneSchemaDocument());
}

} // namespace volcaustic
