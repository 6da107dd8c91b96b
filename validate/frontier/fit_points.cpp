#include "validate/frontier/fit_points.h"

#include <algorithm>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/numbers/random.h"
#include "validate/frontier/stopwatch.h"

namespace nlg {
namespace {

enum class Start { generator, theta0, random };
constexpr const char* kStartNames[] = {"generator", "theta0", "random"};

enum class Method { lm, adam };

// One point's settings; several of them share the generator and the fits' memory.
struct FitPoint {
  std::shared_ptr<GeneratorRun> run;
  std::shared_ptr<NormalEquationsKernel> kernel;
  Method method;
  Start start;
  int steps;
  uint64_t seed;

  std::vector<FittedFunction> operator()(const FunctionBlock& block) const {
    std::vector<FittedFunction> functions;
    if (start == Start::generator) functions = run->generateAndCorrect(block);
    const Representation& representation = run->representation();
    functions.resize(block.functions.size(), {representation, {}, 0.0});
    for (size_t i = 0; i < functions.size(); ++i) {
      const Stopwatch watch;
      const WeightingFunction function = decodeFunction(block.stored[i], pointOrder(representation));
      functions[i].theta = fit(function, startTheta(functions[i].theta, block.functions[i])).theta;
      functions[i].elapsed_us += watch.elapsedUs();
    }
    return functions;
  }

  Theta startTheta(const Theta& generated, uint64_t function) const {
    const Generator& generator = run->generator();
    if (start == Start::random) return randomTheta(generator.representation(), mixSeed(seed, function));
    if (start == Start::theta0) return Theta(generator.theta0(), generator.theta0() + generator.representation().thetaCount());
    return generated;
  }

  FitResult fit(const WeightingFunction& function, const Theta& from) const {
    const Representation& representation = run->representation();
    if (method == Method::lm) {
      return fitLevenbergMarquardt(representation, function, from, refinementLevenbergMarquardt(representation, steps),
                                   kernel.get());
    }
    return fitAdam(representation, function, from,
                   start == Start::random ? randomStartAdam(steps) : refinementAdam(representation, steps));
  }
};

// Budgets of direct Adam as fitDirect gives them to a representation.
std::vector<int> directAdamSteps(const Representation& representation, std::vector<int> steps) {
  if (!representation.isField()) return steps;
  for (int& count : steps) count = std::max(1, count / 32);
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  return steps;
}

}  // namespace

std::vector<PlotPoint> fitPoints(const std::shared_ptr<GeneratorRun>& run, const FitBudgets& budgets, uint64_t seed) {
  std::vector<PlotPoint> points;
  const auto kernel = std::make_shared<NormalEquationsKernel>();
  const auto add = [&](Method method, Start start, const std::vector<int>& steps) {
    const std::string start_name = kStartNames[static_cast<int>(start)];
    const std::string method_name = method == Method::lm ? "LM" : "Adam";
    for (const int count : steps) {
      const std::string what = std::to_string(count) + ' ' + method_name;
      points.push_back({representationName(run->representation()),
                        (method == Method::lm ? "lm_from_" : "adam_from_") + start_name, count,
                        start == Start::generator ? "generator + " + what : what + " from " + start_name, true,
                        FitPoint{run, kernel, method, start, count, seed}});
    }
  };
  const std::vector<int> direct_adam = directAdamSteps(run->representation(), budgets.direct_adam);
  add(Method::lm, Start::generator, budgets.lm);
  add(Method::adam, Start::generator, budgets.adam);
  add(Method::lm, Start::theta0, budgets.direct_lm);
  add(Method::adam, Start::theta0, direct_adam);
  add(Method::lm, Start::random, budgets.direct_lm);
  add(Method::adam, Start::random, direct_adam);
  return points;
}

}  // namespace nlg
