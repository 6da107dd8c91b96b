#include "validate/generators/populations.h"

#include <algorithm>

#include "tool/parallel_for.h"

namespace nlg {

const char* populationName(Population population) {
  constexpr const char* kNames[kPopulationCount] = {"all", "theta", "hard"};
  return kNames[static_cast<size_t>(population)];
}

Populations::Populations(const FunctionSet& set, const ValidateOptions& options)
    : set_(set), takes_theta_(set.functionCount()), hard_(set.functionCount()), sampled_(set.functionCount()) {
  std::vector<FunctionChecker> checkers(options.threadCount());
  parallelFor(set.functionCount(), options.threadCount(), [&](uint64_t i, int thread) {
    const FunctionCheck tent = checkers[thread].checkBareTent(storedFunction(set, i), options.policy.check());
    takes_theta_[i] = !takesBareTent(tent, options.policy);
    hard_[i] = tent.rmse >= options.hard_tent_rmse;
  });
  std::vector<uint64_t> with_theta;
  for (uint64_t i = 0; i < set.functionCount(); ++i) {
    if (takes_theta_[i]) with_theta.push_back(i);
  }
  sample_ = chooseFrom(with_theta, static_cast<uint64_t>(options.direct_functions));
  for (const uint64_t function : sample_) sampled_[function] = 1;
}

bool Populations::contains(Scope scope, Population population, uint64_t function) const {
  if (scope == Scope::sample && !sampled_[function]) return false;
  switch (population) {
    case Population::theta:
      return takes_theta_[function];
    case Population::hard:
      return hard_[function];
    default:
      return true;
  }
}

uint64_t Populations::count(Scope scope, Population population) const {
  uint64_t count = 0;
  for (uint64_t i = 0; i < takes_theta_.size(); ++i) count += contains(scope, population, i);
  return count;
}

std::vector<uint64_t> Populations::chooseFrom(const std::vector<uint64_t>& functions, uint64_t wanted) const {
  std::vector<uint32_t> scene_idx;
  for (const uint64_t function : functions) scene_idx.push_back(set_.scene_idx[function]);
  std::vector<uint64_t> chosen = chooseEvenly(scene_idx, set_.scene_ids.size(), wanted);
  for (uint64_t& function : chosen) function = functions[function];
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::vector<uint64_t> chooseEvenly(const std::vector<uint32_t>& scene_idx, size_t scene_count, uint64_t wanted) {
  std::vector<std::vector<uint64_t>> of_scene(scene_count);
  for (uint64_t i = 0; i < scene_idx.size(); ++i) of_scene[scene_idx[i]].push_back(i);
  // one more of every scene that has more, until there are enough
  std::vector<uint64_t> share(scene_count, 0);
  uint64_t total = 0;
  wanted = std::min<uint64_t>(wanted, scene_idx.size());
  while (total < wanted) {
    for (size_t s = 0; s < scene_count && total < wanted; ++s) {
      if (share[s] < of_scene[s].size()) ++share[s], ++total;
    }
  }
  std::vector<uint64_t> chosen;
  for (uint64_t turn = 0; chosen.size() < wanted; ++turn) {
    for (size_t s = 0; s < scene_count; ++s) {
      if (turn < share[s]) chosen.push_back(of_scene[s][turn * of_scene[s].size() / share[s]]);
    }
  }
  return chosen;
}

}  // namespace nlg
