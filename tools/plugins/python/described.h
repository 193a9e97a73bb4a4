// The one description of options (volcaustic/options.h, shape_fields.h) read for Python: what a field takes, gives
// back, is called and means. Nothing here knows a field by its name but those that Python holds in another form than a
// scene file does.
#pragma once

#include "common.h"
#include "handles.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <volcaustic/options.h>
#include <volcaustic/scene.h>
#include <volcaustic/shape_fields.h>

namespace volcaustic::python {

/// "indexTolerance2" -> "index_tolerance2"; a word of Python itself gets an underscore: "from" -> "from_".
std::string snakeCase(std::string_view name);
/// The candidate that is most like `word`; empty where there is none.
std::string nearestOf(const std::string& word, const std::vector<std::string>& candidates);
/// Its type's name, for messages.
std::string typeOf(py::handle object);

// Fields in other forms than a scene file's.

/// A mesh in memory, or the file that holds one.
struct MeshSource {
  std::filesystem::path& file;
  std::shared_ptr<const Mesh>& mesh;
};
/// A number, or None where it is to be found.
struct AutomaticNumber {
  bool& automatic;
  double& value;
};
/// A list that Python holds itself, so that scene.objects[0].groups[1].priority = 2 does what it says.
template <class T>
struct LiveList {
  py::list& items;
};

/// A scene's object as Python holds it; plainObject() makes a SceneObject of it.
struct ObjectHandle : SceneObject {
  py::list groupItems = py::list(), gridItems = py::list(), deformItems = py::list();
};
/// \throws TypeError for an item of the wrong type, "objects[0].groups[1]".
SceneObject plainObject(const ObjectHandle& handle, const std::string& place);
ObjectHandle objectHandle(const SceneObject& object);

/// threads, seed, device and memory limit of a RunContext.
struct ContextFields {
  RunContext& context;
};

// What a struct has in Python: its described fields, and those that describe() leaves to others.

template <class Visitor, class T>
void describeAll(Visitor&& visit, T& object) {
  describe(visit, object);
}
template <class Visitor>
void describeAll(Visitor&& visit, ContextFields& c) {
  visit("threads", c.context.threads, FieldDoc{"CPU threads; 0 takes all. Results do not depend on it", "", 0, 4096});
  visit("seed", c.context.seed, FieldDoc{"selects the jitter of photons and of pixel samples"});
  visit("device", c.context.device,
        FieldDoc{"auto, cpu, cpu:avx2, cuda, cuda:1, hybrid, ... (list_devices() says what there is)"});
  visit("memoryLimit", c.context.memoryLimit,
        FieldDoc{"that one call may allocate; 0 is three quarters of the machine's memory", "bytes"});
}
template <class Visitor>
void describeAll(Visitor&& visit, Material& m) {
  visit("name", m.name, FieldDoc{"that objects refer to"});
  describe(visit, m);
}
template <class Visitor>
void describeAll(Visitor&& visit, Background& b) {
  describe(visit, b);
  visit("image", b.image, FieldDoc{"the map in memory, which wins over `file`"});
}
template <class Visitor>
void describeAll(Visitor&& visit, GridMapping& m) {
  visit("grid", m.grid, FieldDoc{.text = "name of the grid in the file", .required = true});
  describe(visit, m);
}
template <class Visitor>
void describeAll(Visitor&& visit, VdbWriteOptions& o) {
  describe(visit, o);
  visit("metadata", o.metadata, FieldDoc{"added to the file's"});
}
template <class Visitor>
void describeAll(Visitor&& visit, MeshWriteOptions& o) {
  visit("binary", o.binary, FieldDoc{"where the format has both forms (PLY, STL)"});
}
template <class Visitor>
void describeAll(Visitor&& visit, SurfaceOptions& o) {
  describe(
      [&](const char* name, auto& value, const FieldDoc& doc) {
        if (static_cast<const void*>(&value) == &o.isovalue) {
          AutomaticNumber number{o.automaticIsovalue, o.isovalue};
          visit(name, number, doc);
        } else {
          visit(name, value, doc);
        }
      },
      o);
}

/// `holder` is an object or a receiver, `mesh` its file or mesh.
template <class Visitor, class Holder, class T>
void visitMeshField(Visitor& visit, Holder& holder, const char* name, T& value, const FieldDoc& doc) {
  if constexpr (std::is_same_v<T, std::filesystem::path>) {
    if (&value == &holder.meshFile) {
      MeshSource source{holder.meshFile, holder.mesh};
      return visit(name, source, doc);
    }
  }
  visit(name, value, doc);
}
template <class Visitor>
void describeAll(Visitor&& visit, SceneReceiver& r) {
  describe([&](const char* name, auto& value, const FieldDoc& doc) { visitMeshField(visit, r, name, value, doc); }, r);
}
template <class Visitor>
void describeAll(Visitor&& visit, ObjectHandle& o) {
  describe(
      [&](const char* name, auto& value, const FieldDoc& doc) {
        using T = std::remove_reference_t<decltype(value)>;
        const auto list = [&]<class Item>(LiveList<Item> items) { visit(name, items, doc); };
        if constexpr (std::is_same_v<T, std::vector<SceneGroup>>)
          list(LiveList<SceneGroup>{o.groupItems});
        else if constexpr (std::is_same_v<T, std::vector<PropertyGrid>>)
          list(LiveList<PropertyGrid>{o.gridItems});
        else if constexpr (std::is_same_v<T, std::vector<Deformer>>)
          list(LiveList<Deformer>{o.deformItems});
        else
          visitMeshField(visit, o, name, value, doc);
      },
      static_cast<SceneObject&>(o));
}

/// Which field of what is set, for messages: "Camera(): up must be ...".
struct Slot {
  const std::string& place;
  const std::string& name;
  const FieldDoc& doc;
  [[nodiscard]] std::string label() const { return place + ": " + name; }
};
[[noreturn]] void wrongType(const Slot& slot, const std::string& wanted, py::handle given);
/// Whatever is iterable, of `count` items where that is not negative; text is not. \throws TypeError
py::tuple itemsOf(py::handle given, py::ssize_t count, const std::string& wanted, const Slot& slot);

// Python into fields. \throws TypeError for another type, Error(Usage) for what is out of range.

void setField(bool& value, py::handle given, const Slot& slot);
void setField(int& value, py::handle given, const Slot& slot);
void setField(std::uint64_t& value, py::handle given, const Slot& slot);
void setField(double& value, py::handle given, const Slot& slot);
void setField(std::string& value, py::handle given, const Slot& slot);
void setField(std::filesystem::path& value, py::handle given, const Slot& slot);
void setField(AutomaticBox& value, py::handle given, const Slot& slot);
void setField(AutomaticNumber& value, py::handle given, const Slot& slot);
void setField(MeshSource& value, py::handle given, const Slot& slot);
void setField(Shape& value, py::handle given, const Slot& slot);
void setField(Placement& value, py::handle given, const Slot& slot);
void setField(std::shared_ptr<const Image>& value, py::handle given, const Slot& slot);
void setField(std::map<std::string, std::string>& value, py::handle given, const Slot& slot);
std::size_t indexOfWord(py::handle given, const std::vector<std::string>& words, const Slot& slot);
/// The list's items become those of `given`, which are `type`s.
void setItems(py::list& items, py::handle given, py::handle type, const Slot& slot);

template <class T>
requires std::is_enum_v<T>
void setField(T& value, py::handle given, const Slot& slot) {
  const auto names = enumNames(T{});
  value = static_cast<T>(indexOfWord(given, {names.begin(), names.end()}, slot));
}
template <class T, std::size_t N>
void setField(std::array<T, N>& value, py::handle given, const Slot& slot) {
  const py::tuple items = itemsOf(given, N, std::to_string(N) + " numbers", slot);
  std::array<T, N> numbers{};
  for (std::size_t i = 0; i < N; ++i) setField(numbers[i], items[i], slot);
  value = numbers;
}
template <class T>
void setField(std::vector<T>& value, py::handle given, const Slot& slot) {
  const py::tuple items = itemsOf(given, -1, "a sequence", slot);
  std::vector<T> all(items.size());
  for (std::size_t i = 0; i < all.size(); ++i) setField(all[i], items[i], slot);
  value = std::move(all);
}
template <class T>
void setField(LiveList<T>& value, py::handle given, const Slot& slot) {
  setItems(value.items, given, py::type::of<T>(), slot);
}

// Fields into Python. What comes back is immutable, or the very object that the field is.

inline py::object getField(bool value) { return py::bool_(value); }
inline py::object getField(int value) { return py::int_(value); }
inline py::object getField(std::uint64_t value) { return py::int_(value); }
inline py::object getField(double value) { return py::float_(value); }
inline py::object getField(const std::string& value) { return py::str(value); }
inline py::object getField(const std::filesystem::path& value) { return py::str(value.string()); }
py::object getField(const AutomaticBox& value);
py::object getField(const AutomaticNumber& value);
py::object getField(const MeshSource& value);
py::object getField(const Shape& value);
py::object getField(const Placement& value);
py::object getField(const std::shared_ptr<const Image>& value);
py::object getField(const std::map<std::string, std::string>& value);
template <class T>
requires std::is_enum_v<T> py::object getField(const T& value) {
  return py::str(enumNames(T{})[static_cast<std::size_t>(value)]);
}
template <class T, std::size_t N>
py::object getField(const std::array<T, N>& value) {
  py::tuple all(N);
  for (std::size_t i = 0; i < N; ++i) all[i] = getField(value[i]);
  return all;
}
template <class T>
py::object getField(const std::vector<T>& value) {
  py::tuple all(value.size());
  for (std::size_t i = 0; i < value.size(); ++i) all[i] = getField(value[i]);
  return all;
}
template <class T>
py::object getField(const LiveList<T>& value) {
  return value.items;
}

} // namespace volcaustic::python
