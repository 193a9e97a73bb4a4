// The photon pass, rays, and the volume of light as arrays.
#include "arrays.h"
#include "described_class.h"
#include "light_handle.h"
#include "scene_handle.h"

#include <atomic>
#include <functional>
#include <thread>
#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

/// Slabs of voxels along x, on all threads where there are many voxels.
void fillSlabs(const VoxelRange& range, const RunContext& ctx, const std::function<void(int)>& fill) {
  constexpr double kFewVoxels = 1 << 15;
  std::atomic<int> next{range.start[0]};
  const auto work = [&] {
    for (int x = next++; x < range.stop[0] && !*ctx.cancel; x = next++) fill(x);
  };
  double voxels = 1;
  for (const py::ssize_t side : range.shape(1)) voxels *= static_cast<double>(side);
  std::vector<std::jthread> helpers;
  const unsigned threads = voxels > kFewVoxels ? std::thread::hardware_concurrency() : 1;
  for (unsigned i = 1; i < threads; ++i) helpers.emplace_back(work);
  work();
  helpers.clear(); // waits for them
  ctx.throwIfCancelled();
}

template <class Field>
void addField(py::class_<RadianceVolume>& type, const char* name, Field field, const char* doc) {
  const auto read = [field](const RadianceVolume& volume, const py::object& start, const py::object& stop,
                            const py::object& out) {
    const VoxelRange range = voxelRange(volume.domain(), start, stop);
    auto numbers = resultArray<float>(out, range.shape(3));
    auto* const into = reinterpret_cast<Vec3f*>(numbers.mutable_data());
    const auto rows = static_cast<std::size_t>(range.stop[1] - range.start[1]);
    const auto columns = static_cast<std::size_t>(range.stop[2] - range.start[2]);
    const auto fill = [&](int x) {
      Vec3f* voxel = into + static_cast<std::size_t>(x - range.start[0]) * rows * columns;
      for (int y = range.start[1]; y < range.stop[1]; ++y)
        for (int z = range.start[2]; z < range.stop[2]; ++z) *voxel++ = (volume.*field)({x, y, z});
    };
    Keywords none("", py::kwargs{});
    Call call(none);
    call.run([&] { fillSlabs(range, call.context(), fill); });
    return numbers;
  };
  type.def(name, read, py::kw_only(), py::arg("start") = py::none(), py::arg("stop") = py::none(),
           py::arg("out") = py::none(), doc);
}

void addRadiance(py::module_& m) {
  py::class_<RadianceVolume> type(m, "RadianceVolume",
                                  "Light in a domain. Immutable. Its numbers are read voxel by voxel into `out`, or a "
                                  "new array, from `start` up to `stop` (the whole domain).");
  type.def_property_readonly("domain", &RadianceVolume::domain).def("__repr__", [](const RadianceVolume& v) {
    return "<volcaustic.RadianceVolume of " + std::string(py::repr(py::cast(v.domain()))) + ">";
  });
  addField(type, "fluence", &RadianceVolume::fluence, "(nx, ny, nz, 3) float32: all light, W/m2.");
  addField(type, "caustic_fluence", &RadianceVolume::causticFluence,
           "(nx, ny, nz, 3) float32: light that was bent, W/m2.");
  addField(type, "direct_fluence", &RadianceVolume::directFluence,
           "(nx, ny, nz, 3) float32: light that was not bent, W/m2.");
  addField(type, "direction", &RadianceVolume::direction,
           "(nx, ny, nz, 3) float32: luminance-weighted mean direction of light, length at most 1.");
}

template <class T>
void addTuple(py::class_<EnergyBalance>& type, const char* name, T EnergyBalance::*member, const char* doc) {
  type.def_property_readonly(
      name, [member](const EnergyBalance& b) { return getField(b.*member); }, doc);
}

