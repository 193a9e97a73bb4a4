#include "medium_grids.h"

#include "call.h"
#include "keywords.h"

#include <algorithm>
#include <openvdb/tools/Dense.h>
#include <volcaustic/error.h>
#include <volcaustic/openvdb.h>

namespace volcaustic::python {

namespace {

openvdb::CoordBBox boxOf(const VoxelRange& range) {
  return {openvdb::Coord(range.start[0], range.start[1], range.start[2]),
          openvdb::Coord(range.stop[0] - 1, range.stop[1] - 1, range.stop[2] - 1)};
}

bool isEmpty(const VoxelRange& range) {
  for (int axis = 0; axis < 3; ++axis)
    if (range.start[axis] >= range.stop[axis]) return true;
  return false;
}

/// OpenVDB's "ZYX" runs fastest along z, as arrays in C order do.
template <class Grid>
void copyOut(const Grid& grid, const VoxelRange& range, float* into) {
  using Value = typename Grid::ValueType;
  if (isEmpty(range)) return;
  openvdb::tools::Dense<Value, openvdb::tools::LayoutZYX> dense(boxOf(range), reinterpret_cast<Value*>(into));
  openvdb::tools::copyToDense(grid, dense);
}

template <class Grid>
typename Grid::ConstPtr gridOf(const Domain& domain, const float* numbers, const typename Grid::ValueType& background) {
  using Value = typename Grid::ValueType;
  auto grid = Grid::create(background);
  grid->setTransform(domainTransform(domain));
  const openvdb::tools::Dense<Value, openvdb::tools::LayoutZYX> dense(
      boxOf({{0, 0, 0}, domain.dims}), reinterpret_cast<Value*>(const_cast<float*>(numbers)));
  openvdb::tools::copyFromDense(dense, *grid, Value(0.f));
  return grid;
}

openvdb::Vec3s colour(const Rgb& rgb) { return {float(rgb[0]), float(rgb[1]), float(rgb[2])}; }

struct Range {
  const char* name;
  double least, most;
};

/// A field of a medium from Python; null where it is not given. \throws Error(Usage) for what cannot be.
std::optional<py::array_t<float>> fieldFrom(const py::object& given, const Domain& domain, int channels,
                                            const Range& range) {
  if (given.is_none()) return std::nullopt;
  auto numbers = numbersFrom<float>(given, VoxelRange{{0, 0, 0}, domain.dims}.shape(channels), range.name);
  const float* first = numbers.data();
  const float* last = first + numbers.size();
  const auto bad = std::find_if(first, last, [&](float x) { return !(x >= range.least && x <= range.most); });
  if (bad != last)
    throw Error(ErrorKind::Usage, std::string(range.name) + ": holds " + std::to_string(*bad) + "; give numbers from " +
                                      std::to_string(range.least) + " to " + std::to_string(range.most));
  return numbers;
}

void requireScatteringWithin(const std::optional<py::array_t<float>>& scattering,
                             const std::optional<py::array_t<float>>& attenuation, const Ambient& ambient) {
  const auto at = [](const std::optional<py::array_t<float>>& field, const Rgb& usual, py::ssize_t i) {
    return field ? field->data()[i] : static_cast<float>(usual[static_cast<std::size_t>(i % 3)]);
  };
  const py::ssize_t count = scattering ? scattering->size() : attenuation ? attenuation->size() : 0;
  for (py::ssize_t i = 0; i < count; ++i)
    if (at(scattering, ambient.scattering, i) > at(attenuation, ambient.attenuation, i))
      throw Error(ErrorKind::Usage, "scattering: is more than the attenuation somewhere; attenuation includes it");
}

Medium mediumFrom(const Domain& domain, const py::object& index, const py::kwargs& given) {
  Keywords keywords("medium_from_arrays()", given);
  const auto ambient = objectFrom<Ambient>(keywords, "ambient");
  const auto field = [&](const char* name) {
    const py::object numbers = keywords.take(name);
    return numbers ? numbers : py::object(py::none());
  };
  const auto n = fieldFrom(index, domain, 1, {"index", .1, 10});
  if (!n) throw py::type_error("medium_from_arrays(): index must be an array, not None");
  const auto attenuation = fieldFrom(field("attenuation"), domain, 3, {"attenuation", 0, 1e9});
  const auto scattering = fieldFrom(field("scattering"), domain, 3, {"scattering", 0, 1e9});
  const auto coverage = fieldFrom(field("coverage"), domain, 1, {"coverage", 0, 1});
  const auto asymmetry = fieldFrom(field("asymmetry"), domain, 1, {"asymmetry", -.99, .99});
  requireScatteringWithin(scattering, attenuation, ambient);
  Call call(keywords);
  keywords.finish();
  return call.run([&] {
    MediumGrids grids;
    grids.index = gridOf<openvdb::FloatGrid>(domain, n->data(), float(ambient.index));
    if (attenuation)
      grids.attenuation = gridOf<openvdb::Vec3SGrid>(domain, attenuation->data(), colour(ambient.attenuation));
    if (scattering)
      grids.scattering = gridOf<openvdb::Vec3SGrid>(domain, scattering->data(), colour(ambient.scattering));
    if (coverage) grids.coverage = gridOf<openvdb::FloatGrid>(domain, coverage->data(), 0.f);
    if (asymmetry) grids.asymmetry = gridOf<openvdb::FloatGrid>(domain, asymmetry->data(), float(ambient.asymmetry));
    return mediumFromGrids(domain, ambient, std::move(grids));
  });
}

} // namespace

void readField(const Medium& medium, MediumField field, const VoxelRange& range, float* into) {
  const MediumGrids& grids = medium.grids();
  switch (field) {
  case MediumField::Index:
    return copyOut(*grids.index, range, into);
  case MediumField::Attenuation:
    return copyOut(*grids.attenuation, range, into);
  case MediumField::Scattering:
    return copyOut(*grids.scattering, range, into);
  case MediumField::Coverage:
    return copyOut(*grids.coverage, range, into);
  case MediumField::Asymmetry:
    break;
  }
  if (grids.asymmetry) return copyOut(*grids.asymmetry, range, into);
  std::size_t count = 1;
  for (const py::ssize_t side : range.shape(1)) count *= static_cast<std::size_t>(side);
  std::fill_n(into, count, static_cast<float>(medium.ambient().asymmetry));
}

void addMediumGrids(py::module_& m) {
  m.def("medium_from_arrays", &mediumFrom, py::arg("domain"), py::arg("index"),
        "A medium of numbers at the voxels' centres: index, coverage and asymmetry (nx, ny, nz), attenuation and "
        "scattering (nx, ny, nz, 3); what is not given is that of `ambient`. Numbers are copied once, into sparse "
        "voxels. Keywords of every long call. Raises UsageError for shapes and numbers that cannot be.");
}

} // namespace volcaustic::python
