#include "session/scene_medium.h"

#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"

#include <algorithm>

namespace volcaustic {

namespace {

Box boundsOf(const Body& body) {
  if (body.mesh) return bounds(*body.mesh);
  try {
    return ShapeField(body.shape).bounds();
  } catch (const Error& error) { // which knows no object
    throw Error(error.kind(), "objects (" + body.name + "): " + error.what());
  }
}

} // namespace

const Material& materialOf(const Scene& scene, const std::string& name, const SceneObject& object) {
  for (const Material& m : scene.materials)
    if (m.name == name) return m;
  throw Error(ErrorKind::Input, "objects (" + nameOf(object) + "): no material is called '" + name + "'");
}

std::vector<Body> meshBodies(const Scene& scene, const SceneObject& o, std::shared_ptr<const Mesh> placed,
                             const RunContext& ctx) {
  std::vector<GroupMaterial> groups;
  for (const SceneGroup& g : o.groups)
    groups.push_back({g.name, materialOf(scene, g.material, o), o.priority + g.priority});
  return bodiesByGroup(std::move(placed), materialOf(scene, o.material, o), o.priority, groups, nameOf(o), ctx);
}

Body shapeBody(const Scene& scene, const SceneObject& o) {
  Body body{nullptr, materialOf(scene, o.material, o), o.priority, nameOf(o)};
  try {
    body.shape = o.shape.placed(o.placement);
  } catch (const Error& error) { // which knows no object
    if (error.kind() != ErrorKind::Input) throw;
    throw Error(ErrorKind::Input, "objects (" + body.name + "): " + error.what());
  }
  return body;
}

std::optional<Box> boxAround(const std::vector<Body>& bodies, const std::vector<MediumVolume>& volumes) {
  std::vector<Box> boxes;
  for (const Body& b : bodies) {
    const Box around = boundsOf(b);
    if (around.min != around.max) boxes.push_back(around); // a shape may have no inside
  }
  for (const MediumVolume& v : volumes)
    if (const auto around = bounds(*v.grids, v.placement)) boxes.push_back(*around);
  if (boxes.empty()) return std::nullopt;
  Box box = boxes.front();
  for (const Box& other : boxes) {
    for (int a = 0; a < 3; ++a) {
      box.min[a] = std::min(box.min[a], other.min[a]);
      box.max[a] = std::max(box.max[a], other.max[a]);
    }
  }
  return box;
}

Box withMargin(Box box, double margin) {
  const double longest = std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
  for (int a = 0; a < 3; ++a) {
    box.min[a] -= margin * longest;
    box.max[a] += margin * longest;
  }
  return box;
}

Domain domainOf(const SceneVolume& volume, const std::vector<Body>& bodies, const std::vector<MediumVolume>& volumes) {
  Box box = volume.bounds;
  if (volume.automatic) {
    const std::optional<Box> content = boxAround(bodies, volumes);
    if (!content)
      throw Error(ErrorKind::Input,
                  "volume.bounds: \"auto\" needs a visible object that is not empty; give min and max");
    box = withMargin(*content, volume.margin);
  }
  return domainAround(box, volume.resolution, volume.voxelSize, 0);
}

} // namespace volcaustic
