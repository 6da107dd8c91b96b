// Errors that long fits reach on the sample: direct optimisation, and the best known of each function.
//
// *Direct* starts from theta0 and at random (runtime_eval/fit/direct.h). *Best known* is the lowest error of direct and of two long
// fits that start from what the policy made: Adam with direct's budget, then Levenberg–Marquardt; Levenberg–Marquardt alone. All minimise
// the policy's own loss, and of two the one with the lower blend RMSE is the better.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "runtime_eval/fit/direct.h"
#include "validate/generators/measured_word.h"

namespace nlg {

enum class LongFit : uint8_t { direct, best_known };
inline constexpr int kLongFitCount = 2;
const char* longFitName(LongFit fit);

// Of one function, by LongFit.
//
// function   in the order of the generator's representation, decoded with the loss that the fits minimise
// start      the policy's theta for it
std::array<FitResult, kLongFitCount> fitLong(const Generator& generator, const WeightingFunction& function, const Theta& start,
                                             const DirectOptions& options, NormalEquationsKernel* kernel);

struct LongFits {
  std::vector<MeasuredWord> words;  // by LongFit, on the sample's functions

  const MeasuredWord& at(LongFit fit) const { return words[static_cast<size_t>(fit)]; }
};

// starts   by function of the sample: the policy's theta, PolicyWords::least_wrong
LongFits measureLongFits(const Generator& generator, const FunctionSet& set, const Populations& populations,
                         const std::vector<Theta>& starts, const ValidateOptions& options);

// The seed of a function's random starts.
uint64_t startSeed(const ValidateOptions& options, uint64_t function);

}  // namespace nlg
