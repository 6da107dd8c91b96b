// nlg.Generator: weights, the theta that they make of functions, and what theta stands for.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "integrations/python/arrays.h"
#include "nlg/light_grid.h"
#include "nlg/policy.h"

namespace nlg {
namespace {

// Between two looks for Ctrl-C.
constexpr py::ssize_t kFunctionsAtOnce = 64;

std::unique_ptr<Generator> loadGenerator(const py::object& source) {
  const FileSource file = sourceOf(source);
  auto generator = std::make_unique<Generator>();
  raiseUnlessOk(file.is_path ? Generator::load(std::string(file.text()), generator.get())
                             : Generator::parse(file.text(), generator.get()));
  return generator;
}

py::ssize_t thetaCount(const Generator& generator) { return generator.representation().thetaCount(); }

// work(first, count) for pieces of the functions, without Python's lock.
template <class Work>
void inPieces(py::ssize_t function_count, const Work& work) {
  for (py::ssize_t first = 0; first < function_count; first += kFunctionsAtOnce) {
    {
      const py::gil_scoped_release released;
      work(first, static_cast<int>(std::min(kFunctionsAtOnce, function_count - first)));
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

Rows<float> generate(const Generator& generator, const py::object& phi, const py::object& validity) {
  const Rows<uint8_t> samples = rowsOf<uint8_t>("phi", phi, {kAnyLength, kSupportPointCount});
  const Rows<uint8_t> valid = rowsOf<uint8_t>("validity", validity, {samples.shape(0), kValidityByteCount});
  Rows<float> theta({samples.shape(0), thetaCount(generator)});
  float* const to = theta.mutable_data();
  GeneratorScratch scratch(generator);
  inPieces(samples.shape(0), [&](py::ssize_t first, int count) {
    std::vector<StoredFunction> functions;
    for (py::ssize_t i = first; i < first + count; ++i) functions.push_back({samples.data(i), valid.data(i)});
    generator.generate(functions.data(), count, to + first * generator.representation().thetaCount(), &scratch);
  });
  return theta;
}

py::tuple makeTheta(const Generator& generator, const py::object& phi, const py::object& validity, const py::object& blend_sum) {
  // shapes and types are checked, never converted: a copy of large arrays would go unnoticed
  const Rows<uint8_t> samples = rowsOf<uint8_t>("phi", phi, {kAnyLength, kSupportPointCount});
  const py::ssize_t function_count = samples.shape(0);
  const Rows<uint8_t> valid = rowsOf<uint8_t>("validity", validity, {function_count, kValidityByteCount});
  const uint8_t *const phi_from = samples.data(), *const valid_from = valid.data();
  // without sums S counts as 1 everywhere
  const uint8_t* sums_from = nullptr;
  Rows<uint8_t> sums;
  if (!blend_sum.is_none()) {
    sums = rowsOf<uint8_t>("blend_sum", blend_sum, {function_count, kSupportPointCount});
    sums_from = sums.data();
  }
  // functions for which the bare tent is enough keep zeros
  Rows<float> theta({function_count, thetaCount(generator)});
  Rows<bool> has_theta(function_count);
  Rows<double> rmse(function_count);
  float* const theta_to = theta.mutable_data();
  bool* const has_theta_to = has_theta.mutable_data();
  double* const rmse_to = rmse.mutable_data();
  std::fill_n(theta_to, theta.size(), 0.0f);
  // in pieces, each without Python's lock: other threads run, and Ctrl-C is heard between them
  ThetaPolicy policy({&generator}, PolicyOptions{});
  inPieces(function_count, [&](py::ssize_t first, int count) {
    std::vector<StoredFunction> functions;
    std::vector<MadeTheta> made(static_cast<size_t>(count));
    for (py::ssize_t i = first; i < first + count; ++i) {
      functions.push_back({phi_from + i * kSupportPointCount, valid_from + i * kValidityByteCount, nullptr,
                           sums_from != nullptr ? sums_from + i * kSupportPointCount : nullptr});
    }
    // a piece is one batch of the policy, as in a bake
    policy.bake(functions.data(), count, made.data());
    for (int i = 0; i < count; ++i) {
      std::copy(made[i].theta.begin(), made[i].theta.end(), theta_to + (first + i) * generator.representation().thetaCount());
      has_theta_to[first + i] = !made[i].isBareTent();
      rmse_to[first + i] = made[i].check().rmse;
    }
  });
  return py::make_tuple(theta, has_theta, rmse);
}

Rows<float> evaluateTheta(const Generator& generator, const py::object& theta, const py::object& points) {
  const Rows<float> numbers = rowsOf<float>("theta", theta, {thetaCount(generator)});
  const Rows<float> places = rowsOf<float>("points", points, {kAnyLength, 3});
  requireWithin("theta", numbers, kMaxGridTheta);
  requireWithin("points", places, 1.0f);
  const float *const theta_from = numbers.data(), *const places_from = places.data();
  Rows<float> phi(places.shape(0));
  float* const to = phi.mutable_data();
  const py::ssize_t point_count = places.shape(0);
  const py::gil_scoped_release released;
  static_assert(sizeof(LocalPoint) == 3 * sizeof(float));
  evaluate(generator.representation(), reinterpret_cast<const LocalPoint*>(places_from), static_cast<size_t>(point_count),
           theta_from, to);
  return phi;
}

}  // namespace

void addGeneratorClass(py::module_& module) {
  py::class_<Generator>(module, "Generator", py::is_final(), R"(Generator(source): a trained generator, what nlg-export wrote.

source: the path of a weights file (str or os.PathLike), or its bytes. Every byte is checked.
Raises OSError where the file cannot be read, ValueError where it is damaged or no weights file.
Any number of threads may use one. Below, P is 8192 and D the numbers of one theta.)")
      .def(py::init(&loadGenerator), py::arg("source"))
      .def_static("__new__", &newOf<&loadGenerator>, py::arg("cls"), py::arg("source"))
      .def_property_readonly(
          "representation", [](const Generator& generator) { return representationName(generator.representation()); },
          "str: what theta stands for, \"tent_mlp4\".")
      .def_property_readonly("theta_count", &thetaCount, "int: D.")
      .def("generate", &generate, py::arg("phi"), py::arg("validity"),
           R"(generate(phi, validity) -> theta: the network alone.

phi:      (n, P) uint8: functions at support_points(), round(255 phi); 0 at points inside solid
validity: (n, P / 8) uint8: 1 outside solid, a bit a point, as of make_theta
theta:    (n, D) float32)")
      .def("make_theta", &makeTheta, py::arg("phi"), py::arg("validity"), py::arg("blend_sum") = py::none(),
           R"(make_theta(phi, validity, blend_sum=None) -> theta, has_theta, rmse

The whole policy of a bake, with its defaults: network, check, exact last layer, fits, refinement of what fails, rounding.

phi:       (n, P) uint8: functions at support_points(), round(255 phi); 0 at points inside solid
validity:  (n, P / 8) uint8: 1 outside solid, a bit a point: numpy.packbits(valid, axis=1, bitorder="little")
blend_sum: (n, P) uint8: round(255 min(1, S)), S the sum of the functions of all probes of the cell there; None: 1 everywhere, and
           places that one probe alone sees may turn black
theta:     (n, D) float32, rounded as a light grid holds them
has_theta: (n,) bool: False where the bare tent is enough, and theta is all 0
rmse:      (n,) float64: of what stands for the function, over valid points

Other threads of Python run meanwhile; Ctrl-C is heard.)")
      .def("evaluate", &evaluateTheta, py::arg("theta"), py::arg("points"), R"(evaluate(theta, points) -> phi

theta:  (D,) float32
points: (n, 3) float32, local coordinates in [-1, 1]; one unit is one probe spacing
phi:    (n,) float32, not clamped)");
}

}  // namespace nlg
