// Points of the policy: after every stage of a representation's list, and with settings of its own one at a time.
#pragma once

#include "validate/frontier/policy_run.h"

namespace nlg {

// Family stages: after each stage of the list, and theta rounded to int8, as a bake stores it, after the last. The last point of a
// word is named by it: network, corrected, fitted, stored. Families learned_steps, mirror_images and lm: so many of them at most,
// and no stage after them. Families precision and coefficients: the network alone.
// generator      made of data
// coefficients   1 <= each <= the basis's K; empty: 32, 128, 512, … below K
std::vector<PlotRun> generatorPoints(const GeneratorData& data, const std::shared_ptr<const Generator>& generator,
                                     const PolicyOptions& options, const std::vector<int>& coefficients);

// Family choice: the policy over several generators, all of it.
// generators   at least two, by rising number of parameters
PlotRun choicePoint(const SharedGenerators& generators, const PolicyOptions& options);

// The same generator that sees only the `kept` coefficients of largest deviation: the others are 0, their mean over the training
// set. What each coefficient carries in a generator that was trained with all of them, not what one trained with fewer would do.
GeneratorData keepCoefficients(GeneratorData data, int kept);

}  // namespace nlg
