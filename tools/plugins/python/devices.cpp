// What can run here; names of sequences.
#include "call.h"

#include <volcaustic/device.h>
#include <volcaustic/frames.h>

namespace volcaustic::python {

void addDevices(py::module_& m) {
  py::class_<DeviceInfo>(m, "DeviceInfo", "What can run here, or why it cannot.")
      .def_readonly("id", &DeviceInfo::id, "What the keyword `device` takes.")
      .def_readonly("name", &DeviceInfo::name)
      .def_readonly("usable", &DeviceInfo::usable)
      .def_readonly("reason", &DeviceInfo::reason, "Why it is not usable.")
      .def_readonly("memory_bytes", &DeviceInfo::memoryBytes)
      .def_readonly("parallel_units", &DeviceInfo::parallelUnits)
      .def("__repr__", [](const DeviceInfo& d) {
        return "<volcaustic.DeviceInfo: " + d.id + ", " + (d.usable ? d.name : d.reason) + ">";
      });
  m.def("list_devices", &listDevices, py::call_guard<WithoutLock>(),
        "The CPU, then every CUDA device, or one unusable entry that says why there is none.");
  m.def(
      "selected_device",
      [](std::string device) {
        RunContext context;
        context.device = std::move(device);
        return selectedDevice(context);
      },
      py::arg("device") = "auto", py::call_guard<WithoutLock>(),
      "What a word selects on this machine. Raises UsageError for no device, DeviceError for one that cannot be used.");
  m.def("has_frame_place", &hasFramePlace, py::arg("path"), "Whether a name has a place for a frame: #### or %04d.");
  m.def("with_frame", &withFrame, py::arg("path"), py::arg("frame"), "\"a.####.vdb\", 12 -> \"a.0012.vdb\".");
}

} // namespace volcaustic::python
