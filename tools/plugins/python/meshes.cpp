// Meshes: views of their numbers, files, checks.
#include "arrays.h"
#include "call.h"
#include "described.h"
#include "handles.h"
#include "keywords.h"

#include <algorithm>
#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

static_assert(sizeof(std::array<std::uint32_t, 3>) == 3 * sizeof(std::uint32_t));

py::ssize_t signedSize(std::size_t size) { return static_cast<py::ssize_t>(size); }

template <class T, class Element>
std::vector<Element> rowsOf(const py::array_t<T>& array) {
  const auto* rows = reinterpret_cast<const Element*>(array.data());
  return {rows, rows + array.shape(0)};
}

MeshHandle meshFrom(py::handle positions, py::handle triangles, const py::object& groups,
                    std::vector<std::string> groupNames) {
  Mesh mesh;
  mesh.positions = rowsOf<double, Vec3d>(numbersFrom<double>(positions, {-1, 3}, "positions"));
  mesh.triangles =
      rowsOf<std::uint32_t, std::array<std::uint32_t, 3>>(numbersFrom<std::uint32_t>(triangles, {-1, 3}, "triangles"));
  if (!groups.is_none())
    mesh.triangleGroup = rowsOf<std::uint32_t, std::uint32_t>(
        numbersFrom<std::uint32_t>(groups, {signedSize(mesh.triangles.size())}, "triangle_group"));
  mesh.groupNames = std::move(groupNames);
  MeshHandle made = MeshHandle::own(std::move(mesh));
  made.check();
  return made;
}

const Mesh& meshOf(py::handle self) { return *self.cast<const MeshHandle&>().mesh; }
bool writable(py::handle self) { return self.cast<const MeshHandle&>().writable; }

py::array positions(const py::object& self) {
  const Mesh& mesh = meshOf(self);
  return view(reinterpret_cast<const double*>(mesh.positions.data()), {signedSize(mesh.positions.size()), 3}, self,
              writable(self));
}
py::array triangles(const py::object& self) {
  const Mesh& mesh = meshOf(self);
  return view(reinterpret_cast<const std::uint32_t*>(mesh.triangles.data()), {signedSize(mesh.triangles.size()), 3},
              self, writable(self));
}
py::array triangleGroup(const py::object& self) {
  const Mesh& mesh = meshOf(self);
  return view(mesh.triangleGroup.data(), {signedSize(mesh.triangleGroup.size())}, self, writable(self));
}

/// In place, so that views stay good: also what `mesh.positions += 1` ends with.
template <auto View>
void assign(const py::object& self, const py::object& given) {
  const py::array into = View(self);
  if (!into.writeable())
    throw py::value_error("the mesh belongs to a result and is read-only; make a Mesh of its arrays");
  if (given.ptr() == into.ptr()) return;
  const std::vector<py::ssize_t> shape(into.shape(), into.shape() + into.ndim());
  const py::array from = into.dtype().kind() == 'f' ? py::array(numbersFrom<double>(given, shape, "positions"))
                                                    : py::array(numbersFrom<std::uint32_t>(given, shape, "indices"));
  into[py::ellipsis()] = from;
}

MeshHandle moved(const MeshHandle& handle, py::handle placement) {
  return MeshHandle::own(transformed(*handle.checked(), affineFrom(placement)));
}

std::vector<MeshHandle> split(const MeshHandle& handle, const py::kwargs& given) {
  Keywords keywords("Mesh.split_by_group()", given);
  Call call(keywords);
  keywords.finish();
  std::vector<MeshHandle> parts;
  for (Mesh& part : call.run([&, mesh = handle.checked()] { return splitByGroup(*mesh, call.context()); }))
    parts.push_back(MeshHandle::own(std::move(part)));
  return parts;
}

MeshHandle read(const std::filesystem::path& path, const py::kwargs& given) {
  Keywords keywords("read_mesh()", given);
  Call call(keywords);
  keywords.finish();
  return MeshHandle::own(call.run([&] { return readMesh(path, call.context()); }));
}

void write(const std::filesystem::path& path, const MeshHandle& handle, const py::kwargs& given) {
  Keywords keywords("write_mesh()", given);
  MeshWriteOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  call.run([&, mesh = handle.checked()] { writeMesh(path, *mesh, options, call.context()); });
}

MeshReport check(const MeshHandle& handle, const py::kwargs& given) {
  Keywords keywords("check_mesh()", given);
  Call call(keywords);
  keywords.finish();
  return call.run([&, mesh = handle.checked()] { return checkMesh(*mesh, call.context()); });
}

