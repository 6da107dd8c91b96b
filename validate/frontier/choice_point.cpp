#include "validate/frontier/choice_point.h"

#include <algorithm>

#include "validate/frontier/stopwatch.h"

namespace nlg {
namespace {

struct Candidates {
  std::vector<FittedFunction> functions;
  std::vector<FunctionCheck> checks;
};

struct ChoicePoint {
  std::vector<std::shared_ptr<GeneratorRun>> runs;
  double correct_rmse;
  CheckOptions check;
  ChoiceOptions choice;
  std::shared_ptr<FunctionChecker> checker = std::make_shared<FunctionChecker>();

  std::vector<FittedFunction> operator()(const FunctionBlock& block) const {
    const Stopwatch watch;
    std::vector<Candidates> candidates;
    for (const auto& run : runs) candidates.push_back(candidatesOf(*run, block));
    std::vector<FittedFunction> chosen;
    std::vector<FunctionCheck> checks(runs.size());
    for (size_t i = 0; i < block.functions.size(); ++i) {
      for (size_t g = 0; g < runs.size(); ++g) checks[g] = candidates[g].checks[i];
      const int g = chooseRepresentation(checks, check, choice.forGenerated());
      chosen.push_back(std::move(candidates[static_cast<size_t>(g)].functions[i]));
    }
    const double elapsed_us = watch.elapsedUs() / block.count();
    for (FittedFunction& function : chosen) function.elapsed_us = elapsed_us;
    return chosen;
  }

  // One generator on the whole block: checked, and corrected where that is needed and does not fail the check.
  Candidates candidatesOf(GeneratorRun& run, const FunctionBlock& block) const {
    Candidates all{run.generate(block), {}};
    const auto checkOf = [&](size_t i, const float* theta) {
      return checker->check(run.representation(), block.stored[i], theta, check);
    };
    std::vector<size_t> wrong;
    std::vector<StoredFunction> wrong_stored;
    std::vector<float> wrong_theta;
    for (size_t i = 0; i < all.functions.size(); ++i) {
      const Theta& theta = all.functions[i].theta;
      all.checks.push_back(checkOf(i, theta.data()));
      if (all.checks[i].rmse <= correct_rmse && all.checks[i].passes(check)) continue;
      wrong.push_back(i);
      wrong_stored.push_back(block.stored[i]);
      wrong_theta.insert(wrong_theta.end(), theta.begin(), theta.end());
    }
    if (wrong.empty() || run.corrector().empty()) return all;
    run.corrector().correct(wrong_stored.data(), static_cast<int>(wrong.size()), wrong_theta.data());
    const auto D = static_cast<size_t>(run.representation().thetaCount());
    for (size_t n = 0; n < wrong.size(); ++n) {
      const FunctionCheck corrected = checkOf(wrong[n], &wrong_theta[n * D]);
      if (all.checks[wrong[n]].passes(check) && !corrected.passes(check)) continue;
      all.checks[wrong[n]] = corrected;
      std::copy_n(&wrong_theta[n * D], D, all.functions[wrong[n]].theta.begin());
    }
    return all;
  }
};

}  // namespace

PlotPoint choicePoint(const std::vector<std::shared_ptr<const Generator>>& generators, const CorrectionOptions& correction,
                      const CheckOptions& check, const ChoiceOptions& choice) {
  CorrectionOptions of_all = correction;  // who is corrected is decided by the check
  of_all.correct_rmse = 0.0;
  std::string names;
  std::vector<std::shared_ptr<GeneratorRun>> runs;
  for (const auto& generator : generators) {
    runs.push_back(std::make_shared<GeneratorRun>(generator, of_all));
    names += (names.empty() ? "" : "+") + std::string(representationName(generator->representation()));
  }
  return {names, "choice", {}, "automatic choice", true, ChoicePoint{runs, correction.correct_rmse, check, choice}};
}

}  // namespace nlg
