#include "validate/frontier/chosen_functions.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/projection.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Every so-many-th of a list.
std::vector<uint64_t> spread(const std::vector<uint64_t>& list, uint64_t wanted) {
  std::vector<uint64_t> some;
  for (uint64_t i = 0; i < wanted; ++i) some.push_back(list[i * list.size() / wanted]);
  return some;
}

}  // namespace

std::vector<FunctionBlock> makeBlocks(const FunctionSet& set, const std::vector<uint64_t>& functions) {
  const size_t block_count = (functions.size() + kBatchCount - 1) / kBatchCount;
  std::vector<FunctionBlock> blocks(block_count);
  for (size_t b = 0; b < block_count; ++b) {
    FunctionBlock& block = blocks[b];
    const size_t begin = b * functions.size() / block_count, end = (b + 1) * functions.size() / block_count;
    for (size_t i = begin; i < end; ++i) {
      const StoredFunction stored = storedFunction(set, functions[i]);
      block.functions.push_back(functions[i]);
      block.stored.push_back(stored);
      block.phi.insert(block.phi.end(), stored.phi, stored.phi + kSupportPointCount);
    }
  }
  return blocks;
}

const char* populationWords(Population population) {
  constexpr const char* kWords[] = {"all functions", "functions that take a θ", "hard functions"};
  return kWords[static_cast<size_t>(population)];
}

uint64_t ChosenFunctions::count(Population population) const {
  switch (population) {
    case Population::all:
      return with_theta.size() + bare_tents.size();
    case Population::theta:
      return with_theta.size();
    case Population::hard:
      return static_cast<uint64_t>(std::count(hard.begin(), hard.end(), true));
  }
  return 0;
}

ChosenFunctions chooseFunctions(const FunctionSet& set, uint64_t wanted, const PolicyOptions& policy, double hard_tent_rmse) {
  const size_t scene_count = set.scene_ids.size();
  FunctionChecker checker;
  std::vector<uint64_t> taking;
  std::vector<uint32_t> taking_scene;
  std::vector<bool> hard(set.functionCount());
  std::vector<std::vector<uint64_t>> tents_of(scene_count);
  std::vector<uint64_t> taking_of(scene_count, 0), chosen_of(scene_count, 0);
  for (uint64_t i = 0; i < set.functionCount(); ++i) {
    const FunctionCheck tent = checker.checkBareTent(storedFunction(set, i), policy.check());
    const uint32_t scene = set.scene_idx[i];
    hard[i] = tent.rmse >= hard_tent_rmse;
    if (takesBareTent(tent, policy)) {
      tents_of[scene].push_back(i);
      continue;
    }
    taking.push_back(i);
    taking_scene.push_back(scene);
    ++taking_of[scene];
  }
  if (taking.empty()) throw InputError("held-out shards", "functions", "one that takes a theta", "bare tents only");
  ChosenFunctions chosen;
  for (const uint64_t n : chooseEvenly(taking_scene, scene_count, wanted)) {
    const uint64_t i = taking[n];
    chosen.with_theta.push_back(i);
    chosen.hard.push_back(hard[i]);
    ++chosen_of[taking_scene[n]];
  }
  for (size_t s = 0; s < scene_count; ++s) {
    // a scene where nothing takes a theta stands there with one scene's share
    const double share = taking_of[s] > 0 ? static_cast<double>(chosen_of[s]) / static_cast<double>(taking_of[s])
                                          : static_cast<double>(chosen.with_theta.size()) /
                                                static_cast<double>(scene_count * std::max<size_t>(1, tents_of[s].size()));
    const auto count = static_cast<uint64_t>(std::lround(std::min(1.0, share) * static_cast<double>(tents_of[s].size())));
    const std::vector<uint64_t> some = spread(tents_of[s], count);
    chosen.bare_tents.insert(chosen.bare_tents.end(), some.begin(), some.end());
  }
  return chosen;
}

}  // namespace nlg
