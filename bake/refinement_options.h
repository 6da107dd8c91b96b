// The settings of check and refinement: the same keys for the bake and for who measures what the bake would do.
#pragma once

#include "runtime_eval/fit/refinement.h"
#include "tool/options.h"

namespace nlg {

void describeRefinement(RefinementOptions& options, OptionTable& table);

}  // namespace nlg
