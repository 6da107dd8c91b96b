// The classes of the Python module nlg.
#pragma once

#include <pybind11/pybind11.h>

namespace nlg {

void addLightGridClass(pybind11::module_& module);
void addGeneratorClass(pybind11::module_& module);

}  // namespace nlg
