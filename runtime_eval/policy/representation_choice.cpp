#include "runtime_eval/policy/representation_choice.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

// An error that is not finite is never flat, and is no reason against a smaller representation.
bool isFlat(const std::vector<FunctionCheck>& checks, size_t index, const ChoiceOptions& options) {
  const double rmse = checks[index].blend_rmse;
  if (!std::isfinite(rmse)) return false;
  if (rmse <= options.choice_enough_rmse) return true;
  return std::all_of(checks.begin() + static_cast<ptrdiff_t>(index) + 1, checks.end(), [&](const FunctionCheck& larger) {
    return !std::isfinite(larger.rmse) || rmse <= options.choice_flat_ratio * larger.blend_rmse;
  });
}

}  // namespace

int chooseRepresentation(const std::vector<FunctionCheck>& checks, const CheckOptions& check, const ChoiceOptions& options) {
  int first_flat = -1, last_passing = -1;
  for (size_t i = 0; i < checks.size(); ++i) {
    const bool passes = checks[i].passes(check);
    if (passes) last_passing = static_cast<int>(i);
    if (!isFlat(checks, i, options)) continue;
    if (passes) return static_cast<int>(i);
    if (first_flat < 0) first_flat = static_cast<int>(i);
  }
  // a theta that passes is never given up for one that fails
  return last_passing >= 0 ? last_passing : std::max(first_flat, 0);
}

bool isSmallestEnough(const FunctionCheck& smallest, const CheckOptions& check, const ChoiceOptions& options) {
  return smallest.blend_rmse <= options.choice_enough_rmse && smallest.passes(check);
}

}  // namespace nlg
