// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/python/exceptions.h"

#include <pybind11/pybind11.h>

#include <exception>
#include <string>

#include "common/base/errors.h"
#include "reconstructor/python/words.h"

namespace sheen {
namespace {

namespace py = pybind11;

// They live as long as the module, which Python never unloads.
PyObject* g_error = nullptr;
PyObject* g_file_error = nullptr;
PyObject* g_config_error = nullptr;

PyObject* added(py::module_& module, const char* name, const char* says, const py::tuple& bases) {
  const std::string full = std::string("sheen.") + name;
  PyObject* const type = PyErr_NewExceptionWithDoc(full.c_str(), says, bases.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  module.add_object(name, type);
  return type;
}

/// A message may hold the name of a file that is no UTF-8.
void raise(PyObject* type, const std::string& what) {
  const auto text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(what.data(), static_cast<py::ssize_t>(what.size()), "backslashreplace"));
  PyErr_SetObject(type, text.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const FileError& error) {
    raise(g_file_error, error.what());
  } catch (const ConfigError& error) {
    raise(g_config_error, error.what());
  } catch (const Error& error) {
    raise(g_error, error.what());
  }
}

}  // namespace

void add_exceptions(py::module_& module) {
  const py::handle os_error = PyExc_OSError, value_error = PyExc_ValueError, exception = PyExc_Exception;
  g_error = added(module, "Error", words::kError, py::make_tuple(exception));
  const py::handle error = g_error;
  g_file_error = added(module, "FileError", words::kFileError, py::make_tuple(error, os_error));
  g_config_error = added(module, "ConfigError", words::kConfigError, py::make_tuple(error, value_error));
  py::register_exception_translator(&translate);
}

}  // namespace sheen
