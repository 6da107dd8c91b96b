#include "validate/frontier/function_block.h"

#include <algorithm>

#include "runtime_eval/evaluator/projection.h"

namespace nlg {

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

}  // namespace nlg
