// What every file of the Python module needs, and who registers what.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>

namespace volcaustic::python {

namespace py = pybind11;

/// Of an argument that a caller may have given as None. \throws TypeError
template <class T>
const std::shared_ptr<T>& present(const std::shared_ptr<T>& given) {
  if (!given) throw py::type_error("an argument is None that must not be");
  return given;
}

// In the order in which module.cpp calls them: a function's signature names only types that are there.
void addErrors(py::module_& m);
void addShapes(py::module_& m);
void addMeshes(py::module_& m);
void addImages(py::module_& m);
void addOptions(py::module_& m);
void addShapeKinds(py::module_& m);
void addScenes(py::module_& m);
void addDeforming(py::module_& m);
void addMedia(py::module_& m);
void addMediumGrids(py::module_& m);
void addPhotons(py::module_& m);
void addViews(py::module_& m);
void addVolumes(py::module_& m);
void addDevices(py::module_& m);
void addSessions(py::module_& m);

} // namespace volcaustic::python
