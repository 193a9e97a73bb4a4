// Meshes that change their form.
#include "arrays.h"
#include "call.h"
#include "handles.h"
#include "keywords.h"
#include "scene_handle.h"

#include <volcaustic/error.h>
#include <volcaustic/topology.h>

namespace volcaustic::python {

namespace {

/// Deforms one mesh again and again; one call at a time.
struct DeformerHandle {
  explicit DeformerHandle(const MeshHandle& rest)
      // A copy: what is written to the mesh later must not change what is factorised.
      : deformer(std::make_shared<const Mesh>(*rest.checked())) {}
  MeshDeformer deformer;
  std::mutex busy;
};

MeshHandle deformOnce(const MeshHandle& mesh, py::handle steps, const py::kwargs& given) {
  Keywords keywords("deform()", given);
  const std::vector<Deformer> all = itemsAs<Deformer>(steps, "steps");
  DeformOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  return MeshHandle::own(
      call.run([&, rest = mesh.checked()] { return deformed(*rest, all, options, call.context()); }));
}

MeshHandle deformAgain(DeformerHandle& handle, py::handle steps, const py::kwargs& given) {
  Keywords keywords("MeshDeformer.deform()", given);
  const std::vector<Deformer> all = itemsAs<Deformer>(steps, "steps");
  DeformOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  return MeshHandle::own(call.run([&] {
    const std::unique_lock only(handle.busy, std::try_to_lock);
    if (!only) throw Error(ErrorKind::Usage, "MeshDeformer: another call of it is running; make one for each thread");
    return handle.deformer.deform(all, options, call.context());
  }));
}

struct TopologyHandle {
  MeshHandle mesh;
  std::uint64_t keptTriangles, newTriangles, partsBefore, partsAfter;
};

TopologyHandle control(const MeshHandle& mesh, const py::kwargs& given) {
  Keywords keywords("control_topology()", given);
  TopologyOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  TopologyResult made =
      call.run([&, rest = mesh.checked()] { return controlTopology(*rest, options, call.context()); });
  return {MeshHandle::own(std::move(made.mesh)), made.keptTriangles, made.newTriangles, made.partsBefore,
          made.partsAfter};
}

struct IntersectionsHandle {
  std::uint64_t pairs;
  py::array examples;
  Box bounds;
};

IntersectionsHandle findIntersections(const MeshHandle& mesh, const py::kwargs& given) {
  Keywords keywords("find_self_intersections()", given);
  Call call(keywords);
  keywords.finish();
  SelfIntersections found =
      call.run([&, rest = mesh.checked()] { return findSelfIntersections(*rest, call.context()); });
  const auto listed = static_cast<py::ssize_t>(found.examples.size());
  return {found.pairs, adopt<std::uint32_t>(std::move(found.examples), {listed, 2}), found.bounds};
}

} // namespace

void addDeforming(py::module_& m) {
  py::class_<DeformerHandle>(m, "MeshDeformer",
                             "Deforms one mesh again and again: handles that stay where they are share their matrices.")
      .def(py::init<const MeshHandle&>(), py::arg("rest"), "A copy of the mesh at rest is kept.")
      .def("deform", &deformAgain, py::arg("steps"), "As the function deform().");
  py::class_<TopologyHandle>(m, "TopologyResult", "A mesh whose parts meet no more, or as one.")
      .def_readonly("mesh", &TopologyHandle::mesh)
      .def_readonly("kept_triangles", &TopologyHandle::keptTriangles)
      .def_readonly("new_triangles", &TopologyHandle::newTriangles)
      .def_readonly("parts_before", &TopologyHandle::partsBefore)
      .def_readonly("parts_after", &TopologyHandle::partsAfter);
  py::class_<IntersectionsHandle>(m, "SelfIntersections", "Where a surface runs through itself.")
      .def_readonly("pairs", &IntersectionsHandle::pairs, "Of triangles that share more than a vertex or an edge.")
      .def_readonly("examples", &IntersectionsHandle::examples, "(at most 64, 2) uint32: the first of them.")
      .def_property_readonly("bounds", [](const IntersectionsHandle& s) { return toTuple(s.bounds); });
  m.def("deform", &deformOnce, py::arg("mesh"), py::arg("steps"),
        "The mesh after Deformers, in their order. Keywords: deform_method, deform_iterations, and those of every long "
        "call. Raises UsageError \"deform[i]: ...\".");
  m.def("control_topology", &control, py::arg("mesh"),
        "What becomes of parts that meet. Keywords: topology (keep, merge, split), gap, blend, neck, remesh_voxel, and "
        "those of every long call. Raises InputError for a mesh that is not closed.");
  m.def("find_self_intersections", &findIntersections, py::arg("mesh"),
        "Exact in its decisions. Keywords of every long call.");
}

} // namespace volcaustic::python
