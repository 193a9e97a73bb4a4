#include "arrays.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

std::string text(py::handle object) { return py::str(object); }

template <class Shape>
std::string shapeText(const Shape& shape) {
  std::ostringstream out;
  out << "(";
  for (std::size_t i = 0; i < shape.size(); ++i) {
    out << (i ? ", " : "");
    if (shape[i] < 0)
      out << "N";
    else
      out << shape[i];
  }
  out << (shape.size() == 1 ? ",)" : ")");
  return out.str();
}

std::vector<py::ssize_t> shapeOf(const py::array& array) { return {array.shape(), array.shape() + array.ndim()}; }

bool fits(const std::vector<py::ssize_t>& shape, const std::vector<py::ssize_t>& wanted) {
  if (shape.size() != wanted.size()) return false;
  for (std::size_t i = 0; i < shape.size(); ++i)
    if (wanted[i] >= 0 && shape[i] != wanted[i]) return false;
  return true;
}

/// Whole numbers that T does not hold would wrap around without a word.
template <class T>
void requireRange(const py::array& array, const std::string& what) {
  if (array.size() == 0) return;
  const auto least = array.attr("min")(), most = array.attr("max")();
  constexpr auto kLeast = std::numeric_limits<T>::min(), kMost = std::numeric_limits<T>::max();
  if (least >= py::int_(kLeast) && most <= py::int_(kMost)) return;
  throw Error(ErrorKind::Usage, what + ": holds numbers from " + text(least) + " to " + text(most) +
                                    "; give numbers from " + std::to_string(kLeast) + " to " + std::to_string(kMost));
}

py::array arrayFrom(py::handle given, const std::string& what) {
  if (given.is_none()) throw py::type_error(what + " must be an array, not None");
  return py::module_::import("numpy").attr("asarray")(given);
}

} // namespace

template <class T>
py::array_t<T> numbersFrom(py::handle given, const std::vector<py::ssize_t>& shape, const std::string& what) {
  const py::array array = arrayFrom(given, what);
  const char kind = array.dtype().kind();
  // An empty list is an array of floats to NumPy.
  const bool whole = kind == 'i' || kind == 'u' || (array.size() == 0 && kind == 'f');
  if (!whole && (std::is_integral_v<T> || kind != 'f'))
    throw py::type_error(what + " must be an array of " + (std::is_integral_v<T> ? "whole numbers" : "numbers") +
                         ", not of " + text(array.dtype()));
  const std::vector<py::ssize_t> got = shapeOf(array);
  if (!fits(got, shape))
    throw Error(ErrorKind::Usage, what + ": has the shape " + shapeText(got) + "; give " + shapeText(shape));
  if constexpr (std::is_integral_v<T>) requireRange<T>(array, what);
  return py::module_::import("numpy").attr("ascontiguousarray")(array, py::dtype::of<T>());
}

template py::array_t<double> numbersFrom<double>(py::handle, const std::vector<py::ssize_t>&, const std::string&);
template py::array_t<float> numbersFrom<float>(py::handle, const std::vector<py::ssize_t>&, const std::string&);
template py::array_t<std::uint32_t> numbersFrom<std::uint32_t>(py::handle, const std::vector<py::ssize_t>&,
                                                               const std::string&);

template <class T>
py::array_t<T> resultArray(const py::object& out, const std::vector<py::ssize_t>& shape) {
  if (out.is_none()) return py::array_t<T>(shape);
  if (!py::isinstance<py::array>(out))
    throw py::type_error("out must be a numpy.ndarray, not " + text(py::type::of(out)));
  const auto array = py::reinterpret_borrow<py::array>(out);
  if (!array.dtype().equal(py::dtype::of<T>()))
    throw py::type_error("out must be of " + text(py::dtype::of<T>()) + ", not of " + text(array.dtype()));
  if (shapeOf(array) != shape)
    throw Error(ErrorKind::Usage, "out: has the shape " + shapeText(shapeOf(array)) + "; give " + shapeText(shape));
  if (!(array.flags() & py::array::c_style) || !array.writeable())
    throw Error(ErrorKind::Usage, "out: is not C-contiguous and writable; give an array as numpy.empty makes it");
  return py::reinterpret_borrow<py::array_t<T>>(out);
}

template py::array_t<float> resultArray<float>(const py::object&, const std::vector<py::ssize_t>&);
template py::array_t<double> resultArray<double>(const py::object&, const std::vector<py::ssize_t>&);

std::array<double, 3> vectorFrom(py::handle given, const std::string& what) {
  const auto numbers = numbersFrom<double>(given, {3}, what);
  std::array<double, 3> vector{numbers.at(0), numbers.at(1), numbers.at(2)};
  for (const double number : vector)
    if (!std::isfinite(number)) throw Error(ErrorKind::Usage, what + ": holds a number that is not finite");
  return vector;
}

Box boxFrom(py::handle given, const std::string& what) {
  const auto corners = numbersFrom<double>(given, {2, 3}, what);
  return {vectorFrom(corners[py::int_(0)], what), vectorFrom(corners[py::int_(1)], what)};
}

py::tuple toTuple(const Box& box) { return py::make_tuple(py::tuple(py::cast(box.min)), py::tuple(py::cast(box.max))); }

std::vector<py::ssize_t> VoxelRange::shape(int channels) const {
  std::vector<py::ssize_t> all{stop[0] - start[0], stop[1] - start[1], stop[2] - start[2]};
  if (channels > 1) all.push_back(channels);
  return all;
}

VoxelRange voxelRange(const Domain& domain, const py::object& start, const py::object& stop) {
  const auto corner = [](const py::object& given, const Vec3i& standard, const char* what) {
    if (given.is_none()) return standard;
    const auto numbers = numbersFrom<std::uint32_t>(given, {3}, what);
    Vec3i voxel{};
    for (int axis = 0; axis < 3; ++axis) // what is larger is beyond every domain
      voxel[axis] = static_cast<int>(std::min<std::uint32_t>(numbers.at(axis), std::numeric_limits<int>::max()));
    return voxel;
  };
  const VoxelRange range{corner(start, {0, 0, 0}, "start"), corner(stop, domain.dims, "stop")};
  for (int axis = 0; axis < 3; ++axis)
    if (range.start[axis] > range.stop[axis] || range.stop[axis] > domain.dims[axis])
      throw Error(ErrorKind::Usage, "start " + shapeText(range.start) + ", stop " + shapeText(range.stop) +
                                        ": is no part of a domain of " + shapeText(domain.dims) + " voxels");
  return range;
}

} // namespace volcaustic::python
