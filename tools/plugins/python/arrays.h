// Memory that C++ and NumPy share, and arrays from Python checked before they are used.
#pragma once

#include "common.h"

#include <cstring>
#include <memory>
#include <string>
#include <vector>
#include <volcaustic/types.h>

namespace volcaustic::python {

using Shape3 = std::array<py::ssize_t, 3>;

/// Numbers in C order that `owner` keeps alive: no copy.
template <class T>
py::array view(const T* data, std::vector<py::ssize_t> shape, py::handle owner, bool writable) {
  py::array_t<T> array(std::move(shape), data, owner);
  if (!writable) py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// The numbers of a vector, which moves into the array: no copy.
template <class T, class Element>
py::array adopt(std::vector<Element>&& numbers, std::vector<py::ssize_t> shape) {
  auto owned = std::make_unique<std::vector<Element>>(std::move(numbers));
  const T* data = reinterpret_cast<const T*>(owned->data());
  const py::capsule owner(owned.get(), [](void* vector) { delete static_cast<std::vector<Element>*>(vector); });
  owned.release();
  return view(data, std::move(shape), owner, true);
}

/// What numpy.asarray makes of `given`, as contiguous numbers of type T in this machine's byte order; the same memory
/// where it is that already. -1 in `shape` stands for any length. \throws TypeError for what is no array of numbers (of
/// whole numbers, where T is whole), Error(Usage) for another shape and for numbers that T does not hold.
template <class T>
py::array_t<T> numbersFrom(py::handle given, const std::vector<py::ssize_t>& shape, const std::string& what);

/// An array that a result is written to: of `shape`; made where `out` is None. \throws TypeError, Error(Usage) for one
/// that is not C-contiguous and writable, of this type and shape.
template <class T>
py::array_t<T> resultArray(const py::object& out, const std::vector<py::ssize_t>& shape);

/// N numbers from any sequence or array. \throws TypeError, Error(Usage) for another count, or one that is not finite.
std::array<double, 3> vectorFrom(py::handle given, const std::string& what);
/// A pair of corners. \throws as vectorFrom.
Box boxFrom(py::handle given, const std::string& what);
py::tuple toTuple(const Box& box);

/// Part of a lattice: voxels from `start` up to but not `stop`.
struct VoxelRange {
  Vec3i start{0, 0, 0}, stop{0, 0, 0};
  [[nodiscard]] std::vector<py::ssize_t> shape(int channels) const;
};
/// \param start,stop three whole numbers each, or None for the ends of the domain. \throws Error(Usage) beyond it.
VoxelRange voxelRange(const Domain& domain, const py::object& start, const py::object& stop);

} // namespace volcaustic::python
