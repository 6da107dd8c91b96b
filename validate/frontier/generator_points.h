// Points of one generator that no fit follows: alone, corrected, in fewer bits, on fewer coefficients, on more threads.
#pragma once

#include <memory>

#include "validate/frontier/generator_run.h"

namespace nlg {

// Families generator, corrected, coefficients, precision, theta_precision, threads.
// generator      made of data
// correction     of every point but those of family corrected that say otherwise
// coefficients   1 <= each <= the basis's K; empty: 32, 64, 128, … below K, and K
std::vector<PlotPoint> generatorPoints(const GeneratorData& data, const std::shared_ptr<const Generator>& generator,
                                       const CorrectionOptions& correction, const std::vector<int>& coefficients);

// The same generator that sees only the `kept` coefficients of largest deviation: the others are 0, their mean over the training
// set. What each coefficient carries in a generator that was trained with all of them, not what one trained with fewer would do.
GeneratorData keepCoefficients(GeneratorData data, int kept);

}  // namespace nlg
