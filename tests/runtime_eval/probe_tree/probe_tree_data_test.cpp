#include "runtime_eval/probe_tree/probe_tree_data.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

TEST(ProbeTreeData, MakesEveryBuiltTreeAgain) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const RandomTree built = randomTree(seed);
    ProbeTree tree;
    ASSERT_EQ(makeProbeTree(probeTreeData(built.tree), built.tree.probeCount(), &tree), "") << built.name;
    expectSameTree(tree, built.tree);
  }
}

TEST(PackedNodes, UnpackToTheSameNodes) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const ProbeTreeData data = probeTreeData(randomTree(seed).tree);
    const PackedNodes packed = packNodes(data);
    ProbeTreeData unpacked;
    ASSERT_EQ(unpackNodes(packed, &unpacked), "");
    EXPECT_EQ(unpacked.child_mask, data.child_mask);
    EXPECT_EQ(unpacked.used_mask, data.used_mask);
    EXPECT_EQ(unpacked.cell_count, data.cell_count);
    EXPECT_LE(packed.kind.size() + packed.bits.size(), 17 * data.child_mask.size());
  }
}

}  // namespace
}  // namespace nlg
