// Chooses the representation of a function: the smallest whose error a larger one would hardly lower.
//
// The talk evaluates product fields of all resolutions and takes the point where their errors flatten. Here that is done over any
// representations, on the errors of the check; how often it agrees with the choice that direct optimisation would make is in
// docs/lab/measurements.md.
#pragma once

#include <vector>

#include "nlg/policy.h"

namespace nlg {

// checks    of one function, one a representation, by rising number of parameters; at least one
// returns   the first that passes the check and is flat; else the largest that passes; else the first that is flat
int chooseRepresentation(const std::vector<FunctionCheck>& checks, const CheckOptions& check, const ChoiceOptions& options);

// Whether the first representation is chosen whatever errors the larger ones have: nobody needs to know these.
bool isSmallestEnough(const FunctionCheck& smallest, const CheckOptions& check, const ChoiceOptions& options);

}  // namespace nlg
