#include "bench_scenes.h"

#include "paper_scenes.h"

#include <volcaustic/error.h>
#include <volcaustic/polygonise.h>

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace volcaustic::cli {

namespace {

struct Paper {
  const char* name;
  const char* text; ///< of the scene file
  PaperFigures figures;
};
const std::array<Paper, kPaperScenes> kPaper{{
    {"fig5", kFigure5, {1, 53e3, 90, 2.7e6, 36e3, 2.65, 10.8, 3.79, 17.24, 58}},
    {"fig6", kFigure6, {3, 55e3, 80, 2.0e6, 41e3, 3.38, 9.6, 6.25, 19.23, 52}},
    {"fig7", kFigure7, {8, 100e3, 77, 1.7e6, 35e3, 5.9, 8.52, 9.38, 23.8, 42}},
    {"fig9", kFigure9, {9, 118e3, 103, 3.81e6, 143e3, 6.45, 13.8, 9.75, 30, 33}},
}};
constexpr const char* kBall = "ball";

/// A glass ball in the sun.
Scene ball() {
  Scene scene;
  scene.volume.automatic = false;
  scene.volume.bounds = {{0, 0, 0}, {1, 1, 1}};
  scene.materials = {{"glass", 1.5, {.1, .1, .1}, {.1, .1, .1}, 0}};
  SceneObject object;
  object.name = object.material = "glass";
  object.shape = Shape::sphere(45.0 / 256);
  object.polygonise.triangles = 53000;
  object.placement.translate = {.5, .5, .6};
  scene.objects = {object};
  Light sun;
  sun.name = "sun";
  scene.lights = {sun};
  scene.camera.position = {.5, -1.5, .7};
  scene.camera.target = {.5, .5, .45};
  return scene;
}

const Material& material(const Scene& scene, const std::string& name) {
  for (const Material& m : scene.materials)
    if (m.name == name) return m;
  throw Error(ErrorKind::Internal, "bench: no material is called " + name);
}

/// Puts meshes in the places of shapes.
BenchScene polygonised(const std::string& name, const PaperFigures* paper, Scene scene) {
  BenchScene result{name, paper, std::move(scene), {}};
  for (SceneObject& object : result.scene.objects) {
    Mesh mesh = polygonise(object.shape.placed(object.placement), object.polygonise);
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.shape = {};
    object.placement = {};
    result.bodies.push_back({object.mesh, material(result.scene, object.material), object.priority, object.name});
  }
  return result;
}

} // namespace

std::span<const char* const> benchSceneNames() {
  static const std::array<const char*, kPaperScenes + 1> names{kPaper[0].name, kPaper[1].name, kPaper[2].name,
                                                               kPaper[3].name, kBall};
  return names;
}

BenchScene benchScene(const std::string& name) {
  for (const Paper& paper : kPaper)
    if (name == paper.name) return polygonised(name, &paper.figures, parseScene(paper.text, name + ".json"));
  if (name == kBall) return polygonised(name, nullptr, ball());
  throw Error(ErrorKind::Usage,
              fmt::format("--scene {}: is not a scene; give {} or all", name, fmt::join(benchSceneNames(), ", ")));
}

Scene sessionScene(const BenchScene& scene, const BenchSize& size) {
  Scene s = scene.scene;
  s.volume.resolution = size.resolution;
  // What makes a picture of it, and is not in the paper's table.
  s.volume.ambient = {};
  s.receivers.clear();
  s.view = {};
  if (size.fog) s.volume.ambient.attenuation = s.volume.ambient.scattering = {.3, .3, .3};
  s.photons.grid = {size.raster, size.raster};
  return s;
}

} // namespace volcaustic::cli
