// A small bake for tests: a corner of a house, of every kind of probe but those that are 0 everywhere, fitted for next to no time.
#pragma once

#include "bake/bake_options.h"

namespace nlg {

inline BakeOptions houseCornerOptions(int refine_rounds = 0) {
  BakeOptions options;
  options.spacing_m = 1.5;
  options.extent_m = {"0", "0", "0", "6", "6", "3"};
  options.policy.theta_precision = ThetaPrecision::float32;  // rounding solves last layers again, which hides what stages do
  options.policy.refine_rounds = refine_rounds;
  options.policy.refine_first_steps = 4;
  options.policy.adam_steps = 20;
  options.threads = 2;
  return options;
}

}  // namespace nlg
