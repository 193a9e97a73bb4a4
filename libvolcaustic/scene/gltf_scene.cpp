#include "scene/gltf_scene.h"

#include "scene/gltf_lights.h"
#include "scene/gltf_materials.h"
#include "scene/gltf_mesh.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <map>

namespace volcaustic {

namespace {

/// Frames a second where nobody says another number: Blender's default.
constexpr double kFramesPerSecond = 24;
constexpr std::size_t kMostObjects = 1 << 16;
constexpr std::size_t kMostPrimitives = 1 << 12; ///< of a mesh and a material, all of which the object's name lists

/// Triangles of one mesh that are made of the same material.
struct Part {
  std::size_t material; ///< of gltfMaterials()
  std::vector<std::size_t> primitives;
  std::uint64_t bytes = 0; ///< of the triangles
};

class Importer {
public:
  Importer(GltfFile& file, const SceneReadOptions& options) : mFile(file), mOptions(options) {}

  Scene import() {
    checkUsedExtensions();
    mMaterials = gltfMaterials(mFile, mNotes);
    const double seconds = mOptions.frame / mOptions.framesPerSecond.value_or(kFramesPerSecond);
    const std::vector<GltfNode> nodes = gltfNodes(mFile, seconds, mNotes);
    Scene scene;
    for (const GltfNode& node : nodes) addObjects(node, scene);
    mFile.context().requireMemory(mTriangleBytes, mFile.name() + ": its " +
                                                      std::to_string(scene.objects.size() + scene.receivers.size()) +
                                                      " objects");
    scene.materials.clear();
    for (const GltfMaterial& m : mMaterials)
      if (m.transmits) scene.materials.push_back(m.material);
    scene.lights = gltfLights(mFile, nodes);
    if (scene.lights.empty()) scene.lights.push_back(defaultSun());
    const auto camera = gltfCamera(mFile, nodes, mOptions.camera, mNotes);
    scene.camera = camera ? *camera : defaultCamera();
    scene.background.up = {0, 1, 0};
    mNotes.report(mFile.name(), mFile.context());
    return scene;
  }

private:
  /// The extensions whose values are read, or noted where they occur.
  void checkUsedExtensions() {
    constexpr std::string_view kRead[] = {"KHR_lights_punctual",        "KHR_materials_ior",
                                          "KHR_materials_transmission", "KHR_materials_volume",
                                          "KHR_materials_dispersion",   "KHR_mesh_quantization"};
    const auto used = mFile.root().find("extensionsUsed");
    for (std::size_t i = 0; used && i < used->size(); ++i)
      if (const std::string& name = (*used)[i].text();
          std::find(std::begin(kRead), std::end(kRead), name) == std::end(kRead))
        mNotes.add((*used)[i], "the extension " + excerpt(name) + " is not read");
  }

  void addObjects(const GltfNode& node, Scene& scene) {
    const auto reference = node.place.find("mesh");
    if (!reference) return;
    const std::size_t mesh = mFile.indexOf(*reference, "meshes");
    if (node.place.find("skin")) mNotes.add(node.place, "skins are not read; the mesh stays as it was modelled");
    if (node.place.extension("EXT_mesh_gpu_instancing")) mNotes.add(node.place, "only one of its instances is read");
    const std::optional<Placement> placement = placementOf(node.world);
    for (const Part& part : partsOf(mesh)) {
      if (scene.objects.size() + scene.receivers.size() == kMostObjects)
        node.place.fail("more than " + std::to_string(kMostObjects) + " objects; join some");
      const std::string meshFile =
          mFile.fileName() + "#" + gltfFragment(mesh, part.primitives, mParts[mesh].size() == 1);
      const GltfMaterial& material = mMaterials[part.material];
      if (placement) mTriangleBytes += part.bytes;
      if (!material.transmits) {
        if (placement) addReceiver(nameOf(node.place, mesh), meshFile, *placement, material.albedo, scene);
        continue;
      }
      SceneObject object;
      object.name = nameOf(node.place, mesh);
      object.meshFile = meshFile;
      object.material = material.material.name;
      object.visible = placement.has_value();
      if (placement) object.placement = *placement;
      scene.objects.push_back(std::move(object));
    }
  }

  /// Under a name that is no other receiver's, and may be a file's.
  void addReceiver(std::string name, const std::string& meshFile, const Placement& placement, const Rgb& albedo,
                   Scene& scene) {
    const auto isPlain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_'; };
    std::replace_if(name.begin(), name.end(), std::not_fn(isPlain), '_');
    if (name.empty()) name = "receiver";
    if (const int before = mReceiverNames[name]++; before > 0) name += "." + std::to_string(before);
    SceneReceiver receiver;
    receiver.name = std::move(name);
    receiver.meshFile = meshFile;
    receiver.placement = placement;
    receiver.albedo = albedo;
    scene.receivers.push_back(std::move(receiver));
  }

