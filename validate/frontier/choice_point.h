// The automatic choice between product fields, as a bake with several generators makes it.
#pragma once

#include <memory>

#include "runtime_eval/fit/representation_choice.h"
#include "validate/frontier/generator_run.h"

namespace nlg {

// Family choice: every generator on every function, a check of each result, corrections for those above correction.correct_rmse or
// failing the check, and of each function the theta that chooseRepresentation takes. The time holds all of it.
// generators   at least two product fields, by rising number of parameters
PlotPoint choicePoint(const std::vector<std::shared_ptr<const Generator>>& generators, const CorrectionOptions& correction,
                      const CheckOptions& check, const ChoiceOptions& choice);

}  // namespace nlg
