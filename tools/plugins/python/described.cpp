#include "described.h"

#include "arrays.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

/// Those of Python's keywords that could be the name of a field.
constexpr std::array<std::string_view, 16> kPythonWords{"as",     "assert", "class", "del",    "from",     "global",
                                                        "import", "in",     "is",    "lambda", "nonlocal", "not",
                                                        "pass",   "raise",  "with",  "yield"};

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

[[noreturn]] void outOfRange(const Slot& slot, py::handle given) {
  std::ostringstream text;
  text.precision(12);
  text << slot.label() << " is " << std::string(py::str(given)) << ", which is out of range; give a value ";
  if (!slot.doc.choices.empty()) {
    std::vector<std::string> words;
    for (const int choice : slot.doc.choices) words.push_back(std::to_string(choice));
    text << "of " << joined(words);
  } else if (std::isfinite(slot.doc.min)) {
    text << "from " << slot.doc.min << " to " << slot.doc.max;
    if (*slot.doc.unit && std::string_view(slot.doc.unit) != "1") text << " " << slot.doc.unit;
  } else {
    text << "that is finite";
  }
  throw Error(ErrorKind::Usage, text.str());
}

/// A whole number, of Python's or NumPy's; True and False are none.
py::int_ wholeNumber(py::handle given, const Slot& slot) {
  if (PyBool_Check(given.ptr()) || !PyIndex_Check(given.ptr())) wrongType(slot, "a whole number", given);
  return py::reinterpret_steal<py::int_>(PyNumber_Index(given.ptr()));
}

template <class T>
SceneObject withItems(SceneObject object, std::vector<T> SceneObject::*list, const py::list& items,
                      const std::string& place) {
  (object.*list).clear();
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!py::isinstance<T>(items[i]))
      throw py::type_error(place + "[" + std::to_string(i) + "] must be a " +
                           std::string(py::str(py::type::of<T>().attr("__name__"))) + ", not " + typeOf(items[i]));
    (object.*list).push_back(items[i].cast<const T&>());
  }
  return object;
}

template <class T>
py::list listOf(const std::vector<T>& items) {
  py::list list;
  for (const T& item : items) list.append(py::cast(item));
  return list;
}

} // namespace

std::string snakeCase(std::string_view name) {
  std::string snake;
  for (const char c : name)
    if (c >= 'A' && c <= 'Z')
      snake += {'_', static_cast<char>(c - 'A' + 'a')};
    else
      snake += c;
  const auto& words = kPythonWords;
  return std::find(words.begin(), words.end(), snake) == words.end() ? snake : snake + "_";
}

std::string nearestOf(const std::string& word, const std::vector<std::string>& candidates) {
  const py::list found = py::module_::import("difflib").attr("get_close_matches")(word, candidates, 1, 0.0);
  return found.empty() ? "" : std::string(py::str(found[0]));
}

std::string typeOf(py::handle object) { return py::str(py::type::of(object).attr("__name__")); }

void wrongType(const Slot& slot, const std::string& wanted, py::handle given) {
  std::string what = py::repr(given);
  if (what.size() > 60) what = "a " + typeOf(given);
  throw py::type_error(slot.label() + " must be " + wanted + ", not " + what);
}

py::tuple itemsOf(py::handle given, py::ssize_t count, const std::string& wanted, const Slot& slot) {
  const bool text = PyUnicode_Check(given.ptr()) || PyBytes_Check(given.ptr());
  if (text || !py::hasattr(given, "__iter__")) wrongType(slot, wanted, given);
  py::tuple items(py::reinterpret_borrow<py::object>(given));
  if (count >= 0 && static_cast<py::ssize_t>(items.size()) != count) wrongType(slot, wanted, given);
  return items;
}

SceneObject plainObject(const ObjectHandle& handle, const std::string& place) {
  SceneObject object = withItems(handle, &SceneObject::groups, handle.groupItems, place + ".groups");
  object = withItems(std::move(object), &SceneObject::grids, handle.gridItems, place + ".grids");
  return withItems(std::move(object), &SceneObject::deform, handle.deformItems, place + ".deform");
}

ObjectHandle objectHandle(const SceneObject& object) {
  return {object, listOf(object.groups), listOf(object.grids), listOf(object.deform)};
}

void setField(bool& value, py::handle given, const Slot& slot) {
  const bool numpy = py::isinstance(given, py::module_::import("numpy").attr("bool_"));
  if (!PyBool_Check(given.ptr()) && !numpy) wrongType(slot, "True or False", given);
  value = PyObject_IsTrue(given.ptr()) == 1;
}

void setField(int& value, py::handle given, const Slot& slot) {
  const py::int_ number = wholeNumber(given, slot);
  int overflow = 0;
  const long long whole = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  const auto& choices = slot.doc.choices;
  const bool chosen = choices.empty() || std::find(choices.begin(), choices.end(), whole) != choices.end();
  const double least = std::max(slot.doc.min, -2147483648.), most = std::min(slot.doc.max, 2147483647.);
  if (overflow || static_cast<double>(whole) < least || static_cast<double>(whole) > most || !chosen)
    outOfRange(slot, given);
  value = static_cast<int>(whole);
}

void setField(std::uint64_t& value, py::handle given, const Slot& slot) {
  const py::int_ number = wholeNumber(given, slot);
  const unsigned long long whole = PyLong_AsUnsignedLongLong(number.ptr());
  if (whole == static_cast<unsigned long long>(-1) && PyErr_Occurred()) {
    PyErr_Clear();
    throw Error(ErrorKind::Usage, slot.label() + " is " + std::string(py::str(given)) +
                                      ", which is out of range; give a value from 0 to 2^64 - 1");
  }
  value = whole;
}

