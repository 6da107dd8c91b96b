// Points of the policy: after every stage of a representation's list, and over several generators.
#pragma once

#include "validate/frontier/timed_policy.h"

namespace nlg {

// Family stages: after each stage of the list, and theta rounded to int8, as a bake stores it, after the last. The last point of a
// word is named by it: network, corrected, fitted, stored.
std::vector<PlotRun> stagePoints(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options);

// Family choice: the policy over several generators, all of it.
// generators   at least two, by rising number of parameters
PlotRun choicePoint(const SharedGenerators& generators, const PolicyOptions& options);

}  // namespace nlg
