// Straight walks through a small scene: how much weights and the lit result change from one step to the next.
#pragma once

#include "validate/solved/comparison.h"

namespace nlg {

// Over all pairs of neighbouring pixels of the slice that see each other, 1/16 of the spacing apart: every straight walk along its
// rows and columns is a chain of these.
struct WalkFigures {
  size_t step_count = 0;
  double weight_jump_p99 = 0.0, weight_jump_worst = 0.0;  // half the sum of |changes of w|: 0 to 1
  double light_jump_p99 = 0.0, light_jump_worst = 0.0;    // root mean square over signals, in shares of the lighting's own
};

// weights   N x 8, not normalised; the lit result is blended from the probes that are best for them, as judge() has it
WalkFigures walk(const SolvedScene& scene, const BlendWeights& weights);

// The same walks under the lighting itself: what a perfect grid would show. No weights, hence no jumps of them.
WalkFigures walkTrueLight(const SolvedScene& scene);

}  // namespace nlg
