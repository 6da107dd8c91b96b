#include "validate/frontier/interleaved.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "runtime_eval/evaluator/generator/projection.h"
#include "validate/generators/populations.h"

namespace nlg {
namespace {

TEST(MakeBlocks, CutsIntoNearlyEqualBlocksThatABatchHolds) {
  FunctionSet set;
  set.point_count = kSupportPointCount;
  constexpr int kCount = 200;
  for (int i = 0; i < kCount; ++i) {
    set.scene_idx.push_back(0);
    set.phi.insert(set.phi.end(), kSupportPointCount, static_cast<uint8_t>(i));
    set.validity.insert(set.validity.end(), kValidityByteCount, static_cast<uint8_t>(255 - i));
  }
  const std::vector<uint64_t> functions = chooseEvenly(set.scene_idx, 1, kCount);
  const std::vector<FunctionBlock> blocks = makeBlocks(set, functions);
  std::vector<uint64_t> all;
  ASSERT_EQ(blocks.size(), 3u);
  for (const FunctionBlock& block : blocks) {
    EXPECT_TRUE(block.count() == 66 || block.count() == 67) << block.count();
    for (int i = 0; i < block.count(); ++i) {
      const auto expected = static_cast<uint8_t>(block.functions[i]);
      EXPECT_EQ(block.phi[size_t(i) * kSupportPointCount], expected);
      EXPECT_EQ(block.stored[i].phi[kSupportPointCount - 1], expected);
      EXPECT_EQ(block.stored[i].validity[0], 255 - expected);
      all.push_back(block.functions[i]);
    }
  }
  EXPECT_EQ(all, functions);
}

}  // namespace
}  // namespace nlg
