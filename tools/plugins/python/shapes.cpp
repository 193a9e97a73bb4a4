// Functional objects: a factory for each kind of node, made from its description.
#include "arrays.h"
#include "call.h"
#include "described_class.h"
#include "handles.h"

#include <utility>
#include <volcaustic/polygonise.h>
#include <volcaustic/shape_file.h>

namespace volcaustic::python {

// Three doubles without padding: an (N, 3) array is N of them.
static_assert(sizeof(Vec3d) == 3 * sizeof(double));

namespace {

template <class Array>
std::span<const Vec3d> pointsOf(const Array& array) {
  return {reinterpret_cast<const Vec3d*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

std::vector<Shape> partsFrom(const py::args& given, const std::string& place) {
  std::vector<Shape> parts;
  for (const py::handle part : given) {
    if (!py::isinstance<Shape>(part)) throw py::type_error(place + ": parts must be Shapes, not " + typeOf(part));
    parts.push_back(part.cast<Shape>());
  }
  return parts;
}

template <class Kind>
Shape nodeOf(const std::string& place, const py::args& values, const py::kwargs& fields, std::vector<Shape> parts) {
  Keywords keywords(place, fields);
  ShapeNode node;
  Kind kind;
  keywords.requiring().position(values, kind);
  keywords.into(kind);
  keywords.finish();
  node.kind = std::move(kind);
  node.parts = std::move(parts);
  return Shape(std::move(node));
}

/// Solids and set operations are static, operations on one shape its methods.
template <class Kind>
void addKind(py::module_& m, py::class_<Shape>& type, std::size_t index) {
  const std::string name = kShapeTypes[index], place = "Shape." + name + "()";
  const ShapeParts parts = partsOf(Kind{});
  std::string doc;
  Kind standard;
  describeAll(
      [&](const char* field, auto& value, const FieldDoc& fieldDoc) {
        doc += "\n    " + snakeCase(field) + ": " + fieldText(fieldDoc, annotationOf(value));
      },
      standard);
  noteFields<Kind>(m, ("Shape." + name).c_str());
  if (parts == ShapeParts::None)
    type.def_static(
        name.c_str(),
        [place](const py::args& values, const py::kwargs& fields) { return nodeOf<Kind>(place, values, fields, {}); },
        ("A " + name + "; fields in this order or by name:" + doc).c_str());
  else if (parts == ShapeParts::Many)
    type.def_static(
        name.c_str(),
        [place](const py::args& shapes, const py::kwargs& fields) {
          return nodeOf<Kind>(place, {}, fields, partsFrom(shapes, place));
        },
        ("The " + name + " of shapes:" + doc).c_str());
  else
    type.def(
        name.c_str(),
        [place](const Shape& shape, const py::args& values, const py::kwargs& fields) {
          return nodeOf<Kind>(place, values, fields, {shape});
        },
        ("Another shape made of this one, fields in this order or by name:" + doc).c_str());
}

template <std::size_t... I>
void addKinds(py::module_& m, py::class_<Shape>& type, std::index_sequence<I...>) {
  (addKind<std::variant_alternative_t<I, shapes::Kind>>(m, type, I), ...);
}

/// The value (or gradient) of a shape at each point, straight from and into NumPy's memory.
template <class Result, class Evaluate>
py::array_t<double> evaluated(const Shape& shape, py::handle points, const py::object& out,
                              std::vector<py::ssize_t> resultShape, const Evaluate& evaluate) {
  const auto pWorld = numbersFrom<double>(points, {-1, 3}, "points");
  resultShape[0] = pWorld.shape(0);
  auto results = resultArray<double>(out, resultShape);
  const std::span<Result> into{reinterpret_cast<Result*>(results.mutable_data()),
                               static_cast<std::size_t>(pWorld.shape(0))};
  const std::span<const Vec3d> from = pointsOf(pWorld);
  const WithoutLock release;
  evaluate(ShapeField(shape), from, into);
  return results;
}

py::array_t<double> valuesAt(const Shape& shape, py::handle points, const py::object& out) {
  return evaluated<double>(shape, points, out, {0},
                           [](const ShapeField& f, auto from, auto into) { f.values(from, into); });
}

py::array_t<double> gradientsAt(const Shape& shape, py::handle points, const py::object& out) {
  return evaluated<Vec3d>(shape, points, out, {0, 3},
                          [](const ShapeField& f, auto from, auto into) { f.gradients(from, into); });
}

MeshHandle triangulated(const Shape& shape, const py::kwargs& given) {
  Keywords keywords("Shape.triangulate()", given);
  PolygoniseOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  return MeshHandle::own(call.run([&] { return polygonise(shape, options, call.context()); }));
}

Shape placedBy(const Shape& shape, const py::kwargs& given) {
  Keywords keywords("Shape.placed()", given);
  auto placement = objectFrom<Placement>(keywords, "placement");
  keywords.into(placement);
  keywords.finish();
  return shape.placed(placement);
}

/// What is applied to shapes that are there.
void addMethods(py::class_<Shape>& type) {
  type.def("bulge", &Shape::bulge, py::arg("region"), py::arg("weight") = 1.,
           "A quadric with weight * max(0, q)^3 added, q being the function of `region`, another quadric.")
      .def("placed", &placedBy, "Moved: a `placement`, or its fields translate, rotate, scale and shear as keywords.")
      .def("named", &Shape::named, py::arg("name"), "With a name, that of the group of its triangles.")
      .def(
          "__or__", [](const Shape& a, const Shape& b) { return a | b; }, py::is_operator())
      .def(
          "__and__", [](const Shape& a, const Shape& b) { return a & b; }, py::is_operator())
      .def(
          "__sub__", [](const Shape& a, const Shape& b) { return a - b; }, py::is_operator())
      .def(
          "__invert__", [](const Shape& a) { return ~a; }, py::is_operator());
}

} // namespace

void addShapes(py::module_& m) {
  py::class_<Shape> type(m, "Shape",
                         "A functional object: a function of space that is positive inside. Immutable. Made by the "
                         "static methods below, by `|`, `&`, `-`, `~`, and by read_shape().");
  py::class_<MeshHandle>(m, "Mesh", "Triangles with shared vertices.");
  addMethods(type);
  type.def("values", &valuesAt, py::arg("points"), py::kw_only(), py::arg("out") = py::none(),
           "The function at `points`, (N, 3) in world space: (N,) float64, positive inside, about a distance near the "
           "surface. Points that are float64 and contiguous are read where they are, results written to `out`.")
      .def("gradients", &gradientsAt, py::arg("points"), py::kw_only(), py::arg("out") = py::none(),
           "Gradients of the function at `points`, (N, 3), per world unit: (N, 3) float64.")
      .def_property_readonly(
          "bounds", [](const Shape& shape) { return toTuple(ShapeField(shape).bounds()); },
          "Two corners of a box that holds the shape, world. Raises InputError for one without end.")
      .def("triangulate", &triangulated,
           "A closed mesh with sharp edges kept. Keywords: resolution, cell_size, tolerance, triangles, and those of "
           "every long call. Raises InputError for a shape without end or inside.")
      .def_property_readonly("hash", &shapeHash, "Of everything that decides its values and names.")
      .def("to_json", &shapeToJson, "The text of a shape file.")
      .def(
          "__eq__", [](const Shape& a, const Shape& b) { return shapeHash(a) == shapeHash(b); }, py::is_operator())
      .def("__hash__", [](const Shape& shape) { return static_cast<py::ssize_t>(shapeHash(shape) >> 1); })
      .def("__repr__",
           [](const Shape& shape) {
             if (shape.empty()) return std::string("<volcaustic.Shape: nothing>");
             return "<volcaustic.Shape: " + std::string(kShapeTypes[shape.node().kind.index()]) + ">";
           })
      .def(py::pickle(&shapeToJson, [](const std::string& json) { return parseShape(json, "pickle"); }));
}

void addShapeKinds(py::module_& m) {
  auto type = py::reinterpret_borrow<py::class_<Shape>>(m.attr("Shape"));
  addKinds(m, type, std::make_index_sequence<std::variant_size_v<shapes::Kind>>());
}

} // namespace volcaustic::python
