/// \file scene.h
/// Everything that a picture or a caustic volume depends on, as plain data; and the scene file that holds it.
#pragma once

#include "volcaustic/deform.h"
#include "volcaustic/export.h"
#include "volcaustic/medium.h"
#include "volcaustic/medium_volume.h"
#include "volcaustic/photons.h"
#include "volcaustic/placement.h"
#include "volcaustic/polygonise.h"
#include "volcaustic/run_context.h"
#include "volcaustic/shape.h"
#include "volcaustic/topology.h"
#include "volcaustic/types.h"
#include "volcaustic/view.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic {

/// The box that light is computed in, and what fills it where no body is.
struct SceneVolume {
  bool automatic = true; ///< box around the objects, enlarged by `margin`
  double margin = 0.5;   ///< of the longest side of the objects' box, added on every side; automatic boxes only
  Box bounds;            ///< world; used when not automatic
  int resolution = 128;  ///< voxels along the box's longest side
  double voxelSize = 0;  ///< world; above 0 it replaces `resolution`
  Ambient ambient;
  std::filesystem::path file; ///< a .vdb with an `index` grid that replaces objects and box
};

/// `content` enlarged on every side by `margin` of its longest side: what an automatic box is.
VOLCAUSTIC_API Box withMargin(Box content, double margin);

/// What the triangles of one group of an object's mesh enclose (bodiesByGroup).
struct SceneGroup {
  std::string name;               ///< one of Mesh::groupNames
  std::string material = "glass"; ///< a name in Scene::materials
  int priority = 0;               ///< added to the object's
};

/// A body, or a volume made by others in the ambient medium.
struct SceneObject {
  std::string name;
  std::filesystem::path meshFile;   ///< mesh to read, or one of a glTF file: "x.glb#/meshes/0"; or
  std::shared_ptr<const Mesh> mesh; ///< a mesh in memory, which wins over meshFile
  Placement placement;
  std::string material = "glass"; ///< a name in Scene::materials
  int priority = 0;
  bool visible = true;
  std::vector<SceneGroup> groups;   ///< `material` is for all groups that are not listed
  std::filesystem::path volumeFile; ///< .vdb or .nvdb in place of a mesh; material and priority have no meaning then
  std::vector<PropertyGrid> grids;  ///< what the volume's grids are
  Shape shape;                      ///< a functional object in place of a mesh, where it is not empty
  bool triangulate = false;         ///< voxelise triangles of the shape, not the shape itself
  PolygoniseOptions polygonise;     ///< what triangles
  std::vector<Deformer> deform;     ///< of the mesh or the shape's triangles, in their own space, before `placement`
  DeformOptions deformation;
  TopologyOptions topology; ///< after the deformation, in the same space
};

/// An opaque diffuse surface that light falls on: a floor, a wall, a statue (Receiver in receivers.h).
struct SceneReceiver {
  std::string name;
  std::filesystem::path meshFile; ///< as SceneObject::meshFile; empty: a square of edge 1 around the origin, facing +z
  std::shared_ptr<const Mesh> mesh; ///< a mesh in memory, which wins over meshFile
  Placement placement;
  Rgb albedo{0.8, 0.8, 0.8};
  int resolution = 512;
  bool visible = true; ///< to the camera
};

/// The frames of an animation.
struct SceneFrames {
  int first = 1, last = 1;
  double rate = 24; ///< frames per second
};

struct Scene {
  SceneVolume volume;
  std::vector<Material> materials{Material{}};
  std::vector<SceneObject> objects;
  std::vector<Light> lights;
  std::vector<SceneReceiver> receivers;
  VoxeliseOptions voxelise;
  StepFieldOptions stepField;
  PhotonOptions photons;
  Camera camera;
  Background background;
  ViewOptions view;
  SceneFrames frames;
};

struct SceneReadOptions {
  /// "photons.grid=[512,512]": a dotted path and a JSON value, applied in order before anything is checked.
  std::vector<std::string> sets;
  /// The frame at which the file's animation is evaluated.
  double frame = 1;
  /// glTF files only: which camera, by its name or its node's; empty takes the first.
  std::string camera{};
  /// glTF files only: their animations are in seconds, and a frame is at frame / framesPerSecond. 24 where not given.
  std::optional<double> framesPerSecond{};
};

/// Reads and checks a scene file: JSON with comments (docs/scene_file.md), or glTF 2.0 by the extension .gltf or .glb
/// (docs/formats.md). Relative paths are taken from the file's folder; a place for
/// the frame number in them, as in "smoke.####.vdb", takes the frame. What a glTF file holds and a scene cannot is
/// warned of. \throws Error(File), or Error(Input) "scene.json:/lights/0/irradiance: ..." with the nearest known key.
VOLCAUSTIC_API Scene readScene(const std::filesystem::path& path, const SceneReadOptions& options = {},
                               const RunContext& ctx = {});
/// The same from JSON text; `name` stands for the file in messages and its folder resolves relative paths.
VOLCAUSTIC_API Scene parseScene(const std::string& text, const std::filesystem::path& name,
                                const SceneReadOptions& options = {});
/// True for the names of glTF files, by extension.
VOLCAUSTIC_API bool isGltfName(const std::filesystem::path& path);
/// The file that SceneObject::meshFile names: "x.glb" of "x.glb#/meshes/0", else itself.
VOLCAUSTIC_API std::filesystem::path sceneMeshFile(const std::filesystem::path& reference);
/// Canonical JSON of a scene: every field, keys in documented order.
VOLCAUSTIC_API std::string sceneToJson(const Scene& scene);
/// JSON Schema (2020-12) of the scene file.
VOLCAUSTIC_API std::string sceneSchema();
/// A commented scene file to start from: a glass mesh in fog.
VOLCAUSTIC_API std::string sceneTemplate();
/// 64-bit hash of the canonical JSON, as 16 hexadecimal digits.
VOLCAUSTIC_API std::string sceneHash(const Scene& scene);

} // namespace volcaustic
