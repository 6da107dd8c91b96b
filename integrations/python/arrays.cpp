#include "integrations/python/arrays.h"

#include <cmath>

namespace nlg {
namespace {

std::string shapeText(const py::ssize_t* lengths, size_t count) {
  std::string text = "(";
  for (size_t i = 0; i < count; ++i) {
    if (i > 0) text += ", ";
    text += lengths[i] == kAnyLength ? "n" : std::to_string(lengths[i]);
  }
  return text + (count == 1 ? ",)" : ")");
}

std::string arrayText(const py::dtype& dtype, const std::string& shape) {
  return py::str(py::handle(dtype)).cast<std::string>() + " of shape " + shape;
}

}  // namespace

bool hasShape(const py::array& array, std::initializer_list<py::ssize_t> shape) {
  if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
  const py::ssize_t* length = array.shape();
  for (const py::ssize_t expected : shape) {
    if (expected != kAnyLength && *length != expected) return false;
    ++length;
  }
  return true;
}

void refuseArray(const char* name, const py::dtype& dtype, std::initializer_list<py::ssize_t> shape, const py::object& got) {
  std::string text = std::string(name) + ": expected " + arrayText(dtype, shapeText(shape.begin(), shape.size())) + ", got ";
  if (py::isinstance<py::array>(got)) {
    const auto array = py::reinterpret_borrow<py::array>(got);
    text += arrayText(array.dtype(), shapeText(array.shape(), static_cast<size_t>(array.ndim())));
  } else {
    text += "no array but " + py::str(py::type::of(got).attr("__name__")).cast<std::string>();
  }
  throw py::value_error(text);
}

void requireWithin(const char* name, const Rows<float>& numbers, float limit) {
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    // as the comparison is written, NaN is not within
    if (std::abs(numbers.data()[i]) <= limit) continue;
    throw py::value_error(std::string(name) + ": expected numbers within ±" + py::str(py::float_(limit)).cast<std::string>() +
                          ", got " + py::str(py::float_(numbers.data()[i])).cast<std::string>());
  }
}

FileSource sourceOf(const py::object& source) {
  if (py::isinstance<py::bytes>(source)) return {false, py::reinterpret_borrow<py::bytes>(source)};
  // refuses what is no path, and a zero in it
  PyObject* path = nullptr;
  if (PyUnicode_FSConverter(source.ptr(), &path) == 0) throw py::error_already_set();
  return {true, py::reinterpret_steal<py::bytes>(path)};
}

void raiseUnlessOk(const FileResult& result) {
  if (result.ok()) return;
  const bool of_system = result.status == FileStatus::cannot_open || result.status == FileStatus::cannot_read;
  const std::string text = of_system ? result.detail : result.detail + " (" + fileStatusName(result.status) + ")";
  // a path in it may be any bytes
  const auto line =
      py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefaultAndSize(text.data(), static_cast<py::ssize_t>(text.size())));
  if (line) PyErr_SetObject(of_system ? PyExc_OSError : PyExc_ValueError, line.ptr());
  throw py::error_already_set();
}

}  // namespace nlg
