// A scene as Python holds it: lists and objects that can be changed in place.
#pragma once

#include "described.h"

#include <memory>
#include <volcaustic/scene.h>

namespace volcaustic::python {

/// Plain lists of Python, and structs that are shared with whoever holds them: scene.lights[0].direction = (0, 0, -1)
/// does what it says, and nothing dangles.
struct SceneHandle {
  py::list materials, objects, lights, receivers;
  std::shared_ptr<SceneVolume> volume = std::make_shared<SceneVolume>();
  std::shared_ptr<VoxeliseOptions> voxelise = std::make_shared<VoxeliseOptions>();
  std::shared_ptr<StepFieldOptions> stepField = std::make_shared<StepFieldOptions>();
  std::shared_ptr<PhotonOptions> photons = std::make_shared<PhotonOptions>();
  std::shared_ptr<Camera> camera = std::make_shared<Camera>();
  std::shared_ptr<Background> background = std::make_shared<Background>();
  std::shared_ptr<ViewOptions> view = std::make_shared<ViewOptions>();
  std::shared_ptr<SceneFrames> frames = std::make_shared<SceneFrames>();
};

/// \throws TypeError for an item of the wrong type, Error(Input) for a mesh whose indices are out of range.
Scene plainScene(const SceneHandle& handle);
SceneHandle sceneHandle(const Scene& scene);

/// Items of T of a sequence. \throws TypeError "lights[1] must be a Light, not str".
template <class T>
std::vector<T> itemsAs(py::handle sequence, const std::string& name) {
  const FieldDoc doc{""};
  const std::string type = py::str(py::type::of<T>().attr("__name__"));
  std::vector<T> all;
  for (const py::handle item : itemsOf(sequence, -1, "a sequence of " + type + "s", {"volcaustic", name, doc})) {
    if (!py::isinstance<T>(item))
      throw py::type_error(name + "[" + std::to_string(all.size()) + "] must be a " + type + ", not " + typeOf(item));
    all.push_back(item.cast<const T&>());
  }
  return all;
}

/// "photons.grid=[64,64]" lines, or {"photons.grid": (64, 64)}.
std::vector<std::string> setsFrom(const py::object& given);

} // namespace volcaustic::python
