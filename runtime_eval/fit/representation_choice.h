// Which of several representations stands for a function: the smallest whose error would hardly fall with a larger one.
//
// The talk evaluates product fields of all resolutions and takes the point where their errors flatten. Here that is done over any
// representations, on the errors of the check; how often it agrees with the choice that direct optimisation would make is in
// docs/lab/measurements.md.
#pragma once

#include <vector>

#include "runtime_eval/fit/function_check.h"

namespace nlg {

struct ChoiceOptions {
  double flat_ratio = 1.5;        // an error up to so many times that of the best larger representation is flat
  double enough_rmse = 0.004;     // … and so is any error below this, by direct optimisation
  double generator_excess = 2.5;  // errors of predicted theta are about so many times those of direct optimisation

  // The same choice on the errors of predicted theta, which have further to fall.
  ChoiceOptions forPredicted() const { return {flat_ratio, enough_rmse * generator_excess, 1.0}; }
};

// checks    of one function, one a representation, by rising number of parameters; at least one
// returns   the first that passes the check and is flat; else the largest that passes; else the first that is flat
int chooseRepresentation(const std::vector<FunctionCheck>& checks, const CheckOptions& check, const ChoiceOptions& options);

// Whether the first representation is chosen whatever errors the larger ones have: nobody needs to know these.
bool isSmallestEnough(const FunctionCheck& smallest, const CheckOptions& check, const ChoiceOptions& options);

}  // namespace nlg
