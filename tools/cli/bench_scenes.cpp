#include "bench_scenes.h"

#include "bench_shapes.h"

#include <volcaustic/error.h>

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace volcaustic::cli {

namespace {

constexpr PaperFigures kFigure5{1, 53e3, 90, 2.7e6, 36e3, 2.65, 10.8, 3.79, 17.24, 58};
constexpr PaperFigures kFigure6{3, 55e3, 80, 2.0e6, 41e3, 3.38, 9.6, 6.25, 19.23, 52};
constexpr PaperFigures kFigure7{8, 100e3, 77, 1.7e6, 35e3, 5.9, 8.52, 9.38, 23.8, 42};
constexpr PaperFigures kFigure9{9, 118e3, 103, 3.81e6, 143e3, 6.45, 13.8, 9.75, 30, 33};

constexpr std::array<const char*, kPaperScenes + 1> kNames{"fig5", "fig6", "fig7", "fig9", "ball"};

/// Light of about 2 W/m2 at the middle of the box, from above, a little to the side. Its raster spans the box as seen
/// from there, so the nearer it is, the fewer of its photons meet a body near the ground.
Light lampAt(double height) {
  Light lamp;
  lamp.name = "lamp";
  lamp.type = LightType::Point;
  lamp.position = {.46, .42, height};
  const double intensity = 2 * (height - .5) * (height - .5);
  lamp.intensity = {intensity, intensity, intensity};
  return lamp;
}

Material material(const char* name, double index, const Rgb& attenuation, const Rgb& scattering) {
  return {name, index, attenuation, scattering, 0};
}
const Material kAmber = material("amber", 1.1, {.5, .9, 2.0}, {.4, .6, .8});
const Material kGlass = material("glass", 1.5, {.1, .1, .1}, {.1, .1, .1});
const Material kWater = material("water", 1.33, {.6, .3, .2}, {.3, .25, .2});
const Material kResin = material("resin", 1.2, {.4, .7, .8}, {.3, .5, .5});
const Material kShard = material("shard", 1.212, {.9, .5, .4}, {.6, .4, .3});

Body body(const Mesh& mesh, const Material& material, const Vec3d& at, double scale, const Vec3d& rotate = {0, 0, 0},
          int priority = 0) {
  const Affine placement = affine({at, rotate, {scale, scale, scale}});
  return {std::make_shared<const Mesh>(transformed(mesh, placement)), material, priority, material.name};
}

/// One tall body with three turning flutes.
std::vector<Body> figure5() {
  return {body(lobedBody({{.17, .17, .36}, 3, .22, 3}, 230, 116), kAmber, {.5, .5, .42}, .978)};
}

/// A fluted drop, a trefoil and a ring.
std::vector<Body> figure6() {
  return {body(lobedBody({{.12, .12, .20}, 5, .15, 1}, 136, 69), kGlass, {.28, .34, .26}, 1.025),
          body(torusKnot({2, 3, .115, .05, .037}, 306, 30), kWater, {.70, .36, .24}, 1.025, {65, 0, 20}),
          body(torusKnot({1, 0, .125, 0, .052}, 252, 36), kResin, {.52, .72, .22}, 1.025, {80, 0, 0})};
}

/// Eight small bodies, four of them above the others.
std::vector<Body> figure7() {
  std::vector<Body> bodies;
  for (int i = 0; i < 8; ++i) {
    const int column = i % 4;
    const Vec3d at{column % 2 ? .70 : .30, column / 2 ? .70 : .30, i < 4 ? .14 : .40};
    const Vec3d rotate{25.0 * i, 40.0 * i, 15.0 * i};
    if (i % 4 == 1)
      bodies.push_back(body(torusKnot({2, 3, .080, .032, .027}, 250, 25), kGlass, at, 1.02, {70, 0, 30.0 * i}));
    else if (i % 4 == 2)
      bodies.push_back(body(torusKnot({1, 0, .075, 0, .038}, 125, 50), kResin, at, 1.02, {80, 0, 30.0 * i}));
    else
      bodies.push_back(body(lobedBody({{.085, .085, .11}, 2 + i / 2, .12, .5 * i}, 125, 51), kWater, at, 1.02, rotate));
  }
  return bodies;
}

/// Eight fragments inside a body of nearly the same index: where they overlap it, they win.
std::vector<Body> figure9() {
  std::vector<Body> bodies{body(lobedBody({{.24, .24, .27}, 4, .06, .8}, 200, 96), kResin, {.5, .5, .36}, 1)};
  for (int i = 0; i < 8; ++i) {
    const Vec3d at{i & 1 ? .59 : .41, i & 2 ? .59 : .41, i & 4 ? .46 : .28};
    bodies.push_back(
        body(lobedBody({{.075, .05, .06}, 3, .10, 1}, 100, 51), kShard, at, 1, {20.0 * i, 35.0 * i, 50.0 * i}, 1));
  }
  return bodies;
}

BenchScene ball() {
  BenchScene scene{"ball", nullptr, {body(lobedBody({}, 230, 116), kGlass, {.5, .5, .6}, 45.0 / 256)}, {}};
  scene.light.name = "sun";
  return scene;
}

} // namespace

std::span<const char* const> benchSceneNames() { return kNames; }

BenchScene benchScene(const std::string& name) {
  // The heights make as many photons meet the bodies as in the paper.
  if (name == "fig5") return {name, &kFigure5, figure5(), lampAt(1.545)};
  if (name == "fig6") return {name, &kFigure6, figure6(), lampAt(1.46)};
  if (name == "fig7") return {name, &kFigure7, figure7(), lampAt(1.375)};
  if (name == "fig9") return {name, &kFigure9, figure9(), lampAt(2.935)};
  if (name == "ball") return ball();
  throw Error(ErrorKind::Usage,
              fmt::format("--scene {}: is not a scene; give {} or all", name, fmt::join(kNames, ", ")));
}

Scene sessionScene(const BenchScene& scene, const BenchSize& size) {
  Scene s;
  s.volume.automatic = false;
  s.volume.bounds = {{0, 0, 0}, {1, 1, 1}};
  s.volume.resolution = size.resolution;
  if (size.fog) s.volume.ambient.attenuation = s.volume.ambient.scattering = {.3, .3, .3};
  s.materials.clear();
  for (const Body& b : scene.bodies) {
    SceneObject object;
    object.name = object.material = b.name;
    object.mesh = b.mesh;
    object.priority = b.priority;
    s.objects.push_back(std::move(object));
    s.materials.push_back(b.material);
  }
  s.lights = {scene.light};
  s.photons.grid = {size.raster, size.raster};
  s.camera.position = {.5, -1.5, .7};
  s.camera.target = {.5, .5, .45};
  return s;
}

} // namespace volcaustic::cli
