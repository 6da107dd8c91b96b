#include "validate/frontier/function_block.h"

#include "runtime_eval/evaluator/projection.h"

namespace nlg {

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
