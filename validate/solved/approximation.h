// What a bake makes of a small scene's target functions: the last steps from solved functions to what a light grid stores.
#pragma once

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/theta_policy.h"
#include "validate/solved/comparison.h"

namespace nlg {

// The target functions of a scene's probes as a data set stores them. Probes in free space have none.
struct TargetFunctions {
  std::vector<std::vector<uint8_t>> phi, validity;  // by function: P bytes, P bits
  std::vector<int> of_probe;                        // the probe's function; -1: none

  std::vector<StoredFunction> views() const;
};
// rule   that generates them
TargetFunctions targetFunctions(const SolvedScene& scene, const DiffusionRule& rule);

// theta by function; empty where the bare tent stands for it.
using ThetaOfFunctions = std::vector<Theta>;

// What the light grid's policy makes of the functions with one generator, at each of the four words. A function that takes no theta
// has the bare tent at every word, as in all figures of this project.
std::array<ThetaOfFunctions, kThetaWordCount> thetaByWord(const Generator& generator, const TargetFunctions& functions,
                                                          const PolicyOptions& policy);

// The lowest error that long fits find, for every function that takes a theta.
// starts   where some of the fits start
ThetaOfFunctions bestKnownTheta(const Generator& generator, const TargetFunctions& functions, const ThetaOfFunctions& starts,
                                const DirectOptions& options);

// All probes of a scene as theta stand for their functions. Probes in free space have the bare tent, as in a light grid.
struct Approximation {
  BlendWeights weights;             // N x 8, not normalised: f from 0 to the tent, as a look-up has it
  double function_rmse_mean = 0.0;  // RMSE over valid support points, mean over the functions
};
Approximation approximate(const SolvedScene& scene, const TargetFunctions& functions, const Representation& representation,
                          const ThetaOfFunctions& theta);

}  // namespace nlg
