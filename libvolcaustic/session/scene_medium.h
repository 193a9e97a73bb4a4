// A scene's bodies and their medium.
#pragma once

#include "session/scene_files.h"
#include "volcaustic/medium.h"
#include "volcaustic/scene.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic {

/// The material of that name. \throws Error(Input) naming the object.
const Material& materialOf(const Scene& scene, const std::string& name, const SceneObject& object);

/// A body of a mesh in the world, or one for each of its groups' materials.
std::vector<Body> meshBodies(const Scene& scene, const SceneObject& object, std::shared_ptr<const Mesh> placed,
                             const RunContext& ctx);
/// A body that is the shape itself.
Body shapeBody(const Scene& scene, const SceneObject& object);

/// Around all bodies and volumes; nothing where there is nothing.
std::optional<Box> boxAround(const std::vector<Body>& bodies, const std::vector<MediumVolume>& volumes);
/// The scene's box, or that of bodies and volumes enlarged by the margin.
Domain domainOf(const SceneVolume& volume, const std::vector<Body>& bodies, const std::vector<MediumVolume>& volumes);

} // namespace volcaustic