void addBalance(py::module_& m) {
  py::class_<EnergyBalance> type(m, "EnergyBalance", "Where the power went, W, RGB.");
  addTuple(type, "emitted", &EnergyBalance::emitted, "By all lights into the domain's box.");
  addTuple(type, "absorbed", &EnergyBalance::absorbed, "Turned to heat.");
  addTuple(type, "scattered", &EnergyBalance::scattered, "Out of the photons' paths, which is what the view shows.");
  addTuple(type, "escaped", &EnergyBalance::escaped, "Left the box.");
  addTuple(type, "received", &EnergyBalance::received, "Landed on receivers.");
  addTuple(type, "cut_off", &EnergyBalance::cutOff, "Dropped at the power threshold or the step limit.");
  addTuple(type, "traced_loss", &EnergyBalance::tracedLoss, "Absorbed and scattered by traced photons.");
  addTuple(type, "deposited_loss", &EnergyBalance::depositedLoss, "The same from the volume.");
  type.def_readonly("photons_emitted", &EnergyBalance::photonsEmitted)
      .def_readonly("photons_traced", &EnergyBalance::photonsTraced)
      .def_readonly("photons_at_step_limit", &EnergyBalance::photonsAtStepLimit)
      .def_readonly("photons_not_finite", &EnergyBalance::photonsNotFinite)
      .def_readonly("steps", &EnergyBalance::steps)
      .def_readonly("voxels_crossed", &EnergyBalance::voxelsCrossed)
      .def_property_readonly("relative_imbalance", &EnergyBalance::relativeImbalance,
                             "|emitted - all others| / emitted, the worst channel.")
      .def("__repr__", [](const EnergyBalance& b) {
        return "<volcaustic.EnergyBalance: " + std::string(py::repr(getField(b.emitted))) + " W emitted, imbalance " +
               std::string(py::repr(py::float_(b.relativeImbalance()))) + ">";
      });
}

void addReceiverMap(py::module_& m) {
  using Coordinates = std::array<std::array<float, 2>, 3>;
  const auto coordinates = [](const py::object& self) {
    const auto& map = self.cast<const ReceiverMap&>();
    const auto count = static_cast<py::ssize_t>(map.textureCoordinates.size());
    static_assert(sizeof(Coordinates) == 6 * sizeof(float));
    return view(reinterpret_cast<const float*>(map.textureCoordinates.data()), {count, 3, 2}, self, false);
  };
  const auto image = [](const std::shared_ptr<ReceiverMap>& map) {
    return ImageHandle{std::shared_ptr<const Image>(map, &present(map)->image), false};
  };
  const auto mesh = [](const std::shared_ptr<ReceiverMap>& map) {
    return MeshHandle{std::shared_ptr<const Mesh>(map, &present(map)->mesh), false};
  };
  py::class_<ReceiverMap, std::shared_ptr<ReceiverMap>>(m, "ReceiverMap", "What a receiver has collected.")
      .def_readonly("name", &ReceiverMap::name)
      .def_property_readonly("image", image, "Irradiance, W/m2: R, G, B, caustic.* and direct.*; read-only.")
      .def_property_readonly("mesh", mesh, "The surface, world space; read-only.")
      .def_readonly("is_mesh", &ReceiverMap::isMesh, "False for a rectangle, whose map lies on it edge to edge.")
      .def_property_readonly("texture_coordinates", coordinates,
                             "(M, 3, 2) float32, a view: u and v of the corners of each triangle.");
  m.def(
      "write_receiver_map",
      [](const std::filesystem::path& path, const std::shared_ptr<ReceiverMap>& map, const py::kwargs& given) {
        Keywords keywords("write_receiver_map()", given);
        ImageWriteOptions options;
        keywords.into(options);
        Call call(keywords);
        keywords.finish();
        call.run([&, surface = present(map)] { writeReceiverMap(path, *surface, options, call.context()); });
      },
      py::arg("path"), py::arg("map"),
      "The picture, and for a mesh an .obj with texture coordinates beside it. Keywords as of write_image.");
}

PhotonsHandle partOf(const PhotonsHandle& whole, const PhotonResult& part) { return {whole, &part}; }

