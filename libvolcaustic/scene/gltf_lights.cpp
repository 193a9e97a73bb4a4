#include "scene/gltf_lights.h"

#include "core/nearest_word.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

/// Lumens in a watt. Exporters state light in lumens and renderers compute in watts; this is what Blender's exporter
/// multiplies its watts by, and the luminous efficacy of light of 555 nm.
constexpr double kLumensPerWatt = 683;

Vec3d column(const Affine& world, std::size_t axis) { return {world[0][axis], world[1][axis], world[2][axis]}; }
Vec3d negative(const Vec3d& v) { return {-v[0], -v[1], -v[2]}; }

Vec3d unit(const Vec3d& v, const GltfValue& place) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(length > 0)) place.fail("its scale is 0, so it has no direction; give it another scale");
  return {v[0] / length, v[1] / length, v[2] / length};
}

std::string nameOf(const GltfValue& value) {
  const auto name = value.find("name");
  return name ? name->text() : "";
}

/// Makes a spot of a point light. The cone's defaults are those of KHR_lights_punctual.
void aim(Light& result, const GltfValue& light, const GltfNode& node) {
  constexpr double kDegrees = 180 / std::numbers::pi, kHalfSphere = 90;
  result.type = LightType::Spot;
  result.direction = unit(negative(column(node.world, 2)), node.place);
  const auto angle = [&](const char* key, double otherwise) {
    const auto spot = light.find("spot");
    const auto value = spot ? spot->find(key) : std::nullopt;
    return value ? std::min(value->number(0, std::numbers::pi / 2 + 1e-6) * kDegrees, kHalfSphere) : otherwise;
  };
  result.outerAngle = angle("outerConeAngle", 45);
  result.innerAngle = std::min(angle("innerConeAngle", 0), result.outerAngle);
}

Light lightOf(const GltfValue& light, const GltfNode& node) {
  Rgb watts{1, 1, 1};
  if (const auto colour = light.find("color")) watts = colour->numbers<3>();
  const auto intensity = light.find("intensity");
  const double scale = (intensity ? intensity->number(0) : 1) / kLumensPerWatt;
  for (double& w : watts) w = std::max(w, 0.0) * scale;
  Light result;
  result.name = nameOf(node.place).empty() ? nameOf(light) : nameOf(node.place);
  const GltfValue type = light.at("type");
  if (type.text() == "directional") {
    result.type = LightType::Directional;
    result.direction = unit(negative(column(node.world, 2)), node.place);
    result.irradiance = watts;
    return result;
  }
  if (type.text() != "point" && type.text() != "spot")
    type.fail(excerpt(type.text()) + " is not known; give directional, point or spot");
  result.type = LightType::Point;
  result.position = column(node.world, 3);
  result.intensity = watts;
  if (type.text() == "spot") aim(result, light, node);
  return result;
}

Camera cameraOf(const GltfValue& perspective, const GltfNode& node) {
  constexpr double kLongestSide = 1024;
  Camera camera;
  camera.position = column(node.world, 3);
  const Vec3d ahead = unit(negative(column(node.world, 2)), node.place),
              right = unit(column(node.world, 0), node.place);
  for (std::size_t i = 0; i < 3; ++i) camera.target[i] = camera.position[i] + ahead[i];
  // The background's gradient follows `up`, so a camera that only nods keeps the world's.
  const bool isLevel = std::abs(right[1]) < 1e-5 && std::abs(ahead[1]) < 0.999 && node.world[1][1] > 0;
  camera.up = isLevel ? Vec3d{0, 1, 0} : unit(column(node.world, 1), node.place);
  camera.fieldOfView = perspective.at("yfov").number(1e-3, 2.9) * 180 / std::numbers::pi;
  if (const auto ratio = perspective.find("aspectRatio")) {
    const double aspect = ratio->number(1e-3, 1e3);
    camera.resolution = {static_cast<int>(std::lround(kLongestSide * std::min(aspect, 1.0))),
                         static_cast<int>(std::lround(kLongestSide / std::max(aspect, 1.0)))};
  }
  return camera;
}

} // namespace

std::vector<Light> gltfLights(const GltfFile& file, const std::vector<GltfNode>& nodes) {
  std::vector<Light> lights;
  for (const GltfNode& node : nodes)
    if (const auto reference = node.place.extension("KHR_lights_punctual")) {
      const auto all = file.root().extension("KHR_lights_punctual");
      const GltfValue number = reference->at("light");
      if (!all || number.whole() >= all->at("lights").size()) number.fail("there is no such light; export it again");
      lights.push_back(lightOf(all->at("lights")[number.whole()], node));
    }
  return lights;
}

std::optional<Camera> gltfCamera(const GltfFile& file, const std::vector<GltfNode>& nodes, const std::string& name,
                                 GltfNotes& notes) {
  std::vector<std::string> names;
  std::optional<Camera> first;
  for (const GltfNode& node : nodes) {
    const auto reference = node.place.find("camera");
    if (!reference) continue;
    const GltfValue camera = file.resolve(*reference, "cameras");
    const auto perspective = camera.find("perspective");
    if (!perspective) {
      notes.add(camera, "orthographic cameras are left out");
      continue;
    }
    if (!name.empty() && (nameOf(node.place) == name || nameOf(camera) == name)) return cameraOf(*perspective, node);
    if (!first) first = cameraOf(*perspective, node);
    names.push_back(nameOf(node.place).empty() ? nameOf(camera) : nameOf(node.place));
  }
  if (name.empty()) return first;
  throw Error(ErrorKind::Usage,
              "camera " + excerpt(name) + ": " + file.name() + " holds " +
                  (names.empty() ? "no camera; leave the name out"
                                 : "no such camera; the nearest known one is " + excerpt(nearestWord(name, names))));
}

Camera cameraAround(const Box& box) {
  Camera camera;
  double radius = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    camera.target[i] = (box.min[i] + box.max[i]) / 2;
    radius = std::hypot(radius, (box.max[i] - box.min[i]) / 2);
  }
  if (!(radius > 0)) radius = 1; // a box of one point
  constexpr double kRoom = 1.15, kTilt = 15 * std::numbers::pi / 180;
  const double distance = kRoom * radius / std::sin(camera.fieldOfView * std::numbers::pi / 360);
  camera.up = {0, 1, 0};
  camera.position = {camera.target[0], camera.target[1] + distance * std::sin(kTilt),
                     camera.target[2] + distance * std::cos(kTilt)};
  return camera;
}

} // namespace volcaustic
