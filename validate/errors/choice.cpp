#include "validate/errors/choice.h"

#include <map>

#include "validate/errors/policy_run.h"

namespace nlg {

nlohmann::ordered_json choiceJson(const std::vector<ChoiceColumn>& columns, const FunctionSet& set,
                                  const Populations& populations, const ValidateOptions& options) {
  std::vector<const Generator*> generators;
  for (const ChoiceColumn& column : columns) generators.push_back(column.generator);
  std::vector<StoredFunction> functions;
  for (const uint64_t function : populations.sample()) functions.push_back(storedFunction(set, function));
  const std::vector<MadeTheta> made = runPolicy(generators, functions, options.policy, {options.threadCount()});

  const size_t count = functions.size();
  const double share = count > 0 ? 1.0 / static_cast<double>(count) : 0.0;
  double agree = 0.0, smaller = 0.0, larger = 0.0;
  double floats[2] = {}, rmse[2] = {};  // by the bake's choice, and by direct optimisation's
  std::map<std::pair<size_t, size_t>, uint64_t> pairs;
  const auto nameOf = [&](size_t column) { return std::string(representationName(generators[column]->representation())); };
  for (size_t i = 0; i < count; ++i) {
    std::vector<FunctionCheck> direct;
    for (const ChoiceColumn& column : columns) direct.push_back(column.direct[i]);
    const size_t chosen[2] = {made[i].generator,
                              static_cast<size_t>(chooseRepresentation(direct, options.policy.check(), options.policy.choice))};
    (chosen[0] == chosen[1] ? agree : chosen[0] < chosen[1] ? smaller : larger) += share;
    ++pairs[{chosen[0], chosen[1]}];
    for (int who = 0; who < 2; ++who) {
      floats[who] += share * generators[chosen[who]]->representation().thetaCount();
      rmse[who] += share * direct[chosen[who]].rmse;
    }
  }
  nlohmann::ordered_json counts;
  for (const auto& [pair, number] : pairs) counts[nameOf(pair.first) + " → " + nameOf(pair.second)] = number;
  return {{"functions", count},
          {"agree", agree},
          {"generator_smaller", smaller},
          {"generator_larger", larger},
          {"counts", counts},
          {"floats", {{"generator", floats[0]}, {"direct", floats[1]}}},
          {"rmse_direct", {{"generator", rmse[0]}, {"direct", rmse[1]}}}};
}

}  // namespace nlg
