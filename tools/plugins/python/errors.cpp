// volcaustic::Error as a family of Python exceptions.
#include "common.h"

#include <array>
#include <cstring>
#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

struct ErrorType {
  ErrorKind kind;
  const char* name;
  PyObject* alsoIs; ///< a built-in exception that it is, too; or null
  const char* doc;
};

std::array<PyObject*, 6> gTypes{}; // by kind; they live as long as the process

PyObject* newType(const char* name, const py::tuple& bases, const char* doc) {
  PyObject* type = PyErr_NewExceptionWithDoc((std::string("volcaustic.") + name).c_str(), doc, bases.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  return type;
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Error& error) {
    // Names of files are bytes, and may be no UTF-8.
    const auto message = py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(error.what(), static_cast<py::ssize_t>(std::strlen(error.what())), "replace"));
    PyErr_SetObject(gTypes[static_cast<std::size_t>(error.kind())], message.ptr());
  }
}

} // namespace

void addErrors(py::module_& m) {
  const std::array<ErrorType, 6> types{{
      {ErrorKind::Usage, "UsageError", PyExc_ValueError, "An argument is out of range or contradicts another."},
      {ErrorKind::Input, "InputError", nullptr, "The content of a file, a scene or a mesh is wrong."},
      {ErrorKind::File, "FileError", PyExc_OSError, "A file cannot be opened, read or written."},
      {ErrorKind::Device, "DeviceError", nullptr, "There is no such device, or it ran out of memory."},
      {ErrorKind::Cancelled, "Cancelled", nullptr,
       "The call was stopped (Session.cancel); Ctrl-C is KeyboardInterrupt."},
      {ErrorKind::Internal, "InternalError", nullptr, "A defect of volcaustic itself."},
  }};
  PyObject* base = newType("Error", py::make_tuple(py::handle(PyExc_Exception)),
                           "What volcaustic raises: one line that begins with the place and says what to try.");
  m.attr("Error") = py::handle(base);
  for (const ErrorType& type : types) {
    const py::tuple bases =
        type.alsoIs ? py::make_tuple(py::handle(base), py::handle(type.alsoIs)) : py::make_tuple(py::handle(base));
    PyObject* made = newType(type.name, bases, type.doc);
    gTypes[static_cast<std::size_t>(type.kind)] = made;
    m.attr(type.name) = py::handle(made);
  }
  py::register_exception_translator(translate);
}

} // namespace volcaustic::python
