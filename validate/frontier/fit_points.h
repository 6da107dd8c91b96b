// Points of fits, from what a generator yields and from scratch, at growing budgets.
#pragma once

#include <memory>

#include "validate/frontier/generator_run.h"

namespace nlg {

// Steps, each list rising.
struct FitBudgets {
  std::vector<int> lm, adam;                // after the generator
  std::vector<int> direct_lm, direct_adam;  // from theta0 and from a random start; of Adam, product fields take a 32nd: each of
                                            // their steps reads all points
};

// Families lm_from_generator, adam_from_generator (both after correction, as a bake refines), lm_from_theta0, adam_from_theta0,
// lm_from_random, adam_from_random. The time holds all that comes before the fit: generator, correction, decoding.
// seed   of the random starts; every function has one of its own, the same for all budgets
std::vector<PlotPoint> fitPoints(const std::shared_ptr<GeneratorRun>& run, const FitBudgets& budgets, uint64_t seed);

}  // namespace nlg