void addReport(py::module_& m) {
  constexpr const char* kRoles[] = {"open", "flat", "body", "cavity", "immersed"};
  py::class_<MeshShell>(m, "MeshShell", "Faces of a mesh that hang together over edges.")
      .def_readonly("triangles", &MeshShell::triangles)
      .def_readonly("open_edges", &MeshShell::openEdges)
      .def_readonly("inconsistent_edges", &MeshShell::inconsistentEdges)
      .def_readonly("signed_volume", &MeshShell::signedVolume, "World units cubed; negative when faces point inwards.")
      .def_readonly("area", &MeshShell::area, "World units squared.")
      .def_readonly("depth", &MeshShell::depth, "Number of closed shells around it.")
      .def_property_readonly("bounds", [](const MeshShell& s) { return toTuple(s.bounds); })
      .def_property_readonly("closed", &MeshShell::closed)
      .def_property_readonly(
          "role", [=](const MeshShell& s) { return kRoles[static_cast<int>(s.role)]; },
          "What it does to the space inside: open, flat, body, cavity or immersed.")
      .def_property_readonly(
          "enclosed_by",
          [](const MeshShell& s) -> std::optional<std::size_t> {
            if (s.enclosedBy == MeshShell::kNone) return std::nullopt;
            return s.enclosedBy;
          },
          "The innermost shell around it, as an index into MeshReport.shells, or None.");
  py::class_<MeshReport>(m, "MeshReport", "What a voxeliser and a person want to know of a mesh.")
      .def_readonly("vertices", &MeshReport::vertices)
      .def_readonly("triangles", &MeshReport::triangles)
      .def_readonly("open_edges", &MeshReport::openEdges, "With exactly one face.")
      .def_readonly("non_manifold_edges", &MeshReport::nonManifoldEdges, "With more than two faces.")
      .def_readonly("inconsistent_edges", &MeshReport::inconsistentEdges,
                    "Whose faces are not wound against each other.")
      .def_readonly("flipped_faces", &MeshReport::flippedFaces, "To reverse, at least, until all are consistent.")
      .def_readonly("unorientable_patches", &MeshReport::unorientablePatches)
      .def_readonly("duplicate_faces", &MeshReport::duplicateFaces)
      .def_readonly("degenerate_faces", &MeshReport::degenerateFaces)
      .def_readonly("components", &MeshReport::components)
      .def_readonly("signed_volume", &MeshReport::signedVolume, "World units cubed; negative when faces point inwards.")
      .def_readonly("area", &MeshReport::area, "World units squared.")
      .def_property_readonly("bounds", [](const MeshReport& r) { return toTuple(r.bounds); })
      .def_readonly("shells", &MeshReport::shells, "Those of most area, 64 at most.")
      .def_readonly("shell_count", &MeshReport::shellCount)
      .def_readonly("closed_shells", &MeshReport::closedShells)
      .def_property_readonly("closed_and_consistent", &MeshReport::closedAndConsistent)
      .def_property_readonly("defects", &describeDefects, "What is wrong, in words; empty for a flawless mesh.")
      .def_property_readonly("remarks", &shellRemarks, "Sentences about what may surprise, with what to try.")
      .def("__repr__", [](const MeshReport& r) {
        const std::string defects = describeDefects(r);
        return "<volcaustic.MeshReport: " + std::to_string(r.triangles) + " triangles, " +
               (defects.empty() ? "flawless" : defects) + ">";
      });
}

