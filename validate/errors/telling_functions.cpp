#include "validate/errors/telling_functions.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "validate/errors/slice.h"

namespace nlg {
namespace {

constexpr int kSlicePixels = 96;

nlohmann::ordered_json sliceJson(const TellingFunction& telling, const Slice& slice, double rmse, const FunctionSet& set) {
  const auto permille = [](const std::vector<float>& values) {
    std::vector<int> rounded;
    for (const float value : values) rounded.push_back(static_cast<int>(std::lround(1000.0f * std::clamp(value, -2.0f, 2.0f))));
    return rounded;
  };
  return {{"which", telling.which},
          {"function", telling.function},
          {"scene", set.scene_ids[set.scene_idx[telling.function]]},
          {"rmse", rmse},
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

std::vector<TellingFunction> tellingFunctions(const MeasuredWord& stored, const Populations& populations) {
  std::vector<MeasuredFunction> functions;
  for (const Population population : {Population::hard, Population::theta, Population::all}) {
    std::copy_if(stored.functions.begin(), stored.functions.end(), std::back_inserter(functions),
                 [&](const MeasuredFunction& one) { return populations.contains(Scope::set, population, one.function); });
    if (!functions.empty()) break;
  }
  std::stable_sort(functions.begin(), functions.end(),
                   [](const MeasuredFunction& a, const MeasuredFunction& b) { return a.error.rmse < b.error.rmse; });
  const auto at = [&](double share) {
    return functions[static_cast<size_t>(share * static_cast<double>(functions.size() - 1))].function;
  };
  return {{"best", at(0.0)}, {"median", at(0.5)}, {"p95", at(0.95)}, {"worst", at(1.0)}};
}

void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, nlohmann::ordered_json* slices) {
  const MeasuredWord& stored = words.at(ThetaWord::stored);
  for (const TellingFunction& telling : tellingFunctions(stored, populations)) {
    const MadeTheta& made = words.made[telling.function];
    const Slice slice = made.isBareTent()
                            ? makeSlice(set, telling.function, Representation::tentMlp(), bareTentTheta().data(), kSlicePixels)
                            : makeSlice(set, telling.function, representation, made.theta.data(), kSlicePixels);
    nlohmann::ordered_json entry = sliceJson(telling, slice, stored.functions[telling.function].error.rmse, set);
    entry["representation"] = representationName(representation);
    slices->push_back(entry);
  }
}

}  // namespace nlg
