// .vdb and .nvdb files.
#include "arrays.h"
#include "light_handle.h"

#include <map>
#include <variant>
#include <volcaustic/usd.h>
#include <volcaustic/vdb.h>

namespace volcaustic::python {

namespace {

/// A medium alone, or light and the medium that it is in.
void write(const std::filesystem::path& path, py::handle what, const std::optional<Medium>& medium,
           const py::kwargs& given) {
  Keywords keywords("write_vdb()", given);
  VdbWriteOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  if (py::isinstance<Medium>(what)) {
    if (medium) throw py::type_error("write_vdb(): two media; give light and its medium, or one medium");
    return call.run([&, m = what.cast<Medium>()] { writeVdb(path, m, options, call.context()); });
  }
  const LightArgument light(what);
  if (!medium) throw py::type_error("write_vdb(): light is written with its medium; give medium");
  call.run([&] {
    if (light.photons)
      writeVdb(path, *light.photons, *medium, options, call.context());
    else
      writeVdb(path, light.radiance, *medium, options, call.context());
  });
}

using Path = std::filesystem::path;

/// A stage of one .vdb file, or of many by frame.
void writeStage(const Path& path, const std::variant<Path, std::map<int, Path>>& files, const py::kwargs& given) {
  Keywords keywords("write_usd()", given);
  UsdWriteOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  std::vector<UsdFrame> frames;
  if (const Path* file = std::get_if<Path>(&files))
    frames.push_back({1, *file});
  else
    for (const auto& [frame, name] : std::get<1>(files)) frames.push_back({frame, name});
  call.run([&] { writeUsd(path, frames, options, call.context()); });
}

void addInfo(py::module_& m) {
  py::class_<GridInfo>(m, "GridInfo", "One grid of a volume file.")
      .def_readonly("name", &GridInfo::name)
      .def_readonly("type", &GridInfo::type)
      .def_readonly("grid_class", &GridInfo::gridClass)
      .def_readonly("vector_type", &GridInfo::vectorType)
      .def_readonly("active_voxels", &GridInfo::activeVoxels)
      .def_readonly("leaf_nodes", &GridInfo::leafNodes)
      .def_readonly("active_tiles", &GridInfo::activeTiles)
      .def_readonly("memory_bytes", &GridInfo::memoryBytes)
      .def_property_readonly("index_min", [](const GridInfo& g) { return py::tuple(py::cast(g.indexMin)); })
      .def_property_readonly("index_max", [](const GridInfo& g) { return py::tuple(py::cast(g.indexMax)); })
      .def_property_readonly(
          "world", [](const GridInfo& g) { return toTuple(g.world); },
          "Two corners of the box of the active voxels' faces.")
      .def_property_readonly("voxel_size", [](const GridInfo& g) { return py::tuple(py::cast(g.voxelSize)); })
      .def_readonly("minimum", &GridInfo::minimum, "Over active values; of the length for vectors.")
      .def_readonly("maximum", &GridInfo::maximum)
      .def_readonly("mean", &GridInfo::mean)
      .def_readonly("metadata", &GridInfo::metadata)
      .def_readonly("mirrored", &GridInfo::mirrored)
      .def("__repr__", [](const GridInfo& g) {
        return "<volcaustic.GridInfo: " + g.name + ", " + g.type + ", " + std::to_string(g.activeVoxels) +
               " active voxels>";
      });
  py::class_<VdbInfo>(m, "VdbInfo", "What is in a volume file.")
      .def_readonly("grids", &VdbInfo::grids)
      .def_readonly("metadata", &VdbInfo::metadata);
}

} // namespace

void addVolumes(py::module_& m) {
  addInfo(m);
  m.def("write_vdb", &write, py::arg("path"), py::arg("what"), py::arg("medium") = py::none(),
        "Writes a Medium, or light (PhotonResult, RadianceVolume) with its medium, as .vdb or .nvdb: whole or not at "
        "all. Keywords: preset, half, parts, exposure, metadata, and those of every long call. Raises FileError, "
        "UsageError.");
  m.def(
      "write_usd", &writeStage, py::arg("path"), py::arg("files"),
      "Writes an OpenUSD stage (.usda) of one Volume beside its .vdb files: a path, or a dict of paths by frame, which "
      "become time samples. Keywords: meters_per_unit, up_axis, rate, and those of every long call. Raises FileError, "
      "InputError, UsageError.");
  m.def(
      "read_radiance",
      [](const std::filesystem::path& path, const Domain& domain, const py::kwargs& given) {
        Keywords keywords("read_radiance()", given);
        Call call(keywords);
        keywords.finish();
        return call.run([&] { return readRadiance(path, domain, call.context()); });
      },
      py::arg("path"), py::arg("domain"), "The light that write_vdb wrote, on a Domain.");
  m.def(
      "inspect_vdb",
      [](const std::filesystem::path& path, const py::kwargs& given) {
        Keywords keywords("inspect_vdb()", given);
        Call call(keywords);
        keywords.finish();
        return call.run([&] { return inspectVdb(path, call.context()); });
      },
      py::arg("path"), "The grids of a .vdb or .nvdb file. Raises FileError, InputError for a damaged one.");
  m.def(
      "compare_vdb",
      [](const std::filesystem::path& a, const std::filesystem::path& b, const py::kwargs& given) {
        Keywords keywords("compare_vdb()", given);
        Call call(keywords);
        keywords.finish();
        return call.run([&] { return compareVdb(a, b, call.context()); });
      },
      py::arg("a"), py::arg("b"),
      "A Difference for each grid. Raises InputError where grids are missing or differ in type.");
  m.def(
      "convert_vdb",
      [](const std::filesystem::path& in, const std::filesystem::path& out, const py::kwargs& given) {
        Keywords keywords("convert_vdb()", given);
        VdbWriteOptions options;
        keywords.into(options);
        Call call(keywords);
        keywords.finish();
        call.run([&] { convertVdb(in, out, options, call.context()); });
      },
      py::arg("source"), py::arg("target"), ".vdb to .nvdb or back. Keywords as of write_vdb.");
}

} // namespace volcaustic::python
