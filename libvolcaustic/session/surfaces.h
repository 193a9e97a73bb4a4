// The triangles of a scene's objects: as files hold them, of shapes, deformed.
#pragma once

#include "session/scene_files.h"
#include "session/stage.h"
#include "volcaustic/deform.h"
#include "volcaustic/polygonise.h"
#include "volcaustic/scene.h"

#include <functional>
#include <map>
#include <memory>

namespace volcaustic {

/// Whether the medium is made of triangles that a stage has to make first.
bool hasSurfaceStage(const SceneObject& object);

/// What a stage makes of one object.
struct Surface {
  std::shared_ptr<const Mesh> mesh;
  bool placed = false; ///< in the world already, else in the object's own space
};

class Surfaces {
public:
  /// Of what surface() makes, for an object that is no volume.
  static StageKey key(const SceneObject& object, SceneFiles& files, SceneMeshReader& reader);
  /// The stage of object `i`, which keeps its results.
  Stage<Surface>& stage(std::size_t i) { return mObjects[i].stage; }
  /// Deforms or triangulates object `i`. What the call before has learnt of it makes the next one faster.
  Surface make(std::size_t i, const SceneObject& object, SceneFiles& files, SceneMeshReader& reader,
               const RunContext& ctx);
  /// Forgets objects from `count` on.
  void resize(std::size_t count) { mObjects.erase(mObjects.lower_bound(count), mObjects.end()); }

private:
  struct Object {
    Stage<Surface> stage;
    Polygoniser polygoniser;
    std::uint64_t restKey = 0; ///< of what `deformer` was made of
    std::unique_ptr<MeshDeformer> deformer;
  };
  std::shared_ptr<const Mesh> deformed(Object& object, const SceneObject& o, SceneFiles& files, SceneMeshReader& reader,
                                       const RunContext& ctx);

  std::map<std::size_t, Object> mObjects; // by their place in the scene
};

/// The surface in the world. \pre not a volume
std::shared_ptr<const Mesh> placedMesh(const Surface& surface, const SceneObject& object);

} // namespace volcaustic
