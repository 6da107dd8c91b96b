// Variants of the rule that generates weighting functions, all on the same visibility, so that they can be compared.
//
// A point that the probe sees has the tent. In each pass every valid point without weight that sees a point with weight
// receives; `passes`, `sigma` and `falloff` mean what DiffusionOptions and docs/theory/math.md §1 say.
#pragma once

#include <limits>
#include <string>

#include "datagen/weighting/weighting_builder.h"
#include "validate/solved/blend.h"

namespace nlg {

enum class Baseline : uint8_t { none, bare_tent, visible_tent };

// What a point that receives makes of its lit neighbours.
enum class Carry : uint8_t {
  weight,  // their mean weight, times min(1, falloff * lit share)
  share,   // their mean share of the tent (weight / tent), times the same, times the tent here: ends where the support ends
  path,    // the tent here, times (straight distance to the probe / shortest way over lit neighbours)^path_power
};

struct DiffusionRule {
  std::string name;
  Baseline baseline = Baseline::none;
  Carry carry = Carry::weight;
  int passes = 2;
  double sigma = 0.1;
  double falloff = 2.0;  // infinity: none
  double path_power = 2.0;
};

// What a probe sees, and which links between the table's points are open: taken once, read by every rule.
struct ProbeView {
  bool free_space = false;     // then the rest is empty: all is seen
  std::vector<uint8_t> seen;   // by point of the link table
  std::vector<uint8_t> valid;  // by point
  std::vector<uint8_t> open;   // by entry of LinkTable::nearest: both ends valid, nothing between them
};

// Views of all probes of `points`; links must have been made with localPoints(points).
std::vector<ProbeView> viewProbes(const RayScene& rays, const LinkTable& links, const SamplePoints& points);

// The function of one probe at all points of the table.
std::vector<float> generate(const LinkTable& links, const ProbeView& view, const DiffusionRule& rule);

// The functions of all probes at the sample points, not normalised.
BlendWeights generateWeights(const LinkTable& links, const std::vector<ProbeView>& views, const SamplePoints& points,
                             const DiffusionRule& rule);

}  // namespace nlg
