// The module nlg for Python: light out of light grids, theta of functions. Arrays are numpy's.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdlib>
#include <string>

#include "integrations/python/arrays.h"
#include "nlg/look_up.h"
#include "nlg/simd.h"

namespace nlg {
namespace {

Rows<float> supportPoints() {
  const SupportPattern& pattern = supportPattern();
  return Rows<float>({py::ssize_t{kSupportPointCount}, py::ssize_t{3}}, pattern.points.front().data());
}

}  // namespace
}  // namespace nlg

PYBIND11_MODULE(nlg, module) {
  using namespace nlg;
  // no thread is inside the library yet
  if (const SimdStatus status = forceSimdTargetFromEnvironment(); status != SimdStatus::ok) {
    throw py::import_error(simdRefusal(std::getenv("NLG_SIMD"), status));
  }
  // docstrings have signatures of their own, with shapes and types
  py::options options;
  options.disable_function_signatures();
  module.doc() = R"(Neural light grids: light at positions (LightGrid), and theta of weighting functions (Generator).

Arrays are taken as the docstrings say and never converted: another dtype or shape raises ValueError.)";
  // names for the library's numbers, so that scripts need no literals
  module.attr("FREE_SPACE") = -1;
  module.attr("NO_WEIGHT") = -2;
  module.attr("LIT") = static_cast<int>(LightStatus::lit);
  module.attr("FAINT") = static_cast<int>(LightStatus::faint);
  module.attr("UNLIT") = static_cast<int>(LightStatus::unlit);
  module.attr("OUTSIDE") = static_cast<int>(LightStatus::outside);
  module.def("support_points", &supportPoints,
             "support_points() -> (8192, 3) float32: where functions are sampled, local coordinates in (-1, 1).");
  addLightGridClass(module);
  addGeneratorClass(module);
}
