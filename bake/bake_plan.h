// Estimates memory and time of a bake before it starts.
#pragma once

#include <string>
#include <vector>

#include "bake/prepared_scene.h"
#include "nlg/generator.h"

namespace nlg {

// Rough: mostly within a factor of two.
struct BakePlan {
  double memory_bytes = 0.0, seconds = 0.0;
};

// Takes half a second with generators: some probes' functions and theta are made to see what they take.
// generators   of the bake; none: light alone is made
// throws       UsageError on settings of light that cannot be used
BakePlan planBake(const PlacedScene& scene, const BakeOptions& options, const std::vector<Generator>& generators);

// A line; others where boxes with a spacing of their own lie outside, and where the spacing was chosen.
std::string toText(const BakePlan& plan, const PlacedScene& scene, const BakeOptions& options);

}  // namespace nlg
