// Methods that turn a function into theta, measured on the same functions: generator, refinement, direct optimisation.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/refinement.h"
#include "runtime_eval/fit/representation_choice.h"
#include "validate/errors/function_error.h"

namespace nlg {

struct ValidateOptions {
  int direct_functions = 300;    // held-out functions that direct optimisation and refinement of all run on
  int adam_refine_steps = 800;   // refinement of every function by Adam
  int lm_refine_iterations = 8;  // … and by LM
  CorrectionOptions correction;  // the bake's
  RefinementOptions refinement;  // … its policy
  ChoiceOptions choice;          // … and its choice between product fields
  double hard_tent_rmse = 0.01;  // functions whose bare tent is at least so wrong are hard
  DirectOptions direct;
  int threads = 0;  // 0: as many as the machine has
  uint64_t seed = 1;
};

// One method's result on one function.
struct MethodSample {
  uint64_t function = 0;
  FunctionError error;
  double elapsed_us = 0.0;
  bool refined = false;  // policy only: this function failed the check
};

struct MethodResult {
  std::string name;
  std::vector<MethodSample> samples;
  PooledMagnitudes leaks;
};

bool needsRefinement(const FunctionError& error, const ValidateOptions& options);

// The bare tent on every function of the set.
MethodResult measureTent(const FunctionSet& set);

// Time of evaluating a theta at the 8192 support points, µs: the median of many repeats on one thread.
double measureEvaluation(const Representation& representation, const float* theta);

// The generator's network alone on every function, in batches as a bake runs it; theta receives N x D.
MethodResult measureUncorrected(const Generator& generator, const FunctionSet& set, std::vector<float>* theta);

// The generator with correction, as in a bake. elapsed_us is that of both. Weights that have none give the same again.
// uncorrected, theta   from measureUncorrected; theta receives what is corrected
MethodResult measureGenerator(const Generator& generator, const FunctionSet& set, const MethodResult& uncorrected,
                              const CorrectionOptions& options, std::vector<float>* theta);

// The bake's policy on every function: what fails the check after the generator is refined. elapsed_us is the generator's share
// plus the check's and the refinement's.
MethodResult measurePolicy(const Generator& generator, const FunctionSet& set, const MethodResult& generated,
                           const std::vector<float>& theta, const ValidateOptions& options);

// Fits on the chosen functions; each is one result: refined_adam, refined_lm (from the generator's theta), direct (best of all),
// adam_theta0, lm_theta0, adam_random (one fixed budget each, named for what they start from).
std::vector<MethodResult> measureFits(const Generator& generator, const FunctionSet& set, const std::vector<uint64_t>& functions,
                                      const std::vector<float>& theta, const ValidateOptions& options,
                                      const std::function<void(int64_t done)>& progress);

}  // namespace nlg
