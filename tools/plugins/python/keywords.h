// Keyword arguments as the fields of described structs (volcaustic/options.h), and their attributes in Python.
#pragma once

#include "described.h"

#include <string>
#include <vector>

namespace volcaustic::python {

/// The keyword arguments of one call. Each is taken by the struct that has a field of its name, in snake_case.
class Keywords {
public:
  /// \param place for messages: "trace_photons()", "Camera()"
  Keywords(std::string place, const py::kwargs& given) : mPlace(std::move(place)), mGiven(py::dict(given)) {}

  /// Positional arguments stand for the fields of `object` in described order. \throws TypeError for too many.
  template <class T>
  void position(const py::args& values, T& object) {
    std::vector<std::string> names;
    describeAll([&](const char* name, auto&, const FieldDoc&) { names.push_back(snakeCase(name)); }, object);
    takePositions(values, names);
  }

  /// Sets the fields that are given. \throws TypeError, Error(Usage) "trace_photons(): cutoff is 2, ...".
  template <class T>
  void into(T& object) {
    describeAll(*this, object);
  }
  /// Afterwards into() asks for the fields that have no sensible default. \throws TypeError
  Keywords& requiring() {
    mRequiring = true;
    return *this;
  }
  /// Another keyword; a null object where it is not given.
  py::object take(const char* name);
  /// \throws TypeError for what nobody took, with the nearest known keyword.
  void finish() const;

  /// A visitor of describe().
  template <class T>
  void operator()(const char* name, T& value, const FieldDoc& doc) {
    const std::string keyword = snakeCase(name);
    if (const py::object given = take(keyword.c_str()))
      setField(value, given, {mPlace, keyword, doc});
    else if (mRequiring && doc.required)
      throw py::type_error(mPlace + ": the keyword '" + keyword + "' is missing; give the " + doc.text);
  }

private:
  void takePositions(const py::args& values, const std::vector<std::string>& names);

  std::string mPlace;
  py::dict mGiven;
  std::vector<std::string> mKnown;
  bool mRequiring = false;
};

/// The object of a keyword, or T{} where it is not given or None.
template <class T>
T objectFrom(Keywords& keywords, const char* name) {
  const py::object given = keywords.take(name);
  if (!given || given.is_none()) return T{};
  if (!py::isinstance<T>(given))
    throw py::type_error(std::string(name) + " must be a " + std::string(py::str(py::type::of<T>().attr("__name__"))) +
                         ", not " + typeOf(given));
  return given.cast<const T&>();
}

/// One call: `options` (an object of T, or None) changed by the keywords.
template <class T>
T optionsFrom(Keywords& keywords) {
  T options = objectFrom<T>(keywords, "options");
  keywords.into(options);
  return options;
}

} // namespace volcaustic::python
