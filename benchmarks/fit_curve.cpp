// Error against time of fits, on stored functions: Adam and Levenberg–Marquardt at growing budgets, from theta0, from the
// generator's theta and from random starts, beside direct optimisation; and how many functions that fail the check each
// refinement saves.
//
//     bench_fit_curve WEIGHTS FUNCTION_COUNT SHARD...
//
// Functions are taken evenly over the shards. Prints Markdown; "direct" is fitDirect at its defaults. Time is the fit's own
// clock: give it a core of its own.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/refinement.h"
#include "tool/error.h"

namespace nlg {
namespace {

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<size_t>(q * static_cast<double>(values.size())))];
}

// One function with everything that fits start from.
struct Case {
  StoredFunction stored;
  WeightingFunction function;
  Theta generated, theta0;
  uint64_t seed;
};

struct Method {
  std::string name;
  std::function<FitResult(const Representation&, const Case&, NormalEquationsKernel*)> fit;
  bool fields_only = false;
};

FitResult adam(const Representation& representation, const Case& c, const Theta& start, int steps) {
  return fitAdam(representation, c.function, start, refinementAdam(representation, steps));
}

FitResult levenbergMarquardt(const Representation& representation, const Case& c, const Theta& start, int iterations,
                             NormalEquationsKernel* kernel) {
  return fitLevenbergMarquardt(representation, c.function, start, refinementLevenbergMarquardt(representation, iterations),
                               kernel);
}

std::vector<Method> methods() {
  std::vector<Method> list;
  for (const bool from_generator : {false, true}) {
    const std::string start = from_generator ? " from the generator" : " from θ₀";
    const auto startOf = [from_generator](const Case& c) { return from_generator ? c.generated : c.theta0; };
    for (const int steps : {100, 400, 800, 1600, 3200, 6400, 8000, 12800, 32000}) {
      list.push_back(
          {"Adam " + std::to_string(steps) + start,
           [=](const Representation& r, const Case& c, NormalEquationsKernel*) { return adam(r, c, startOf(c), steps); }});
    }
    for (const int iterations : {2, 4, 8, 16, 32, 64}) {
      list.push_back(
          {"LM " + std::to_string(iterations) + start, [=](const Representation& r, const Case& c, NormalEquationsKernel* k) {
             return levenbergMarquardt(r, c, startOf(c), iterations, k);
           }});
    }
  }
  for (const int iterations : {5, 10, 20, 40}) {
    list.push_back({"LM " + std::to_string(iterations) + " from coarse to fine",
                    [=](const Representation& r, const Case& c, NormalEquationsKernel* k) {
                      return fitNested(r, c.function, iterations, k);
                    },
                    true});
  }
  for (const int steps : {8000, 32000}) {
    list.push_back({"Adam " + std::to_string(steps) + " from a random start",
                    [=](const Representation& r, const Case& c, NormalEquationsKernel*) {
                      return fitAdam(r, c.function, randomTheta(r, c.seed), randomStartAdam(steps));
                    }});
  }
  return list;
}

void run(const std::string& weights, int function_count, const std::vector<std::string>& shards) {
  Generator generator;
  const WeightsResult loaded = Generator::load(weights, &generator);
  if (!loaded.ok()) throw InputError(weights, weightsStatusName(loaded.status), "the weights of a generator", loaded.detail);
  const FunctionSet set = readFunctionSet(shards, supportPattern().hash, kSupportPointCount);
  const Representation& representation = generator.representation();
  const int D = representation.thetaCount();
  GeneratorScratch scratch(generator);
  FunctionChecker checker;
  NormalEquationsKernel kernel;
  const CheckOptions check;
  std::vector<Method> all = methods();
  if (!representation.isField()) std::erase_if(all, [](const Method& method) { return method.fields_only; });
  std::vector<std::vector<double>> rmse(all.size()), ratio(all.size()), milliseconds(all.size());
  std::vector<int> saved(all.size(), 0);
  std::vector<double> direct_rmse, generated_rmse;
  int failed = 0;
  for (int i = 0; i < function_count; ++i) {
    const uint64_t n = static_cast<uint64_t>(i) * set.functionCount() / static_cast<uint64_t>(function_count);
    Case c{storedFunction(set, n), {}, Theta(D), Theta(generator.theta0(), generator.theta0() + D), n};
    c.function = decodeFunction(c.stored, pointOrder(representation));
    generator.generate(c.stored.phi, 1, c.generated.data(), &scratch);
    generated_rmse.push_back(functionRmse(representation, c.function, c.generated.data()));
    direct_rmse.push_back(fitDirect(representation, c.function, c.theta0, {}, &kernel).best.rmse);
    const bool failing = !checker.check(representation, c.stored, c.generated.data(), check).passes(check);
    failed += failing;
    for (size_t m = 0; m < all.size(); ++m) {
      const FitResult fit = all[m].fit(representation, c, &kernel);
      rmse[m].push_back(fit.rmse);
      ratio[m].push_back(fit.rmse / direct_rmse.back());
      milliseconds[m].push_back(fit.elapsed_us * 1e-3);
      saved[m] += failing && checker.check(representation, c.stored, fit.theta.data(), check).passes(check);
    }
  }
  std::printf("%s, %d functions, %d fail the check after the generator\n\n", representationName(representation), function_count,
              failed);
  std::printf(
      "| | ms, median | RMSE median | p95 | over direct: median | p95 | failing ones saved |\n|---|---|---|---|---|---|---|\n");
  std::printf("| generator | | %.4f | %.4f | | | |\n", quantile(generated_rmse, 0.5), quantile(generated_rmse, 0.95));
  for (size_t m = 0; m < all.size(); ++m) {
    std::printf("| %s | %.2f | %.4f | %.4f | %.3f | %.2f | %d |\n", all[m].name.c_str(), quantile(milliseconds[m], 0.5),
                quantile(rmse[m], 0.5), quantile(rmse[m], 0.95), quantile(ratio[m], 0.5), quantile(ratio[m], 0.95), saved[m]);
  }
  std::printf("| direct | | %.4f | %.4f | 1 | 1 | |\n", quantile(direct_rmse, 0.5), quantile(direct_rmse, 0.95));
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  const int function_count = argc > 3 ? std::atoi(argv[2]) : 0;
  if (function_count < 1) {
    std::fprintf(stderr, "usage: bench_fit_curve WEIGHTS FUNCTION_COUNT SHARD...\n");
    return 2;
  }
  try {
    nlg::run(argv[1], function_count, {argv + 3, argv + argc});
  } catch (const nlg::ToolError& error) {
    std::fprintf(stderr, "bench_fit_curve: error: %s\n", error.what());
    return static_cast<int>(error.exitCode());
  }
}