void addMembers(py::class_<MeshHandle>& type) {
  type.def(
          py::init(&meshFrom), py::arg("positions"), py::arg("triangles"), py::arg("triangle_group") = py::none(),
          py::arg("group_names") = std::vector<std::string>{},
          "positions: (N, 3) numbers, copied once as float64. triangles: (M, 3) whole numbers, copied once as uint32;\n"
          "counter-clockwise ones face outwards. triangle_group: (M,) indices into group_names.\n"
          "Raises TypeError, UsageError for arrays of another kind or shape, InputError for an index out of range.")
      .def_property("positions", &positions, &assign<&positions>,
                    "(N, 3) float64, a view. Assigning copies into it; the number of vertices never changes.")
      .def_property("triangles", &triangles, &assign<&triangles>, "(M, 3) uint32, a view: indices into positions.")
      .def_property("triangle_group", &triangleGroup, &assign<&triangleGroup>,
                    "(M,) uint32, a view: indices into group_names; (0,) without groups.")
      .def_property_readonly("group_names", [](const MeshHandle& h) { return py::tuple(py::cast(h.mesh->groupNames)); })
      .def_property_readonly(
          "writable", [](const MeshHandle& h) { return h.writable; },
          "False for meshes of results, whose arrays are read-only.")
      .def_property_readonly(
          "bounds", [](const MeshHandle& h) { return toTuple(bounds(*h.checked())); },
          "Two corners of the box around all triangles.")
      .def("transformed", &moved, py::arg("placement"),
           "Another mesh, moved by a Placement or a matrix of 3x4 or 4x4; mirroring keeps outwards outwards.")
      .def("split_by_group", &split, "A mesh for each of group_names, or the mesh itself where there are none.")
      .def("__repr__",
           [](const MeshHandle& h) {
             return "<volcaustic.Mesh: " + std::to_string(h.mesh->positions.size()) + " vertices, " +
                    std::to_string(h.mesh->triangles.size()) + " triangles>";
           })
      .def(
          "__eq__",
          [](const MeshHandle& a, const MeshHandle& b) {
            const Mesh &m = *a.mesh, &n = *b.mesh;
            return &m == &n || (m.positions == n.positions && m.triangles == n.triangles &&
                                m.triangleGroup == n.triangleGroup && m.groupNames == n.groupNames);
          },
          py::is_operator())
      .def("__copy__", [](const MeshHandle& h) { return MeshHandle::own(Mesh(*h.mesh)); })
      .def("__deepcopy__", [](const MeshHandle& h, const py::dict&) { return MeshHandle::own(Mesh(*h.mesh)); })
      .def(py::pickle(
          [](const py::object& self) {
            const auto array = py::module_::import("numpy").attr("array");
            const Mesh& mesh = meshOf(self);
            return py::make_tuple(array(positions(self)), array(triangles(self)),
                                  mesh.triangleGroup.empty() ? py::none() : array(triangleGroup(self)),
                                  mesh.groupNames);
          },
          [](const py::tuple& state) {
            return meshFrom(state[0], state[1], state[2], state[3].cast<std::vector<std::string>>());
          }));
}

} // namespace

void MeshHandle::check() const {
  const auto vertices = mesh->positions.size();
  for (std::size_t t = 0; t < mesh->triangles.size(); ++t)
    for (const std::uint32_t corner : mesh->triangles[t])
      if (corner >= vertices)
        throw Error(ErrorKind::Input, "triangles[" + std::to_string(t) + "]: names vertex " + std::to_string(corner) +
                                          " of " + std::to_string(vertices) + "; count vertices from 0");
  const std::size_t groups = mesh->groupNames.size();
  for (std::size_t t = 0; t < mesh->triangleGroup.size(); ++t)
    if (mesh->triangleGroup[t] >= groups)
      throw Error(ErrorKind::Input, "triangle_group[" + std::to_string(t) + "]: names group " +
                                        std::to_string(mesh->triangleGroup[t]) + " of " + std::to_string(groups) +
                                        "; give group_names");
}

Affine affineFrom(py::handle given) {
  if (py::isinstance<Placement>(given)) return affine(given.cast<const Placement&>());
  const auto matrix = numbersFrom<double>(given, {-1, 4}, "placement");
  const py::ssize_t rows = matrix.shape(0);
  const bool affineRow =
      rows == 4 && matrix.at(3, 0) == 0 && matrix.at(3, 1) == 0 && matrix.at(3, 2) == 0 && matrix.at(3, 3) == 1;
  if (rows != 3 && !affineRow)
    throw Error(ErrorKind::Usage, "placement: must be a Placement or a matrix of 3x4, or 4x4 that ends with 0 0 0 1");
  Affine result{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      result[row][column] = matrix.at(row, column);
      if (!std::isfinite(result[row][column]))
        throw Error(ErrorKind::Usage, "placement: holds a number that is not finite");
    }
  return result;
}

void addMeshes(py::module_& m) {
  auto type = py::reinterpret_borrow<py::class_<MeshHandle>>(m.attr("Mesh"));
  addMembers(type);
  addReport(m);
  m.def("read_mesh", &read, py::arg("path"),
        "An OBJ, PLY, STL or OFF file. Raises FileError, InputError with the line. Keywords of every long call.");
  m.def(
      "write_mesh", &write, py::arg("path"), py::arg("mesh"),
      "Writes OBJ, PLY, STL or OFF by extension: whole or not at all. Keyword: binary, and those of every long call.");
  m.def("check_mesh", &check, py::arg("mesh"),
        "Counts what is not as in a closed, consistently wound surface. Keywords of every long call.");
}

} // namespace volcaustic::python
