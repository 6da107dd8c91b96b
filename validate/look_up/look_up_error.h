// How far the shares that a look-up blends are from those that target φ gives, at places in air.
//
// A share is a weight over the sum of the 8, times the blend's certainty. What shares lack of 1 lights nothing, and counts as a
// share of its own, so that all light lost is an error of 1.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "light/methods/true_weights.h"
#include "runtime_eval/light_grid/light_grid.h"
#include "validate/look_up/places.h"

namespace nlg {

// Shares of the 8 corners, which add up to 1 or less; all 0 where no probe has weight.
struct Blend {
  std::array<double, kCornerCount> share{};
  bool is_lit = false;
};

// Weights below kLeastWeight count as none, as in the look-up.
Blend blendOf(const CornerWeights& weights);

// A look-up in the scene's coordinates; false where it is outside.
using LookUp = std::function<bool(const glm::dvec3& position_m, ProbeWeights* weights)>;

// What lookUpWeights gives, at positions relative to the origin. The grid must outlive it.
LookUp lookUpOf(const LightGrid& grid, const glm::dvec3& origin_m);

// By place. Weights of a probe that is no corner of the place's cell are refused by NLG_CHECK.
std::vector<Blend> blendsOf(const LookUp& look_up, const std::vector<Place>& places, const std::vector<TrueWeights>& truth);

// Over places; those of a class, or all with each class counted as often as it is met in air.
struct LookUpFigures {
  uint64_t places = 0;
  double unlit = 0.0;                        // share of places that the blend gives no weight
  double unlit_target = 0.0;                 // … that target φ gives none: in no figure of differences from it
  double seen_by_none = 0.0;                 // … that no probe around sees: in no figure of differences from the seen tents
  double rmse = 0.0;                         // of a probe's share from target φ's, over 8 probes a place
  double wrong_mean = 0.0, wrong_p99 = 0.0;  // Σ |difference from target φ's shares| / 2: the light that comes from wrong probes
  double wrong_to_seen = 0.0;                // the mean of the same, from the tents of those probes that see the place
  double leak_mean = 0.0, leak_p99 = 0.0;    // share of probes that do not see the place; over places with weight
};

struct LookUpFiguresByDistance {
  LookUpFigures all;
  std::array<LookUpFigures, kDistanceClassCount> by_class;
};

LookUpFiguresByDistance figuresOf(const std::vector<Blend>& blends, const Places& places, const std::vector<TrueWeights>& truth);

// Target φ's own shares, as if a look-up gave them: how much even those leak, and how far they are from the seen tents.
std::vector<Blend> targetBlends(const std::vector<TrueWeights>& truth);

// What changes through the faces of cells, along segments of 2^-19 of a cell's side that meet nothing.
struct JumpFigures {
  uint64_t segments = 0;                        // between cells of one size, in air: those that are measured
  uint64_t hanging = 0;                         // between cells of two sizes: other probes on either side, not compared
  double mean = 0.0, p99 = 0.0, largest = 0.0;  // half the sum of |differences of shares|; with weight on one side only: 1
};

// One segment a place: through a face of its cell, drawn at random, over against the place.
JumpFigures measureJumps(const std::vector<Place>& places, const ProbeTree& tree, const RayScene& rays, const LookUp& look_up,
                         uint64_t seed);

// What functions say on the six faces of their supports, where the tent is 0. A look-up that did not bound them by the tent would see
// just this appear there. Clamped to [0, 1]; 96 points a function, in solid or not.
struct BorderFigures {
  uint64_t functions = 0;
  double mean = 0.0, p99 = 0.0, largest = 0.0;
};
BorderFigures measureBorder(const LightGrid& grid);

}  // namespace nlg
