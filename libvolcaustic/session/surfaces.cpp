#include "session/surfaces.h"

#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"
#include "volcaustic/topology.h"

#include <utility>

namespace volcaustic {

namespace {

bool isDeformed(const SceneObject& o) { return !o.deform.empty() || o.topology.topology != Topology::Free; }

} // namespace

bool hasSurfaceStage(const SceneObject& o) {
  return o.volumeFile.empty() && (isDeformed(o) || (!o.shape.empty() && o.triangulate));
}

StageKey Surfaces::key(const SceneObject& o, SceneFiles& files, SceneMeshReader& reader) {
  StageKey key("surface 1");
  if (o.shape.empty()) {
    key.add("mesh", files.mesh(o, reader).key);
  } else {
    key.add("shape", shapeHash(o.shape));
    key.addFields("", o.polygonise);
    if (!isDeformed(o)) key.addFields("", o.placement); // the lattice of its cells stands in the world
  }
  for (std::size_t i = 0; i < o.deform.size(); ++i) key.addFields("deform/" + std::to_string(i), o.deform[i]);
  key.addFields("", o.deformation);
  key.addFields("", o.topology);
  return key;
}

Surface Surfaces::make(std::size_t i, const SceneObject& o, SceneFiles& files, SceneMeshReader& reader,
                       const RunContext& ctx) {
  Object& object = mObjects[i];
  try {
    if (o.shape.empty()) return {deform(object, o, files.mesh(o, reader).mesh, ctx), false};
    const Shape shape = isDeformed(o) ? o.shape : o.shape.placed(o.placement);
    auto triangles = std::make_shared<const Mesh>(object.polygoniser.polygonise(shape, o.polygonise, ctx));
    if (!isDeformed(o)) return {std::move(triangles), true};
    return {deform(object, o, std::move(triangles), ctx), false};
  } catch (const Error& error) { // which knows no object
    if (error.kind() != ErrorKind::Input && error.kind() != ErrorKind::Usage) throw;
    throw Error(ErrorKind::Input, "objects (" + nameOf(o) + "): " + error.what());
  }
}

std::shared_ptr<const Mesh> Surfaces::deform(Object& object, const SceneObject& o, std::shared_ptr<const Mesh> rest,
                                             const RunContext& ctx) {
  std::shared_ptr<const Mesh> mesh = rest;
  if (!o.deform.empty()) {
    if (!object.deformer || object.deformer->rest() != rest)
      object.deformer = std::make_unique<MeshDeformer>(std::move(rest));
    mesh = std::make_shared<const Mesh>(object.deformer->deform(o.deform, o.deformation, ctx));
  }
  if (o.topology.topology == Topology::Free) return mesh;
  return std::make_shared<const Mesh>(controlTopology(*mesh, o.topology, ctx).mesh);
}

std::shared_ptr<const Mesh> placedMesh(const Surface& surface, const SceneObject& object) {
  if (surface.placed) return surface.mesh;
  return std::make_shared<const Mesh>(transformed(*surface.mesh, affine(object.placement)));
}

} // namespace volcaustic
