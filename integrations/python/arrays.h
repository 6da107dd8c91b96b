// Arguments from Python: arrays are checked and never converted, files are paths or bytes, errors become exceptions.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "nlg/result.h"

namespace nlg {

namespace py = pybind11;

// Row-major and aligned.
template <class T>
using Rows = py::array_t<T, int{py::array::c_style} | int{py::detail::npy_api::NPY_ARRAY_ALIGNED_}>;

inline constexpr py::ssize_t kAnyLength = -1;  // of one axis of a shape

bool hasShape(const py::array& array, std::initializer_list<py::ssize_t> shape);

// Raises ValueError: "positions: expected float64 of shape (n, 3), got float32 of shape (5, 3)".
[[noreturn]] void refuseArray(const char* name, const py::dtype& dtype, std::initializer_list<py::ssize_t> shape,
                              const py::object& got);

// An argument as rows in memory: itself, or a copy where it lies otherwise.
// throws   ValueError where it is no array of this dtype and shape
template <class T>
Rows<T> rowsOf(const char* name, const py::object& argument, std::initializer_list<py::ssize_t> shape) {
  if (!py::isinstance<py::array_t<T>>(argument) || !hasShape(py::reinterpret_borrow<py::array>(argument), shape)) {
    refuseArray(name, py::dtype::of<T>(), shape, argument);
  }
  Rows<T> rows = Rows<T>::ensure(argument);
  if (!rows) throw py::error_already_set();
  return rows;
}

// throws   ValueError where a number is not in [-limit, limit]; NaN is not
void requireWithin(const char* name, const Rows<float>& numbers, float limit);

// What a constructor loads: the bytes themselves, or the path of a file (str, os.PathLike).
struct FileSource {
  bool is_path = false;
  py::bytes held;
  std::string_view text() const { return held; }
};
FileSource sourceOf(const py::object& source);

// Raises OSError where the system refused a file, otherwise ValueError: the result's own line, and its status.
void raiseUnlessOk(const FileResult& result);

// A class's __new__: what Python's own leaves without anything in it, of which every use would crash. __init__ then has nothing to do. The
// class has to be final: what this makes is of no other one.
template <auto load>
auto newOf(const py::handle&, const py::object& source) {
  return load(source);
}

// The classes of the Python module nlg.
void addLightGridClass(pybind11::module_& module);
void addGeneratorClass(pybind11::module_& module);

}  // namespace nlg