  [[nodiscard]] std::string nameOf(const GltfValue& node, std::size_t mesh) const {
    for (const GltfValue& value : {node, mFile.item("meshes", mesh)})
      if (const auto name = value.find("name"); name && !name->text().empty()) return name->text();
    return "";
  }

  /// In the order in which the mesh names the materials.
  const std::vector<Part>& partsOf(std::size_t mesh) {
    const auto [found, isNew] = mParts.try_emplace(mesh);
    std::vector<Part>& parts = found->second;
    if (!isNew) return parts;
    const GltfValue primitives = mFile.item("meshes", mesh).at("primitives");
    std::map<std::size_t, std::size_t> partOf; // each material
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (!GltfPrimitive::hasTriangles(primitives[i])) {
        mNotes.add(primitives[i], "points and lines enclose nothing and are left out");
        continue;
      }
      if (primitives[i].find("targets"))
        mNotes.add(primitives[i], "morph targets are not read; the mesh keeps its first shape");
      const std::size_t material = materialOf(primitives[i]);
      const auto [place, isFirst] = partOf.try_emplace(material, parts.size());
      if (isFirst) parts.push_back({material, {}, 0});
      parts[place->second].primitives.push_back(i);
      if (parts[place->second].primitives.size() > kMostPrimitives)
        primitives.fail("more than " + std::to_string(kMostPrimitives) + " primitives of one material; join them");
    }
    for (Part& part : parts) part.bytes = checkGltfPrimitives(mFile, mesh, part.primitives);
    return parts;
  }

  std::size_t materialOf(const GltfValue& primitive) {
    const auto reference = primitive.find("material");
    return reference ? mFile.indexOf(*reference, "materials") : mMaterials.size() - 1;
  }

  Light defaultSun() {
    mNotes.add(mFile.root(),
               "holds no light; a sun of 1 W/m2 from above is taken. Export punctual lights with the scene");
    Light sun;
    sun.name = "sun";
    sun.direction = {0.3, -1, -0.4};
    return sun;
  }

  /// Around the objects at rest, so that it stands still while they move.
  Camera defaultCamera() {
    GltfNotes told;
    std::optional<Box> all;
    for (const GltfNode& node : gltfNodes(mFile, std::nullopt, told)) {
      const auto reference = node.place.find("mesh");
      if (!reference || !placementOf(node.world)) continue;
      const std::size_t mesh = mFile.indexOf(*reference, "meshes");
      for (const Part& part : partsOf(mesh))
        if (mMaterials[part.material].transmits) unite(all, boxOf(mesh, part), node.world);
    }
    return all ? cameraAround(*all) : Camera{};
  }

  Box boxOf(std::size_t mesh, const Part& part) {
    const auto [found, isNew] = mBoxes.try_emplace({mesh, part.material});
    if (isNew) found->second = bounds(readGltfPrimitives(mFile, mesh, part.primitives));
    return found->second;
  }

  /// Adds the corners of `box`, placed in the world.
  static void unite(std::optional<Box>& all, const Box& box, const Affine& world) {
    for (unsigned corner = 0; corner < 8; ++corner) {
      Vec3d p;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = world[i][3];
        for (unsigned j = 0; j < 3; ++j) p[i] += world[i][j] * ((corner >> j & 1 ? box.max : box.min)[j]);
      }
      if (!all) all = Box{p, p};
      for (std::size_t i = 0; i < 3; ++i) {
        all->min[i] = std::min(all->min[i], p[i]);
        all->max[i] = std::max(all->max[i], p[i]);
      }
    }
  }

  GltfFile& mFile;
  const SceneReadOptions& mOptions;
  GltfNotes mNotes;
  std::vector<GltfMaterial> mMaterials;
  std::map<std::size_t, std::vector<Part>> mParts;
  std::map<std::pair<std::size_t, std::size_t>, Box> mBoxes;
  std::uint64_t mTriangleBytes = 0; ///< of all visible objects and receivers, each placed in the world
  std::map<std::string, int> mReceiverNames;
};

} // namespace

Json gltfSceneDocument(const std::filesystem::path& path, const SceneReadOptions& options, const RunContext& ctx) {
  GltfFile file(path, ctx);
  return sceneDocument(Importer(file, options).import());
}

} // namespace volcaustic
