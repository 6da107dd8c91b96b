#include "validate/frontier/generator_points.h"

#include <algorithm>
#include <numeric>

#include "tool/error.h"

namespace nlg {
namespace {

std::vector<int> defaultCoefficients(int all) {
  std::vector<int> counts;
  for (int count = 32; count < all; count *= 4) counts.push_back(count);
  return counts;
}

PlotRun runOf(PlotPoint point, const std::shared_ptr<NetworkRun>& network) {
  return {{std::move(point)}, [network](const FunctionBlock& block) { return FittedFunctions{network->run(block)}; }};
}

PlotRun runOf(PlotPoint point, const std::shared_ptr<PolicyRun>& policy) {
  return {{std::move(point)}, [policy](const FunctionBlock& block) { return FittedFunctions{policy->run(block)}; }};
}

// What theta is called after a stage of the list: each word that no later stage has; stored only once it is rounded.
std::vector<ThetaWord> wordsAfter(const std::vector<StagePlan>& plan, size_t at) {
  const auto wordOfPlace = [&](size_t n) { return n == plan.size() ? ThetaWord::stored : wordOf(plan[n].stage); };
  std::vector<ThetaWord> words;
  for (auto word = static_cast<int>(wordOfPlace(at)); word < static_cast<int>(wordOfPlace(at + 1)); ++word) {
    words.push_back(static_cast<ThetaWord>(word));
  }
  return words;
}

void addStages(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options, std::vector<PlotRun>& runs) {
  const std::string name = representationName(generator->representation());
  const std::vector<StagePlan> plan = stagesOf(stageFacts(*generator), options);
  for (size_t n = 0; n < plan.size(); ++n) {
    const ThetaStage stage = plan[n].stage;
    const PlotPoint point{name, "stages", {}, stageTitle(stage), wordsAfter(plan, n)};
    if (stage == ThetaStage::network) {
      runs.push_back(runOf(point, std::make_shared<NetworkRun>(generator)));
      continue;
    }
    const auto run = std::make_shared<PolicyRun>(SharedGenerators{generator}, options, stage);
    runs.push_back(runOf(point, run));
  }
  const auto last = std::make_shared<PolicyRun>(SharedGenerators{generator}, options, ThetaStage::rounding);
  const PlotPoint rounded{name, "stages", 8, "rounding to int8", {ThetaWord::stored}};
  runs.push_back({{rounded}, [last](const FunctionBlock& block) { return FittedFunctions{last->runAndRound(block)}; }});
}

// A setting at other values than its own, the stage that it belongs to being the last one.
struct Setting {
  int StageOptions::*value;
  ThetaStage stage;
  std::vector<int> budgets;
};

void addSettings(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options, std::vector<PlotRun>& runs) {
  const Setting settings[] = {{&StageOptions::learned_steps, ThetaStage::learned_steps, {1, 3, 8}},
                              {&StageOptions::mirror_images, ThetaStage::mirror_images, {2, 8}},
                              {&StageOptions::lm_iterations, ThetaStage::lm, {1, 4, 16}}};
  const StageFacts facts = stageFacts(*generator);
  for (const Setting& setting : settings) {
    for (const int budget : setting.budgets) {
      if (budget == options.stages.*setting.value) continue;
      PolicyOptions changed = options;
      changed.stages.*setting.value = budget;
      const std::vector<StagePlan> plan = stagesOf(facts, changed);
      const bool runs_so = std::any_of(plan.begin(), plan.end(), [&](const StagePlan& stage) {
        return stage.stage == setting.stage && stage.budget == budget;
      });
      if (!runs_so) continue;
      runs.push_back(runOf({representationName(generator->representation()),
                            stageName(setting.stage),
                            budget,
                            std::string(stageTitle(setting.stage)) + ", " + std::to_string(budget) + " at most",
                            {}},
                           std::make_shared<PolicyRun>(SharedGenerators{generator}, changed, setting.stage)));
    }
  }
}

}  // namespace

GeneratorData keepCoefficients(GeneratorData data, int kept) {
  const std::vector<float>& deviation = data.basis.deviation;
  NLG_CHECK(kept, <=, data.basis.coefficientCount());
  std::vector<int> order(deviation.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return deviation[a] > deviation[b]; });
  for (size_t i = static_cast<size_t>(kept); i < order.size(); ++i) {
    std::fill_n(data.basis.components.begin() + static_cast<std::ptrdiff_t>(order[i]) * kOctantPointCount, kOctantPointCount,
                0.0f);
  }
  return data;
}

std::vector<PlotRun> generatorPoints(const GeneratorData& data, const std::shared_ptr<const Generator>& generator,
                                     const PolicyOptions& options, const std::vector<int>& coefficients) {
  std::vector<PlotRun> runs;
  addStages(generator, options, runs);
  addSettings(generator, options, runs);
  const std::string name = representationName(data.representation);
  const auto networkOf = [](auto&&... settings) {
    return std::make_shared<NetworkRun>(std::make_shared<const Generator>(settings...));
  };
  runs.push_back(runOf({name, "precision", 16, "network, int16", {}}, networkOf(data, GeneratorPrecision::int16)));
  const int all = data.basis.coefficientCount();
  for (const int kept : coefficients.empty() ? defaultCoefficients(all) : coefficients) {
    const std::string label = "network, " + std::to_string(kept) + " of " + std::to_string(all) + " coefficients";
    runs.push_back(runOf({name, "coefficients", kept, label, {}}, networkOf(keepCoefficients(data, kept))));
  }
  return runs;
}

PlotRun choicePoint(const SharedGenerators& generators, const PolicyOptions& options) {
  std::string names;
  for (const auto& generator : generators) {
    names += (names.empty() ? "" : "+") + std::string(representationName(generator->representation()));
  }
  return runOf({names, "choice", {}, "automatic choice", {}},
               std::make_shared<PolicyRun>(generators, options, ThetaStage::rounding));
}

}  // namespace nlg