void addResult(py::module_& m) {
  const auto maps = [](const PhotonsHandle& p) {
    py::list all;
    for (ReceiverMap& map : present(p)->receivers ? p->receivers.maps() : std::vector<ReceiverMap>{})
      all.append(py::cast(std::make_shared<ReceiverMap>(std::move(map))));
    return all;
  };
  const auto lights = [](const std::shared_ptr<PhotonResult>& p) {
    py::list all;
    for (const PhotonResult& light : present(p)->lights)
      all.append(py::cast(std::const_pointer_cast<PhotonResult>(partOf(p, light))));
    return all;
  };
  const auto parts = [](const PhotonResult& p) {
    py::list all;
    for (const PassPart& part : p.parts) all.append(py::make_tuple(part.name, part.ms));
    return all;
  };
  py::class_<PhotonResult, std::shared_ptr<PhotonResult>>(m, "PhotonResult", "What a photon pass gave. Immutable.")
      .def_property_readonly(
          "radiance", [](const PhotonResult& p) { return p.radiance; }, "The RadianceVolume.")
      .def_property_readonly(
          "balance", [](const PhotonResult& p) { return p.balance; }, "The EnergyBalance.")
      .def(
          "receiver_maps", [maps](const std::shared_ptr<PhotonResult>& p) { return maps(p); },
          "A ReceiverMap for each receiver, in their order; made anew by each call.")
      .def_property_readonly("lights", lights, "With `separate`: a PhotonResult of each light by itself.")
      .def_readonly("light", &PhotonResult::light, "The name of the light, of one by itself.")
      .def_property_readonly("parts", parts, "[(name, milliseconds)] of the parts of the pass.")
      .def("__repr__", [](const PhotonResult& p) {
        return "<volcaustic.PhotonResult: " + std::string(py::repr(py::cast(p.balance))) + ">";
      });
}

std::shared_ptr<PhotonResult> trace(const Medium& medium, py::handle lights, const py::kwargs& given) {
  Keywords keywords("trace_photons()", given);
  std::vector<Light> all = itemsAs<Light>(lights, "lights");
  const auto stepField = objectFrom<StepFieldOptions>(keywords, "step_field");
  const auto background = objectFrom<Background>(keywords, "background");
  std::vector<SceneReceiver> surfaces;
  if (const py::object some = keywords.take("receivers")) surfaces = itemsAs<SceneReceiver>(some, "receivers");
  const auto options = optionsFrom<PhotonOptions>(keywords);
  Call call(keywords);
  keywords.finish();
  return call.run([&] {
    for (Light& light : all)
      if (light.type == LightType::Environment) light.environment = withMap(background, call.context());
    return std::make_shared<PhotonResult>(
        tracePhotons(medium, all, stepField, options, call.context(), receiversFrom(surfaces, call.context())));
  });
}

/// One column of results of rays.
template <class Get>
py::array columnOf(const std::vector<TracedRay>& rays, Get get) {
  using T = std::decay_t<decltype(get(rays.front()))>;
  py::array_t<T> column({static_cast<py::ssize_t>(rays.size())});
  for (std::size_t i = 0; i < rays.size(); ++i) column.mutable_at(static_cast<py::ssize_t>(i)) = get(rays[i]);
  return column;
}
py::array vectorsOf(const std::vector<TracedRay>& rays, Vec3d TracedRay::*member) {
  py::array_t<double> rows({static_cast<py::ssize_t>(rays.size()), py::ssize_t{3}});
  for (std::size_t i = 0; i < rays.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows.mutable_at(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(axis)) = (rays[i].*member)[axis];
  return rows;
}

std::vector<TracedRay> raysFrom(py::handle positions, py::handle directions, Keywords& keywords) {
  const auto starts = numbersFrom<double>(positions, {-1, 3}, "positions");
  const auto ways = numbersFrom<double>(directions, {starts.shape(0), 3}, "directions");
  const py::object given = keywords.take("length");
  const bool each = given && !given.is_none();
  py::array_t<double> lengths;
  if (each) {
    const py::object numpy = py::module_::import("numpy");
    lengths = numbersFrom<double>(numpy.attr("broadcast_to")(given, starts.shape(0)), {starts.shape(0)}, "length");
  }
  std::vector<TracedRay> rays(static_cast<std::size_t>(starts.shape(0)));
  for (py::ssize_t i = 0; i < starts.shape(0); ++i)
    rays[static_cast<std::size_t>(i)] = {{starts.at(i, 0), starts.at(i, 1), starts.at(i, 2)},
                                         {ways.at(i, 0), ways.at(i, 1), ways.at(i, 2)},
                                         0,
                                         each ? lengths.at(i) : 0};
  return rays;
}

py::dict carry(const Medium& medium, py::handle positions, py::handle directions, const py::kwargs& given) {
  Keywords keywords("trace_rays()", given);
  std::vector<TracedRay> rays = raysFrom(positions, directions, keywords);
  const auto stepField = objectFrom<StepFieldOptions>(keywords, "step_field");
  const auto options = optionsFrom<PhotonOptions>(keywords);
  Call call(keywords);
  keywords.finish();
  call.run([&] { traceRays(medium, rays, stepField, options, call.context()); });
  py::dict columns;
  columns["position"] = vectorsOf(rays, &TracedRay::position);
  columns["direction"] = vectorsOf(rays, &TracedRay::direction);
  columns["optical_momentum"] = columnOf(rays, [](const TracedRay& r) { return r.opticalMomentum; });
  columns["length"] = columnOf(rays, [](const TracedRay& r) { return r.length; });
  columns["steps"] = columnOf(rays, [](const TracedRay& r) { return r.steps; });
  columns["left"] = columnOf(rays, [](const TracedRay& r) { return r.left; });
  return columns;
}

} // namespace