void setField(double& value, py::handle given, const Slot& slot) {
  const bool number = PyFloat_Check(given.ptr()) || PyIndex_Check(given.ptr()) ||
                      (!PyUnicode_Check(given.ptr()) && py::hasattr(given, "__float__"));
  if (PyBool_Check(given.ptr()) || !number) wrongType(slot, "a number", given);
  const double real = PyFloat_AsDouble(given.ptr());
  if (PyErr_Occurred()) throw py::error_already_set();
  if (!std::isfinite(real) || real < slot.doc.min || real > slot.doc.max) outOfRange(slot, given);
  value = real;
}

void setField(std::string& value, py::handle given, const Slot& slot) {
  if (!PyUnicode_Check(given.ptr())) wrongType(slot, "a string", given);
  value = given.cast<std::string>();
}

void setField(std::filesystem::path& value, py::handle given, const Slot& slot) {
  if (given.is_none()) {
    value.clear();
    return;
  }
  if (!PyUnicode_Check(given.ptr()) && !py::hasattr(given, "__fspath__")) wrongType(slot, "a path", given);
  value = py::str(py::module_::import("os").attr("fspath")(given)).cast<std::string>();
}

void setField(AutomaticBox& value, py::handle given, const Slot& slot) {
  value.automatic = given.is_none() || (PyUnicode_Check(given.ptr()) && given.equal(py::str("auto")));
  if (value.automatic) return;
  if (PyUnicode_Check(given.ptr())) wrongType(slot, "\"auto\" or two corners", given);
  value.box = boxFrom(given, slot.label());
}

void setField(AutomaticNumber& value, py::handle given, const Slot& slot) {
  value.automatic = given.is_none();
  if (!value.automatic) setField(value.value, given, slot);
}

void setField(MeshSource& value, py::handle given, const Slot& slot) {
  if (py::isinstance<MeshHandle>(given)) {
    value.mesh = given.cast<const MeshHandle&>().mesh;
    value.file.clear();
    return;
  }
  std::filesystem::path file;
  if (!given.is_none() && !PyUnicode_Check(given.ptr()) && !py::hasattr(given, "__fspath__"))
    wrongType(slot, "a Mesh or a path", given);
  setField(file, given, slot);
  value.file = std::move(file);
  value.mesh = nullptr;
}

void setField(Shape& value, py::handle given, const Slot& slot) {
  if (!given.is_none() && !py::isinstance<Shape>(given)) wrongType(slot, "a Shape or None", given);
  value = given.is_none() ? Shape() : given.cast<Shape>();
}

void setField(Placement& value, py::handle given, const Slot& slot) {
  if (!py::isinstance<Placement>(given)) wrongType(slot, "a Placement", given);
  value = given.cast<const Placement&>();
}

void setField(std::shared_ptr<const Image>& value, py::handle given, const Slot& slot) {
  if (!given.is_none() && !py::isinstance<ImageHandle>(given)) wrongType(slot, "an Image or None", given);
  value = given.is_none() ? nullptr : given.cast<const ImageHandle&>().image;
}

void setField(std::map<std::string, std::string>& value, py::handle given, const Slot& slot) {
  if (!py::isinstance<py::dict>(given)) wrongType(slot, "a dict of strings", given);
  std::map<std::string, std::string> all;
  for (const auto& [key, text] : py::reinterpret_borrow<py::dict>(given)) {
    if (!PyUnicode_Check(key.ptr()) || !PyUnicode_Check(text.ptr())) wrongType(slot, "a dict of strings", given);
    all[key.cast<std::string>()] = text.cast<std::string>();
  }
  value = std::move(all);
}

std::size_t indexOfWord(py::handle given, const std::vector<std::string>& words, const Slot& slot) {
  if (!PyUnicode_Check(given.ptr())) wrongType(slot, "one of " + joined(words), given);
  const std::string word = given.cast<std::string>();
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end())
    throw Error(ErrorKind::Usage, slot.label() + " is '" + word + "', which is not known; the nearest known word is '" +
                                      nearestOf(word, words) + "' of " + joined(words));
  return static_cast<std::size_t>(found - words.begin());
}

void setItems(py::list& items, py::handle given, py::handle type, const Slot& slot) {
  const std::string name = py::str(type.attr("__name__"));
  const py::tuple all = itemsOf(given, -1, "a sequence of " + name + "s", slot);
  for (const py::handle item : all)
    if (!py::isinstance(item, type)) wrongType(slot, "a sequence of " + name + "s", given);
  items = py::list(all);
}

py::object getField(const AutomaticBox& value) {
  if (value.automatic) return py::str("auto");
  return toTuple(value.box);
}
py::object getField(const AutomaticNumber& value) {
  if (value.automatic) return py::none();
  return py::float_(value.value);
}
py::object getField(const MeshSource& value) {
  if (value.mesh) return py::cast(MeshHandle{value.mesh, false});
  if (value.file.empty()) return py::none();
  return py::str(value.file.string());
}
py::object getField(const Shape& value) {
  if (value.empty()) return py::none();
  return py::cast(value);
}
py::object getField(const Placement& value) { return py::cast(value); }
py::object getField(const std::shared_ptr<const Image>& value) {
  if (!value) return py::none();
  return py::cast(ImageHandle{value, false});
}
py::object getField(const std::map<std::string, std::string>& value) { return py::cast(value); }

} // namespace volcaustic::python
