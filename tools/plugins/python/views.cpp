// The camera pass.
#include "view_result.h"

#include "light_handle.h"

namespace volcaustic::python {

namespace {

std::shared_ptr<ViewResult> render(const Medium& medium, py::handle light, const Camera& camera,
                                   const py::kwargs& given) {
  Keywords keywords("render_view()", given);
  const LightArgument from(light);
  requireSameDomain(from.radiance, medium);
  auto background = objectFrom<Background>(keywords, "background");
  const auto stepField = objectFrom<StepFieldOptions>(keywords, "step_field");
  const py::object onPass = keywords.take("on_pass");
  const auto options = optionsFrom<ViewOptions>(keywords);
  Call call(keywords);
  keywords.finish();
  const ViewObserver observer = observerOf(call, onPass);
  return call.run([&] {
    return std::make_shared<ViewResult>(renderView(medium, from.radiance, camera,
                                                   withMap(std::move(background), call.context()), stepField, options,
                                                   call.context(), observer, from.receivers));
  });
}

} // namespace

ViewObserver observerOf(Call& call, const py::object& onPass) {
  if (!onPass || onPass.is_none()) return {};
  if (!PyCallable_Check(onPass.ptr()))
    throw py::type_error("on_pass must be a callable or None, not " + typeOf(onPass));
  // By address: copies of the function are made and dropped without the interpreter's lock.
  return [&call, function = onPass.ptr()](const ViewResult& soFar) {
    auto copy = std::make_shared<ViewResult>(soFar);
    call.callback([&] {
      const py::handle callable(function);
      callable(std::move(copy));
    });
  };
}

void addViews(py::module_& m) {
  const auto image = [](const std::shared_ptr<ViewResult>& view) {
    return ImageHandle{std::shared_ptr<const Image>(view, &present(view)->image), false};
  };
  py::class_<ViewResult, std::shared_ptr<ViewResult>>(m, "ViewResult", "What the camera saw. Immutable.")
      .def_property_readonly("image", image,
                             "R G B A, caustic.*, direct.*, background.*, receiver.*, transmittance.*, depth.Z, "
                             "steps.Y; read-only.")
      .def_readonly("steps", &ViewResult::steps)
      .def_readonly("rays_not_finite", &ViewResult::raysNotFinite)
      .def_readonly("rays_at_step_limit", &ViewResult::raysAtStepLimit)
      .def_readonly("samples", &ViewResult::samples, "Rays from the camera.")
      .def_readonly("passes", &ViewResult::passes)
      .def("__repr__", [](const ViewResult& v) {
        return "<volcaustic.ViewResult: " + std::to_string(v.image.width) + " x " + std::to_string(v.image.height) +
               ", " + std::to_string(v.samples) + " rays>";
      });
  m.def("render_view", &render, py::arg("medium"), py::arg("light"), py::arg("camera"),
        "What a Camera sees of a Medium and light (a PhotonResult with its receivers, or a RadianceVolume). Keywords: "
        "background (Background), step_field (StepFieldOptions), on_pass (called with a copy of the ViewResult after "
        "each pass), options (ViewOptions) or its fields, and those of every long call. Raises UsageError.");
}

} // namespace volcaustic::python
