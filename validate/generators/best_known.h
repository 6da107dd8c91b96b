// Errors that long fits reach on the sample: direct optimisation, its parts, and the best known of each function.
//
// *Direct* starts from theta0 and at random (runtime_eval/fit/direct.h). *Best known* is the lowest error of direct and of two long
// fits that start from what the policy made: Adam with direct's budget, then Levenberg–Marquardt; Levenberg–Marquardt alone. All minimise
// the policy's own loss, and of two the one with the lower blend RMSE is the better.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "runtime_eval/fit/direct.h"
#include "validate/generators/measured_word.h"

namespace nlg {

enum class LongFit : uint8_t { direct, adam_theta0, lm_theta0, adam_random, best_known };
inline constexpr int kLongFitCount = 5;
const char* longFitName(LongFit fit);

// All long fits of one function.
struct FunctionFits {
  std::array<FitResult, kLongFitCount> fits;  // by LongFit
  const char* best_known_from = "";           // the fit that found it: "direct", "adam_policy", "lm_policy"

  const FitResult& at(LongFit fit) const { return fits[static_cast<size_t>(fit)]; }
};

// function   in the order of the generator's representation, decoded with the loss that the fits minimise
// start      the policy's theta for it
FunctionFits fitLong(const Generator& generator, const WeightingFunction& function, const Theta& start,
                     const DirectOptions& options, NormalEquationsKernel* kernel);

struct LongFits {
  std::vector<MeasuredWord> words;                  // by LongFit, on the sample's functions
  std::map<std::string, uint64_t> best_known_from;  // as of one function → functions

  const MeasuredWord& at(LongFit fit) const { return words[static_cast<size_t>(fit)]; }
};

// starts   by function of the sample: the policy's theta, PolicyWords::least_wrong
LongFits measureLongFits(const Generator& generator, const FunctionSet& set, const Populations& populations,
                         const std::vector<Theta>& starts, const ValidateOptions& options);

// The seed of a function's random starts.
uint64_t startSeed(const ValidateOptions& options, uint64_t function);

// Whether direct optimisation has converged: its error on hard functions with more random starts, and with fewer and more steps.
//
// Mean blend RMSE over the same functions of the best of all fits, at one setting.
struct ConvergencePoint {
  int restarts = 0;
  int adam_steps = 0;
  double blend_rmse_mean = 0.0;
};

struct Convergence {
  uint64_t functions = 0;
  std::vector<ConvergencePoint> by_restarts;  // 0 … twice those of direct, at its steps
  std::vector<ConvergencePoint> by_steps;     // a quarter, half, all, twice those of direct, at its restarts
  double best_known_blend_rmse_mean = 0.0;    // of the same functions: what the sample's ratios are taken to
};

// fits   of the sample
Convergence measureConvergence(const Generator& generator, const FunctionSet& set, const Populations& populations,
                               const LongFits& fits, const ValidateOptions& options);

}  // namespace nlg
