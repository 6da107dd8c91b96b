#include "validate/errors/choice.h"

#include <map>

namespace nlg {
namespace {

// What the bake's check would have said.
FunctionCheck checkOf(const FunctionError& error, const CheckOptions& options) {
  FunctionCheck check;
  check.rmse = error.rmse;
  check.leak_mean = error.leak_mean;
  check.leak_share = error.leak_p99 > options.tau_leak ? 1.0 : 0.0;
  return check;
}

}  // namespace

nlohmann::ordered_json choiceJson(const std::vector<ChoiceColumn>& columns, const CheckOptions& check,
                                  const ChoiceOptions& options) {
  const size_t count = columns.front().generated.size();
  const double share = count > 0 ? 1.0 / static_cast<double>(count) : 0.0;
  double agree = 0.0, smaller = 0.0, larger = 0.0;
  double floats[2] = {}, rmse[2] = {};  // by the generator's choice, and by direct optimisation's
  std::map<std::pair<size_t, size_t>, uint64_t> pairs;
  for (size_t i = 0; i < count; ++i) {
    std::vector<FunctionCheck> generated, direct;
    for (const ChoiceColumn& column : columns) {
      generated.push_back(checkOf(column.generated[i], check));
      direct.push_back(checkOf(column.direct[i], check));
    }
    const size_t chosen[2] = {static_cast<size_t>(chooseRepresentation(generated, check, options.forGenerated())),
                              static_cast<size_t>(chooseRepresentation(direct, check, options))};
    (chosen[0] == chosen[1] ? agree : chosen[0] < chosen[1] ? smaller : larger) += share;
    ++pairs[{chosen[0], chosen[1]}];
    for (int who = 0; who < 2; ++who) {
      floats[who] += share * columns[chosen[who]].theta_count;
      rmse[who] += share * direct[chosen[who]].rmse;
    }
  }
  nlohmann::ordered_json counts;
  for (const auto& [pair, functions] : pairs) counts[columns[pair.first].name + " → " + columns[pair.second].name] = functions;
  return {{"functions", count},
          {"agree", agree},
          {"generator_smaller", smaller},
          {"generator_larger", larger},
          {"counts", counts},
          {"floats", {{"generator", floats[0]}, {"direct", floats[1]}}},
          {"rmse_direct", {{"generator", rmse[0]}, {"direct", rmse[1]}}}};
}

}  // namespace nlg