LightArgument::LightArgument(py::handle given) {
  if (py::isinstance<PhotonResult>(given)) {
    photons = given.cast<std::shared_ptr<PhotonResult>>();
    radiance = photons->radiance;
    receivers = photons->receivers;
  } else if (py::isinstance<RadianceVolume>(given)) {
    radiance = given.cast<RadianceVolume>();
  } else {
    throw py::type_error("light must be a PhotonResult or a RadianceVolume, not " + typeOf(given));
  }
}

void requireSameDomain(const RadianceVolume& light, const Medium& medium) {
  const Domain &a = light.domain(), &b = medium.domain();
  if (a.minCorner != b.minCorner || a.voxelSize != b.voxelSize || a.dims != b.dims)
    throw Error(ErrorKind::Usage, "light: is of another domain than the medium; give the medium that it was traced in");
}

std::vector<Receiver> receiversFrom(const std::vector<SceneReceiver>& receivers, const RunContext& ctx) {
  std::vector<Receiver> all;
  for (const SceneReceiver& r : receivers) {
    std::shared_ptr<const Mesh> mesh = r.mesh;
    if (mesh) MeshHandle{mesh}.check();
    if (!mesh && !r.meshFile.empty()) mesh = std::make_shared<const Mesh>(readMesh(r.meshFile, ctx));
    const std::string name = !r.name.empty() ? r.name : "receiver" + std::to_string(all.size());
    all.push_back({name, std::move(mesh), affine(r.placement), r.albedo, r.resolution, r.visible});
  }
  return all;
}

Background withMap(Background background, const RunContext& ctx) {
  if (!background.image && !background.file.empty()) background.image = readEnvironment(background.file, ctx);
  return background;
}

void addPhotons(py::module_& m) {
  addRadiance(m);
  addBalance(m);
  addReceiverMap(m);
  addResult(m);
  m.def("trace_photons", &trace, py::arg("medium"), py::arg("lights"),
        "Sends photons from Lights through a Medium. Keywords: step_field (StepFieldOptions), receivers "
        "(SceneReceivers), background (what lights of the type environment shine with), options (PhotonOptions) or its "
        "fields, and those of every long call. Raises UsageError, DeviceError.");
  m.def("trace_rays", &carry, py::arg("medium"), py::arg("positions"), py::arg("directions"),
        "Carries rays that start inside the domain through the medium: positions and unit directions (N, 3), world. "
        "Returns arrays: position and direction (N, 3) at the end, optical_momentum, length, steps, left (N,). "
        "Keywords: length (after which a ray stops, a number or (N,); 0 is none), step_field, options (PhotonOptions) "
        "or its fields, and those of every long call.");
}

} // namespace volcaustic::python
