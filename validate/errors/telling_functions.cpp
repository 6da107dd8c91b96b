#include "validate/errors/telling_functions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>

#include "validate/errors/slice.h"

namespace nlg {
namespace {

constexpr int kSlicePixels = 96;

nlohmann::ordered_json sliceJson(const TellingFunction& telling, const Slice& slice, const FunctionError& error,
                                 const FunctionSet& set) {
  const auto permille = [](const std::vector<float>& values) {
    std::vector<int> rounded;
    for (const float value : values) rounded.push_back(static_cast<int>(std::lround(1000.0f * std::clamp(value, -2.0f, 2.0f))));
    return rounded;
  };
  return {{"which", telling.which},
          {"function", telling.function},
          {"scene", set.scene_ids[set.scene_idx[telling.function]]},
          {"blend_rmse", error.blend_rmse},
          {"rmse", error.rmse},
          {"axis", slice.axis},
          {"size", slice.size},
          {"valid", slice.valid},
          {"seen", slice.seen},
          {"target_permille", permille(slice.target)},
          {"stored_permille", permille(slice.stored)},
          {"difference_permille", permille(slice.difference)}};
}

// The tent times a network that says 1.
Theta bareTentTheta() {
  Theta theta(Representation::tentMlp().thetaCount(), 0.0f);
  theta[ThetaLayout::b3] = 1.0f;
  return theta;
}

}  // namespace

std::vector<TellingFunction> tellingFunctions(const MeasuredWord& stored, const FunctionSet& set,
                                              const Populations& populations) {
  std::vector<MeasuredFunction> functions;
  for (const Population population : {Population::hard, Population::theta, Population::all}) {
    std::copy_if(stored.functions.begin(), stored.functions.end(), std::back_inserter(functions),
                 [&](const MeasuredFunction& one) { return populations.contains(Scope::set, population, one.function); });
    if (!functions.empty()) break;
  }
  std::stable_sort(functions.begin(), functions.end(),
                   [](const MeasuredFunction& a, const MeasuredFunction& b) { return a.error.blend_rmse < b.error.blend_rmse; });
  const auto validCount = [&](const MeasuredFunction& one) {
    const uint8_t* const validity = functionAt(set, one.function).validity;
    return std::accumulate(validity, validity + set.point_count / 8, 0,
                           [](int sum, uint8_t bits) { return sum + std::popcount(bits); });
  };
  const auto near = [&](double share) {
    const size_t count = functions.size(), reach = count / 200;
    const auto rank = static_cast<size_t>(share * static_cast<double>(count - 1));
    const auto first = functions.begin() + static_cast<std::ptrdiff_t>(rank - std::min(rank, reach));
    const auto end = functions.begin() + static_cast<std::ptrdiff_t>(std::min(rank + reach + 1, count));
    return std::max_element(first, end, [&](const auto& a, const auto& b) { return validCount(a) < validCount(b); })->function;
  };
  return {{"p5", near(0.05)}, {"median", near(0.5)}, {"p95", near(0.95)}, {"worst", functions.back().function}};
}

void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, nlohmann::ordered_json* slices) {
  const MeasuredWord& stored = words.at(ThetaWord::stored);
  for (const TellingFunction& telling : tellingFunctions(stored, set, populations)) {
    const MadeTheta& made = words.made[telling.function];
    const Slice slice = made.isBareTent()
                            ? makeSlice(set, telling.function, Representation::tentMlp(), bareTentTheta().data(), kSlicePixels)
                            : makeSlice(set, telling.function, representation, made.theta.data(), kSlicePixels);
    nlohmann::ordered_json entry = sliceJson(telling, slice, stored.functions[telling.function].error, set);
    entry["representation"] = representationName(representation);
    slices->push_back(entry);
  }
}

}  // namespace nlg
