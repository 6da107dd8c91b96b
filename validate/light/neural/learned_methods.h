// All networks that learn a scene's light from sample points in air, as rows of the table of methods.
#pragma once

#include <cstdint>
#include <vector>

#include "light/methods/light_method.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

struct LearnedOptions {
  int steps = 3000;  // of training, at most; >= 1
  int thread_count = 1;
  uint64_t seed = 1;
};

struct LearnedMethod {
  LightMethod method;  // its light_s is training alone, by the clock
  LearnedCost cost;
};

// The same methods for any number of threads, on one machine.
// throws   NumericalError where training diverges; InputError where there are too few places to learn from
std::vector<LearnedMethod> learnedMethods(const LitPlaces& lit, const LearnedOptions& options);

}  // namespace nlg
