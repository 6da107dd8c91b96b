#include "validate/frontier/frontier_options.h"

#include <charconv>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kLargestStepCount = 1000000;

std::vector<int> risingNumbers(const std::string& flag, const std::vector<std::string>& texts) {
  std::vector<int> numbers;
  for (const std::string& text : texts) {
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool is_number = error == std::errc() && end == text.data() + text.size();
    if (!is_number || number > kLargestStepCount || number <= (numbers.empty() ? 0 : numbers.back())) {
      throw UsageError(flag, "rising whole numbers from 1 to " + std::to_string(kLargestStepCount), "'" + text + "'");
    }
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

FitBudgets FrontierOptions::budgets() const {
  return {risingNumbers("--corrected-lm-steps", lm_steps), risingNumbers("--corrected-adam-steps", adam_steps),
          risingNumbers("--direct-lm-steps", direct_lm_steps), risingNumbers("--direct-adam-steps", direct_adam_steps)};
}

void describe(FrontierOptions& o, OptionTable& table) {
  table.group("Measurement");
  table.add("functions", &o.functions,
            "number of held-out functions that take a theta, evenly over scenes, on which all points run", 1, 1000000);
  table.add("hard_tent_rmse", &o.hard_tent_rmse, "RMSE of the bare tent from which a function counts as hard", 0.0, 1.0);
  table.add("repeats", &o.interleave.repeats, "timed runs of a short point per block", 1, 10000);
  table.add("repeat_seconds", &o.interleave.repeat_seconds,
            "time of a point's first block, seconds, above which the point runs only once", 0.0, 1e6);
  table.add("corrected_lm_steps", &o.lm_steps, "budgets of LM steps from the corrected theta");
  table.add("corrected_adam_steps", &o.adam_steps,
            "budgets of Adam steps from the corrected theta; product fields and codes take 1/32 as many");
  table.add("direct_lm_steps", &o.direct_lm_steps, "budgets of LM steps from theta0");
  table.add("direct_adam_steps", &o.direct_adam_steps,
            "budgets of Adam steps from theta0 and from random starts; product fields and codes take 1/32 as many");
  table.add("bootstrap_draws", &o.bootstrap_draws,
            "bootstrap draws of scenes and functions for the interval of the speed at equal error", 1, 1000000);
  table.add("seed", &o.seed, "seed of random starts and draws");
}

}  // namespace nlg
