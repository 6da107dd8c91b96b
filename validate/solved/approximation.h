// What tiny functions make of a small scene's generated ones: the last two steps from solved functions to a generator's.
#pragma once

#include <functional>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/direct.h"
#include "validate/solved/comparison.h"

namespace nlg {

// Generated functions of all probes as representations stand for them. Probes in free space have the bare tent, as in a light grid.
struct Approximation {
  Weights weights;                  // N x 8, not normalised: max(0, f)
  double function_rmse_mean = 0.0;  // RMSE over valid support points, mean over the probes that have a function
};

// theta from a function as a data set stores it.
using FunctionFit = std::function<Theta(const StoredFunction&)>;

// rule   whose functions are fitted
Approximation approximate(const SolvedScene& scene, const DiffusionRule& rule, const Representation& representation,
                          const FunctionFit& fit);

// The generator with its correction: what a bake has before it refines. Here and below it must outlive the result.
FunctionFit generatorFit(const Generator& generator);

// Direct optimisation from the generator's theta0 and random starts.
FunctionFit directFit(const Generator& generator, const DirectOptions& options);

}  // namespace nlg
