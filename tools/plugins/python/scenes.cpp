// Scenes: their sections, files, JSON.
#include "scene_handle.h"

#include "call.h"
#include "keywords.h"

#include <volcaustic/error.h>
#include <volcaustic/shape_file.h>

namespace volcaustic::python {

namespace {

template <class T>
py::list listOf(const std::vector<T>& items) {
  py::list list;
  for (const T& item : items) list.append(py::cast(std::make_shared<T>(item)));
  return list;
}

/// Calls visit(name, member, doc) for each section of a scene file.
template <class Visitor>
void describeSections(const Visitor& visit) {
  visit("volume", &SceneHandle::volume, "SceneVolume: the box and what fills it.");
  visit("materials", &SceneHandle::materials, "list of Material; objects name them.");
  visit("objects", &SceneHandle::objects, "list of SceneObject.");
  visit("lights", &SceneHandle::lights, "list of Light.");
  visit("receivers", &SceneHandle::receivers, "list of SceneReceiver.");
  visit("voxelise", &SceneHandle::voxelise, "VoxeliseOptions.");
  visit("step_field", &SceneHandle::stepField, "StepFieldOptions.");
  visit("photons", &SceneHandle::photons, "PhotonOptions.");
  visit("camera", &SceneHandle::camera, "Camera.");
  visit("background", &SceneHandle::background, "Background.");
  visit("view", &SceneHandle::view, "ViewOptions.");
  visit("frames", &SceneHandle::frames, "SceneFrames.");
}

void setSection(py::list& section, py::handle given, const std::string& name) {
  if (PyUnicode_Check(given.ptr()) || !py::hasattr(given, "__iter__"))
    throw py::type_error("Scene: " + name + " must be a list, not " + typeOf(given));
  if (given.ptr() != section.ptr()) section = py::list(py::reinterpret_borrow<py::object>(given));
}
template <class T>
void setSection(std::shared_ptr<T>& section, py::handle given, const std::string& name) {
  if (!py::isinstance<T>(given))
    throw py::type_error("Scene: " + name + " must be a " + std::string(py::str(py::type::of<T>().attr("__name__"))) +
                         ", not " + typeOf(given));
  section = given.cast<std::shared_ptr<T>>();
}

py::object objectOf(const py::list& section) { return section; }
template <class T>
py::object objectOf(const std::shared_ptr<T>& section) {
  return py::cast(section);
}

SceneHandle newScene(const py::kwargs& given) {
  Keywords keywords("Scene()", given);
  SceneHandle scene = sceneHandle(Scene{});
  describeSections([&](const char* name, auto member, const char*) {
    if (const py::object section = keywords.take(name)) setSection(scene.*member, section, name);
  });
  keywords.finish();
  return scene;
}

SceneReadOptions readOptions(Keywords& keywords) {
  SceneReadOptions options;
  if (const py::object sets = keywords.take("sets")) options.sets = setsFrom(sets);
  keywords("frame", options.frame, FieldDoc{"of the animation"});
  keywords("camera", options.camera, FieldDoc{"of a glTF file"});
  double rate = 0;
  keywords("fps", rate, FieldDoc{"of a glTF file's animation", "1/s", 0.01, 1e4});
  if (rate > 0) options.framesPerSecond = rate;
  return options;
}

SceneHandle readSceneFile(const std::filesystem::path& path, const py::kwargs& given) {
  Keywords keywords("Scene.read()", given);
  const SceneReadOptions options = readOptions(keywords);
  Call call(keywords);
  keywords.finish();
  return sceneHandle(call.run([&] { return readScene(path, options, call.context()); }));
}

SceneHandle parseSceneText(const std::string& text, const std::filesystem::path& name, const py::kwargs& given) {
  Keywords keywords("Scene.parse()", given);
  const SceneReadOptions options = readOptions(keywords);
  keywords.finish();
  return sceneHandle(parseScene(text, name, options));
}

std::string sceneRepr(const SceneHandle& s) {
  const auto count = [](const py::list& list, const char* what) { return std::to_string(list.size()) + " " + what; };
  return "<volcaustic.Scene: " + count(s.objects, "objects, ") + count(s.lights, "lights, ") +
         count(s.receivers, "receivers") + ">";
}

SceneHandle deepCopy(const SceneHandle& scene, const py::dict& memo) {
  const py::object copy = py::module_::import("copy").attr("deepcopy");
  SceneHandle result;
  describeSections([&](const char* name, auto member, const char*) {
    setSection(result.*member, copy(objectOf(scene.*member), memo), name);
  });
  return result;
}

void addScene(py::module_& m) {
  py::class_<SceneHandle, std::shared_ptr<SceneHandle>> type(
      m, "Scene", "Everything that a picture or a caustic volume depends on. Sections are attributes and keywords.");
  type.def(py::init(&newScene), "Sections as keywords; those that are not given are as in an empty scene file.");
  describeSections([&](const char* name, auto member, const char* doc) {
    type.def_property(
        name, [member](const SceneHandle& s) { return s.*member; },
        [member, name](SceneHandle& s, const py::object& given) { setSection(s.*member, given, name); }, doc);
  });
  type.def_static(
          "read", &readSceneFile, py::arg("path"),
          "A scene file or a glTF file. Keywords: sets, {\"photons.grid\": (64, 64)}; frame of the animation; "
          "camera and fps of glTF files; those of every long call. Raises FileError, InputError with the place.")
      .def_static("parse", &parseSceneText, py::arg("text"), py::arg("name") = "scene.json",
                  "A scene file's text. `name` stands for the file in messages; its folder resolves relative paths.")
      .def_static("template", &sceneTemplate, "A commented scene file to start from.")
      .def_static("schema", &sceneSchema, "JSON Schema (2020-12) of the scene file.")
      .def(
          "to_json", [](const SceneHandle& s) { return sceneToJson(plainScene(s)); },
          "Canonical JSON of all fields. Meshes and maps in memory are not in it.")
      .def_property_readonly(
          "hash", [](const SceneHandle& s) { return sceneHash(plainScene(s)); },
          "Of the canonical JSON, 16 hexadecimal digits.")
      .def(
          "copy", [](const SceneHandle& s) { return deepCopy(s, {}); }, "Shares nothing that can be changed.")
      .def("__copy__", [](const SceneHandle& s) { return SceneHandle(s); })
      .def("__deepcopy__", &deepCopy)
      .def("__repr__", &sceneRepr);
}

} // namespace

Scene plainScene(const SceneHandle& handle) {
  Scene scene;
  scene.materials = itemsAs<Material>(handle.materials, "materials");
  scene.lights = itemsAs<Light>(handle.lights, "lights");
  scene.receivers = itemsAs<SceneReceiver>(handle.receivers, "receivers");
  for (const ObjectHandle& object : itemsAs<ObjectHandle>(handle.objects, "objects"))
    scene.objects.push_back(plainObject(object, "objects[" + std::to_string(scene.objects.size()) + "]"));
  for (const SceneObject& object : scene.objects)
    if (object.mesh) MeshHandle{object.mesh}.check();
  for (const SceneReceiver& receiver : scene.receivers)
    if (receiver.mesh) MeshHandle{receiver.mesh}.check();
  scene.volume = *handle.volume;
  scene.voxelise = *handle.voxelise;
  scene.stepField = *handle.stepField;
  scene.photons = *handle.photons;
  scene.camera = *handle.camera;
  scene.background = *handle.background;
  scene.view = *handle.view;
  scene.frames = *handle.frames;
  return scene;
}

SceneHandle sceneHandle(const Scene& scene) {
  SceneHandle handle;
  handle.materials = listOf(scene.materials);
  handle.lights = listOf(scene.lights);
  handle.receivers = listOf(scene.receivers);
  for (const SceneObject& object : scene.objects) handle.objects.append(py::cast(objectHandle(object)));
  *handle.volume = scene.volume;
  *handle.voxelise = scene.voxelise;
  *handle.stepField = scene.stepField;
  *handle.photons = scene.photons;
  *handle.camera = scene.camera;
  *handle.background = scene.background;
  *handle.view = scene.view;
  *handle.frames = scene.frames;
  return handle;
}

std::vector<std::string> setsFrom(const py::object& given) {
  if (given.is_none()) return {};
  if (!py::isinstance<py::dict>(given)) {
    const FieldDoc doc{""};
    const std::string place = "volcaustic", name = "sets";
    std::vector<std::string> lines;
    setField(lines, given, {place, name, doc});
    return lines;
  }
  const py::object dumps = py::module_::import("json").attr("dumps");
  std::vector<std::string> lines;
  for (const auto& [path, value] : py::reinterpret_borrow<py::dict>(given))
    lines.push_back(std::string(py::str(path)) + "=" + std::string(py::str(dumps(value))));
  return lines;
}

void addScenes(py::module_& m) {
  addScene(m);
  m.def(
      "read_shape",
      [](const std::filesystem::path& path, const py::object& sets, double frame) {
        return readShape(path, {setsFrom(sets), frame});
      },
      py::arg("path"), py::kw_only(), py::arg("sets") = py::none(), py::arg("frame") = 1.,
      "A shape file. Raises FileError, InputError with the place.");
  m.def(
      "parse_shape",
      [](const std::string& text, const std::filesystem::path& name, const py::object& sets, double frame) {
        return parseShape(text, name, {setsFrom(sets), frame});
      },
      py::arg("text"), py::arg("name") = "shape.json", py::kw_only(), py::arg("sets") = py::none(),
      py::arg("frame") = 1., "A shape file's text; `name` stands for the file in messages.");
  m.def("shape_schema", &shapeSchema, "JSON Schema (2020-12) of the shape file.");
}

} // namespace volcaustic::python
