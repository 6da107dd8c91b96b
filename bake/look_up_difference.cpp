#include "bake/look_up_difference.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

float weightOf(const ProbeWeights& weights, uint32_t probe) {
  const uint32_t* end = weights.probe + weights.count;
  const uint32_t* found = std::find(weights.probe, end, probe);
  return found == end ? 0.0f : weights.weight[found - weights.probe];
}

// Over the probes of either.
double largestDifference(const ProbeWeights& a, const ProbeWeights& b) {
  double largest = 0.0;
  for (int c = 0; c < a.count; ++c) largest = std::max(largest, std::abs(double{a.weight[c]} - weightOf(b, a.probe[c])));
  for (int c = 0; c < b.count; ++c) largest = std::max(largest, std::abs(double{b.weight[c]} - weightOf(a, b.probe[c])));
  return largest;
}

}  // namespace

std::vector<PositionM> lookUpPlaces(const ProbeTree& tree, uint64_t draws, uint64_t seed,
                                    const std::function<bool(const PositionM&)>& is_air) {
  std::vector<ProbeCell> cells;
  tree.forEachCell([&](const ProbeCell& cell) { cells.push_back(cell); });
  std::vector<PositionM> places;
  if (cells.empty()) return places;
  const ProbeTreeFrame& frame = tree.frame();
  Random random(seed);
  for (uint64_t i = 0; i < draws; ++i) {
    const ProbeCell& cell = cells[random.below(static_cast<uint32_t>(cells.size()))];
    PositionM position;
    for (int axis = 0; axis < 3; ++axis)
      position[axis] = frame.first_m[axis] + frame.spacing_m * (cell.low[axis] + cell.side * random.uniform(0.0, 1.0));
    if (is_air(position)) places.push_back(position);
  }
  return places;
}

LookUpDifference lookUpDifference(const LightGrid& a, const LightGrid& b, const std::vector<PositionM>& places) {
  LookUpDifference difference;
  for (const PositionM& position : places) {
    ProbeWeights of_a, of_b;
    // rounding may put a place just outside the last cell
    if (!lookUpWeights(a, position, &of_a) || !lookUpWeights(b, position, &of_b)) continue;
    const double largest = largestDifference(of_a, of_b);
    ++difference.look_ups;
    difference.changed += largest > 0.0;
    difference.largest = std::max(difference.largest, largest);
    difference.mean += largest;
  }
  if (difference.look_ups > 0) difference.mean /= static_cast<double>(difference.look_ups);
  return difference;
}

}  // namespace nlg
