#include "session/surfaces.h"

#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"
#include "volcaustic/topology.h"

#include <utility>

namespace volcaustic {

namespace {

bool isDeformed(const SceneObject& o) { return !o.deform.empty() || o.topology.topology != Topology::Free; }

/// What is deformed, in the object's own space.
void addRest(StageKey& key, const SceneObject& o, SceneFiles& files, SceneMeshReader& reader) {
  if (o.shape.empty()) {
    key.add("mesh", files.mesh(o, reader).key);
  } else {
    key.add("shape", shapeHash(o.shape));
    key.addFields("", o.polygonise);
  }
}

} // namespace

bool hasSurfaceStage(const SceneObject& o) {
  return o.volumeFile.empty() && (isDeformed(o) || (!o.shape.empty() && o.triangulate));
}

StageKey Surfaces::key(const SceneObject& o, SceneFiles& files, SceneMeshReader& reader) {
  StageKey key("surface 1");
  addRest(key, o, files, reader);
  if (!o.shape.empty() && !isDeformed(o))
    key.addFields("", o.placement); // the lattice of its cells stands in the world
  for (std::size_t i = 0; i < o.deform.size(); ++i) key.addFields("deform/" + std::to_string(i), o.deform[i]);
  key.addFields("", o.deformation);
  key.addFields("", o.topology);
  return key;
}

Surface Surfaces::make(std::size_t i, const SceneObject& o, SceneFiles& files, SceneMeshReader& reader,
                       const RunContext& ctx) {
  Object& object = mObjects[i];
  try {
    if (isDeformed(o)) return {deformed(object, o, files, reader, ctx), false};
    return {std::make_shared<const Mesh>(object.polygoniser.polygonise(o.shape.placed(o.placement), o.polygonise, ctx)),
            true};
  } catch (const Error& error) { // which knows no object
    if (error.kind() != ErrorKind::Input && error.kind() != ErrorKind::Usage) throw;
    throw Error(ErrorKind::Input, "objects (" + nameOf(o) + "): " + error.what());
  }
}

std::shared_ptr<const Mesh> Surfaces::deformed(Object& object, const SceneObject& o, SceneFiles& files,
                                               SceneMeshReader& reader, const RunContext& ctx) {
  StageKey rest("rest");
  addRest(rest, o, files, reader);
  if (!object.deformer || object.restKey != rest.digest()) {
    object.deformer.reset(); // before the next one takes memory
    object.deformer = std::make_unique<MeshDeformer>(
        o.shape.empty() ? files.mesh(o, reader).mesh
                        : std::make_shared<const Mesh>(object.polygoniser.polygonise(o.shape, o.polygonise, ctx)));
    object.restKey = rest.digest();
  }
  std::shared_ptr<const Mesh> mesh = object.deformer->rest();
  if (!o.deform.empty()) mesh = std::make_shared<const Mesh>(object.deformer->deform(o.deform, o.deformation, ctx));
  if (o.topology.topology == Topology::Free) return mesh;
  return std::make_shared<const Mesh>(controlTopology(*mesh, o.topology, ctx).mesh);
}

std::shared_ptr<const Mesh> placedMesh(const Surface& surface, const SceneObject& object) {
  if (surface.placed) return surface.mesh;
  return std::make_shared<const Mesh>(transformed(*surface.mesh, affine(object.placement)));
}

} // namespace volcaustic
