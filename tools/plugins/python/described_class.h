// A Python class for each described struct: keyword constructor, an attribute for each field, repr, equality, copies
// and pickling, all from the one description.
#pragma once

#include "keywords.h"

#include <memory>
#include <string>
#include <vector>

namespace volcaustic::python {

/// How a field is written in stubs.
std::string annotationOf(const bool&);
std::string annotationOf(const int&);
std::string annotationOf(const std::uint64_t&);
std::string annotationOf(const double&);
std::string annotationOf(const std::string&);
std::string annotationOf(const std::filesystem::path&);
std::string annotationOf(const AutomaticBox&);
std::string annotationOf(const AutomaticNumber&);
std::string annotationOf(const MeshSource&);
std::string annotationOf(const Shape&);
std::string annotationOf(const Placement&);
std::string annotationOf(const std::shared_ptr<const Image>&);
std::string annotationOf(const std::map<std::string, std::string>&);
template <class T>
std::string annotationOf(const LiveList<T>&) {
  return "list[" + std::string(py::str(py::type::of<T>().attr("__name__"))) + "]";
}
template <class T>
requires std::is_enum_v<T> std::string annotationOf(const T&) {
  std::string words;
  for (const char* word : enumNames(T{})) words += (words.empty() ? "\"" : ", \"") + std::string(word) + "\"";
  return "Literal[" + words + "]";
}
template <class T, std::size_t N>
std::string annotationOf(const std::array<T, N>&) {
  std::string numbers = annotationOf(T{});
  for (std::size_t i = 1; i < N; ++i) numbers += ", " + annotationOf(T{});
  return "tuple[" + numbers + "]";
}
template <class T>
std::string annotationOf(const std::vector<T>&) {
  return "tuple[" + annotationOf(T{}) + ", ...]";
}

/// A field's meaning, unit and range, in a line.
std::string fieldText(const FieldDoc& doc, const std::string& annotation);

/// Notes the fields of a struct under `name` in `_core._fields`, which stubs and tests are made from.
template <class T>
void noteFields(py::module_& m, const char* name, T standard = {}) {
  py::list fields;
  describeAll(
      [&](const char* field, auto& value, const FieldDoc& doc) {
        const std::string annotation = annotationOf(value);
        fields.append(py::make_tuple(snakeCase(field), annotation, doc.required ? py::none() : getField(value),
                                     fieldText(doc, annotation), doc.required));
      },
      standard);
  m.attr("_fields")[name] = fields;
}

/// {name: value} of all fields.
template <class T>
py::dict fieldsOf(T& object) {
  py::dict fields;
  describeAll(
      [&](const char* name, auto& value, const FieldDoc&) { fields[py::str(snakeCase(name))] = getField(value); },
      object);
  return fields;
}

template <class T>
T madeOf(const std::string& name, const py::kwargs& fields, bool requiring = true) {
  Keywords keywords(name + "()", fields);
  T object{};
  (requiring ? keywords.requiring() : keywords).into(object);
  keywords.finish();
  return object;
}

/// The fields that are not as T{} has them, as a call that makes the object again.
template <class T>
std::string reprOf(T& object, const std::string& name) {
  T standard{};
  const py::dict usual = fieldsOf(standard);
  std::string text;
  for (const auto& [field, value] : fieldsOf(object))
    if (!value.equal(usual[field]))
      text += (text.empty() ? "" : ", ") + std::string(py::str(field)) + "=" + std::string(py::repr(value));
  return name + "(" + text + ")";
}

template <class T>
void addAttributes(py::class_<T, std::shared_ptr<T>>& type, const std::string& name) {
  T standard{};
  int count = 0;
  describeAll(
      [&](const char* field, auto& usual, const FieldDoc& doc) {
        const int wanted = count++;
        const auto get = [wanted](T& object) {
          py::object found;
          int i = 0;
          describeAll(
              [&](const char*, auto& value, const FieldDoc&) {
                if (i++ == wanted) found = getField(value);
              },
              object);
          return found;
        };
        const auto set = [wanted, name](T& object, const py::object& given) {
          int i = 0;
          describeAll(
              [&](const char* key, auto& value, const FieldDoc& fieldDoc) {
                if (i++ == wanted) setField(value, given, {name, snakeCase(key), fieldDoc});
              },
              object);
        };
        type.def_property(snakeCase(field).c_str(), get, set, fieldText(doc, annotationOf(usual)).c_str());
      },
      standard);
}

template <class T>
py::class_<T, std::shared_ptr<T>> bindDescribed(py::module_& m, const std::string& name, const char* doc) {
  py::class_<T, std::shared_ptr<T>> type(m, name.c_str(), doc);
  noteFields<T>(m, name.c_str());
  addAttributes(type, name);
  const auto replaced = [name](T& object, const py::kwargs& changes) {
    T copy = madeOf<T>(name, fieldsOf(object), false);
    Keywords keywords(name + ".replace()", changes);
    keywords.into(copy);
    keywords.finish();
    return copy;
  };
  type.def(py::init([name](const py::kwargs& fields) { return madeOf<T>(name, fields); }), "Fields as keywords.")
      .def("replace", replaced, "A copy with other values of the fields that are given.")
      .def("to_dict", &fieldsOf<T>, "All fields by name.")
      .def("__repr__", [name](T& object) { return reprOf(object, name); })
      .def(
          "__eq__", [](T& a, T& b) { return fieldsOf(a).equal(fieldsOf(b)); }, py::is_operator())
      .def("__copy__", [name](T& object) { return madeOf<T>(name, fieldsOf(object), false); })
      .def("__deepcopy__",
           [name](T& object, const py::dict& memo) {
             const py::object copy = py::module_::import("copy").attr("deepcopy");
             return madeOf<T>(name, py::kwargs(copy(fieldsOf(object), memo)), false);
           })
      .def(py::pickle(&fieldsOf<T>,
                      [name](const py::dict& fields) { return madeOf<T>(name, py::kwargs(fields), false); }));
  return type;
}

} // namespace volcaustic::python
