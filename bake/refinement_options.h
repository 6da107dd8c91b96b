// The settings of correction, check, refinement and choice: the same keys for the bake and for who measures what the bake would do.
#pragma once

#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/refinement.h"
#include "runtime_eval/fit/representation_choice.h"
#include "tool/options.h"

namespace nlg {

void describeCorrection(CorrectionOptions& options, OptionTable& table);
void describeRefinement(RefinementOptions& options, OptionTable& table);
void describeChoice(ChoiceOptions& options, OptionTable& table);

}  // namespace nlg
