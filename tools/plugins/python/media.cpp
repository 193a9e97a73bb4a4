// Media: voxelised, read, imported.
#include "arrays.h"
#include "call.h"
#include "described_class.h"
#include "handles.h"
#include "keywords.h"
#include "medium_grids.h"
#include "scene_handle.h"

#include <volcaustic/error.h>
#include <volcaustic/medium_volume.h>
#include <volcaustic/vdb.h>

namespace volcaustic::python {

namespace {

void addDomain(py::module_& m) {
  const auto made = [](py::handle minCorner, double voxelSize, py::handle dims) {
    const VoxelRange all =
        voxelRange({{}, 1, {1 << 15, 1 << 15, 1 << 15}}, py::none(), py::reinterpret_borrow<py::object>(dims));
    if (!(voxelSize > 0 && voxelSize <= 1e12)) throw Error(ErrorKind::Usage, "Domain(): voxel_size must be above 0");
    if (all.stop[0] < 1 || all.stop[1] < 1 || all.stop[2] < 1)
      throw Error(ErrorKind::Usage, "Domain(): dims must be at least 1");
    return Domain{vectorFrom(minCorner, "min_corner"), voxelSize, all.stop};
  };
  const auto centers = [](const Domain& d) {
    py::tuple axes(3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      py::array_t<double> centres({static_cast<py::ssize_t>(d.dims[axis])});
      for (int i = 0; i < d.dims[axis]; ++i) centres.mutable_at(i) = d.minCorner[axis] + (i + .5) * d.voxelSize;
      axes[axis] = centres;
    }
    return axes;
  };
  py::class_<Domain>(m, "Domain", "A lattice of cubic voxels in world space.")
      .def(py::init(made), py::arg("min_corner"), py::arg("voxel_size"), py::arg("dims"))
      .def_property_readonly("min_corner", [](const Domain& d) { return py::tuple(py::cast(d.minCorner)); })
      .def_property_readonly("max_corner", [](const Domain& d) { return py::tuple(py::cast(d.maxCorner())); })
      .def_readonly("voxel_size", &Domain::voxelSize, "Edge of a voxel, world.")
      .def_property_readonly(
          "dims", [](const Domain& d) { return py::tuple(py::cast(d.dims)); }, "Voxels along x, y, z.")
      .def_property_readonly("voxel_count", &Domain::voxelCount)
      .def("centers", centers, "Three float64 arrays: x, y and z of the voxels' centres, world.")
      .def(
          "__eq__",
          [](const Domain& a, const Domain& b) {
            return a.minCorner == b.minCorner && a.voxelSize == b.voxelSize && a.dims == b.dims;
          },
          py::is_operator())
      .def("__repr__", [](const Domain& d) {
        return "Domain(min_corner=" + std::string(py::repr(py::tuple(py::cast(d.minCorner)))) +
               ", voxel_size=" + std::string(py::repr(py::float_(d.voxelSize))) +
               ", dims=" + std::string(py::repr(py::tuple(py::cast(d.dims)))) + ")";
      });
  m.def(
      "domain_around",
      [](py::handle box, int resolution, double voxelSize, int padding) {
        return domainAround(boxFrom(box, "box"), resolution, voxelSize, padding);
      },
      py::arg("box"), py::kw_only(), py::arg("resolution") = 128, py::arg("voxel_size") = 0., py::arg("padding") = 2,
      "Around two corners: `resolution` voxels along the longest side, or voxels of voxel_size, plus `padding` on "
      "every side. Raises UsageError.");
}

void addBodies(py::module_& m) {
  const auto body = [](const py::object& surface, const Material& material, int priority, std::string name) {
    Body made{nullptr, material, priority, std::move(name)};
    if (py::isinstance<Shape>(surface))
      made.shape = surface.cast<Shape>();
    else if (py::isinstance<MeshHandle>(surface))
      made.mesh = surface.cast<const MeshHandle&>().mesh;
    else
      throw py::type_error("Body(): surface must be a Mesh or a Shape, not " + typeOf(surface));
    return made;
  };
  py::class_<Body>(m, "Body", "A closed mesh or a shape in world space, and what it is made of.")
      .def(py::init(body), py::arg("surface"), py::arg("material") = Material{}, py::arg("priority") = 0,
           py::arg("name") = "", "Where bodies overlap the higher priority wins; of equal ones, the later.")
      .def_property_readonly("material", [](const Body& b) { return b.material; })
      .def_readonly("priority", &Body::priority)
      .def_readonly("name", &Body::name);
  const auto volume = [](const std::filesystem::path& path, py::handle grids, const py::object& placement,
                         const py::kwargs& given) {
    Keywords keywords("MediumVolume()", given);
    Call call(keywords);
    keywords.finish();
    MediumVolume made{nullptr, itemsAs<PropertyGrid>(grids, "grids"), kIdentity, path.filename().string()};
    if (!placement.is_none()) made.placement = affineFrom(placement);
    std::vector<std::string> names;
    for (const PropertyGrid& grid : made.properties) names.push_back(grid.mapping.grid);
    made.grids = call.run([&] { return readVolumeGrids(path, names, call.context()); });
    return made;
  };
  py::class_<MediumVolume>(m, "MediumVolume", "A volume made by others, as a part of the ambient medium.")
      .def(py::init(volume), py::arg("path"), py::arg("grids"), py::arg("placement") = py::none(),
           "Reads the named grids of a .vdb or .nvdb file. grids: PropertyGrids. Raises FileError, InputError.")
      .def_property_readonly(
          "bounds",
          [](const MediumVolume& v) -> py::object {
            const auto box = bounds(*v.grids, v.placement);
            if (!box) return py::none();
            return toTuple(*box);
          },
          "Two corners around the active voxels, world; None where there are none.");
}

Medium build(py::handle bodies, const Domain& domain, const py::kwargs& given) {
  Keywords keywords("build_medium()", given);
  const std::vector<Body> all = itemsAs<Body>(bodies, "bodies");
  for (const Body& body : all)
    if (body.mesh) MeshHandle{body.mesh}.check();
  const auto ambient = objectFrom<Ambient>(keywords, "ambient");
  std::vector<MediumVolume> volumes;
  if (const py::object some = keywords.take("volumes")) volumes = itemsAs<MediumVolume>(some, "volumes");
  const auto options = optionsFrom<VoxeliseOptions>(keywords);
  Call call(keywords);
  keywords.finish();
  return call.run([&] { return buildMedium(all, volumes, ambient, domain, options, call.context()); });
}

Medium read(const std::filesystem::path& path, const py::kwargs& given) {
  Keywords keywords("read_medium()", given);
  Call call(keywords);
  keywords.finish();
  return call.run([&] { return readMedium(path, call.context()); });
}

std::optional<GridMapping> mappingFrom(Keywords& keywords, const char* name) {
  const py::object given = keywords.take(name);
  if (!given || given.is_none()) return std::nullopt;
  if (PyUnicode_Check(given.ptr())) return GridMapping{given.cast<std::string>()};
  if (py::isinstance<GridMapping>(given)) return given.cast<GridMapping>();
  throw py::type_error("import_medium(): " + std::string(name) + " must be a GridMapping or a grid's name, not " +
                       typeOf(given));
}

Medium import(const std::filesystem::path& path, const py::kwargs& given) {
  Keywords keywords("import_medium()", given);
  MediumImport options;
  options.index = mappingFrom(keywords, "index");
  options.attenuation = mappingFrom(keywords, "attenuation");
  options.scattering = mappingFrom(keywords, "scattering");
  options.asymmetry = mappingFrom(keywords, "asymmetry");
  options.coverage = mappingFrom(keywords, "coverage");
  std::string body;
  keywords("body", body, FieldDoc{"name of a level set or a solid fraction"});
  if (!body.empty()) options.body = std::move(body);
  options.material = objectFrom<Material>(keywords, "material");
  options.ambient = objectFrom<Ambient>(keywords, "ambient");
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  return call.run([&] { return importMedium(path, options, call.context()); });
}

MeshHandle surfaceOf(const Medium& medium, const py::kwargs& given) {
  Keywords keywords("surface_from_medium()", given);
  SurfaceOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  return MeshHandle::own(call.run([&] { return surfaceFromMedium(medium, options, call.context()); }));
}

MeshHandle surfaceOfFile(const std::filesystem::path& path, const py::kwargs& given) {
  Keywords keywords("surface_from_vdb()", given);
  SurfaceOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  return MeshHandle::own(call.run([&] { return surfaceFromVdb(path, options, call.context()); }));
}

void addMedium(py::module_& m) {
  py::class_<Medium> type(m, "Medium", "An immutable optical medium over a domain.");
  type.def_property_readonly("domain", &Medium::domain)
      .def_property_readonly(
          "ambient", [](const Medium& medium) { return medium.ambient(); }, "A copy.")
      .def("__repr__", [](const Medium& medium) {
        const Vec3i& dims = medium.domain().dims;
        return "<volcaustic.Medium: " + std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " +
               std::to_string(dims[2]) + " voxels>";
      });
  const auto reader = [&type](const char* name, MediumField field, const std::string& doc) {
    type.def(
        name,
        [field](const Medium& medium, const py::object& start, const py::object& stop, const py::object& out) {
          const VoxelRange range = voxelRange(medium.domain(), start, stop);
          auto numbers = resultArray<float>(out, range.shape(channelsOf(field)));
          float* into = numbers.mutable_data();
          {
            const WithoutLock release;
            readField(medium, field, range, into);
          }
          return numbers;
        },
        py::kw_only(), py::arg("start") = py::none(), py::arg("stop") = py::none(), py::arg("out") = py::none(),
        (doc + " Voxels from `start` up to `stop` (the whole domain), one fill of `out` or of a new array.").c_str());
  };
  reader("index", MediumField::Index, "(nx, ny, nz) float32: refractive index.");
  reader("attenuation", MediumField::Attenuation, "(nx, ny, nz, 3) float32: extinction coefficient, 1/world.");
  reader("scattering", MediumField::Scattering, "(nx, ny, nz, 3) float32: scattering coefficient, 1/world.");
  reader("coverage", MediumField::Coverage, "(nx, ny, nz) float32: solid fraction, 0 to 1.");
  reader("asymmetry", MediumField::Asymmetry, "(nx, ny, nz) float32: mean cosine g of scattering.");
}

} // namespace

void addMedia(py::module_& m) {
  addDomain(m);
  addBodies(m);
  addMedium(m);
  m.def("build_medium", &build, py::arg("bodies"), py::arg("domain"),
        "Voxelises Bodies onto a Domain. Keywords: ambient, volumes (MediumVolumes), options (VoxeliseOptions) or its "
        "fields supersample, blur, fill, and those of every long call. Raises UsageError, InputError.");
  m.def("read_medium", &read, py::arg("path"), "The medium that write_vdb wrote, or any .vdb with a grid `index`.");
  m.def("import_medium", &import, py::arg("path"),
        "A medium from grids of any .vdb or .nvdb. Keywords: index, attenuation, scattering, asymmetry, coverage "
        "(GridMappings or names of grids); body (a level set's name) and material; ambient; voxel_size, padding, blur; "
        "those of every long call. Raises UsageError, InputError naming the grids that the file holds.");
  m.def("surface_from_medium", &surfaceOf, py::arg("medium"),
        "Iso-surface of the coverage. Keywords: isovalue, adaptivity, sharpen, and those of every long call.");
  m.def(
      "surface_from_vdb", &surfaceOfFile, py::arg("path"),
      "Iso-surface of a grid of a file. Keywords: grid, isovalue, adaptivity, sharpen, and those of every long call.");
}

} // namespace volcaustic::python
