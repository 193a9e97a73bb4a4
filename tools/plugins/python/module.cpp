// The extension module volcaustic._core; the package in volcaustic/ is what people import.
#include "call.h"

PYBIND11_MODULE(_core, m) {
  using namespace volcaustic::python;
  m.doc() = "Bindings of the library volcaustic.";
  m.attr("__version__") = VOLCAUSTIC_VERSION;
  m.attr("_fields") = py::dict();
  m.attr("_knows_numpy_2") = PYBIND11_VERSION_HEX >= 0x020C0000;
  py::module_::import("atexit").attr("register")(py::cpp_function(&endCalls));
  addErrors(m);
  addShapes(m);
  addImages(m);
  addOptions(m);
  addShapeKinds(m);
  addMeshes(m);
  addScenes(m);
  addDeforming(m);
  addMedia(m);
  addMediumGrids(m);
  addPhotons(m);
  addViews(m);
  addVolumes(m);
  addDevices(m);
  addSessions(m);
}
