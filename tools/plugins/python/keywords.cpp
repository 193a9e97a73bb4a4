#include "keywords.h"

namespace volcaustic::python {

py::object Keywords::take(const char* name) {
  mKnown.emplace_back(name);
  const py::str key(name);
  if (!mGiven.contains(key)) return {};
  py::object value = mGiven[key];
  PyDict_DelItem(mGiven.ptr(), key.ptr());
  return value;
}

void Keywords::takePositions(const py::args& values, const std::vector<std::string>& names) {
  if (values.size() > names.size())
    throw py::type_error(mPlace + " takes at most " + std::to_string(names.size()) + " positional arguments, not " +
                         std::to_string(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const py::str name(names[i]);
    if (mGiven.contains(name)) throw py::type_error(mPlace + " got two values for '" + names[i] + "'");
    mGiven[name] = values[i];
  }
}

void Keywords::finish() const {
  for (const auto& [key, value] : mGiven) {
    const std::string name = py::str(key);
    const std::string nearest = nearestOf(name, mKnown);
    throw py::type_error(mPlace + " got an unexpected keyword argument '" + name + "'" +
                         (nearest.empty() ? "" : "; the nearest known one is '" + nearest + "'"));
  }
}

} // namespace volcaustic::python
