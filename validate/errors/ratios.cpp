#include "validate/errors/ratios.h"

namespace nlg {
namespace {

// One figure: which error, of which functions.
struct Ratio {
  const char* name;
  Population population;
  double FunctionError::*error;
  bool needs_occluded;
};

constexpr Ratio kRatios[] = {
    {"median", Population::theta, &FunctionError::blend_rmse, false},
    {"median_hard", Population::hard, &FunctionError::blend_rmse, false},
    {"median_rmse", Population::theta, &FunctionError::rmse, false},
    {"median_test_points", Population::theta, &FunctionError::rmse_test_points, false},
    {"median_occluded_hard", Population::hard, &FunctionError::rmse_occluded, true},
};

}  // namespace

nlohmann::ordered_json ratiosJson(const MeasuredWord& word, const MeasuredWord& reference, const FigureContext& context,
                                  const std::function<bool(uint64_t function)>& counts) {
  nlohmann::ordered_json json;
  for (const Ratio& ratio : kRatios) {
    ValuesByScene ratios;
    size_t at = 0;  // in the word's functions, which rise as the reference's do
    for (const MeasuredFunction& one : reference.functions) {
      while (word.functions[at].function != one.function) ++at;
      const FunctionError &above = word.functions[at].error, &below = one.error;
      if (!counts(one.function) || !context.populations.contains(Scope::sample, ratio.population, one.function)) continue;
      if (ratio.needs_occluded && !below.has_occluded) continue;
      if (!(below.*ratio.error > 0.0)) continue;
      ratios.add(above.*ratio.error / (below.*ratio.error), context.set.scene_idx[one.function]);
    }
    const SceneBootstrap bootstrap(ratios.scenes, context.bootstrap);
    json[ratio.name] = intervalJson(bootstrap.quantiles(ratios.values, {0.5}).front());
  }
  return json;
}

}  // namespace nlg
