#include "validate/frontier/generator_points.h"

namespace nlg {
namespace {

// timed   a TimedNetwork or a TimedPolicy
template <class Timed>
PlotRun runOf(PlotPoint point, const std::shared_ptr<Timed>& timed) {
  return {{std::move(point)}, [timed](const FunctionBlock& block) { return FittedFunctions{timed->run(block)}; }};
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

}  // namespace

std::vector<PlotRun> stagePoints(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options) {
  std::vector<PlotRun> runs;
  const std::string name = representationName(generator->representation());
  const std::vector<StagePlan> plan = stagesOf(stageFacts(*generator), options);
  for (size_t n = 0; n < plan.size(); ++n) {
    const ThetaStage stage = plan[n].stage;
    const PlotPoint point{name, "stages", {}, stageTitle(stage), wordsAfter(plan, n)};
    runs.push_back(stage == ThetaStage::network
                       ? runOf(point, std::make_shared<TimedNetwork>(generator))
                       : runOf(point, std::make_shared<TimedPolicy>(SharedGenerators{generator}, options, stage)));
  }
  const auto last = std::make_shared<TimedPolicy>(SharedGenerators{generator}, options, ThetaStage::rounding);
  const PlotPoint rounded{name, "stages", 8, "rounding to int8", {ThetaWord::stored}};
  runs.push_back({{rounded}, [last](const FunctionBlock& block) { return FittedFunctions{last->runAndRound(block)}; }});
  return runs;
}

PlotRun choicePoint(const SharedGenerators& generators, const PolicyOptions& options) {
  std::string names;
  for (const auto& generator : generators) {
    names += (names.empty() ? "" : "+") + std::string(representationName(generator->representation()));
  }
  return runOf({names, "choice", {}, "automatic choice", {}},
               std::make_shared<TimedPolicy>(generators, options, ThetaStage::rounding));
}

}  // namespace nlg
