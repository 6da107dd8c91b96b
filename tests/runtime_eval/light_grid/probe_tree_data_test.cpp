#include "runtime_eval/light_grid/probe_tree_data.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

TEST(ProbeTreeData, AcceptsEveryBuiltTree) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const RandomTree built = randomTree(seed);
    ProbeTree tree;
    ASSERT_EQ(makeProbeTree(probeTreeData(built.tree), &tree), "") << built.name;
    expectSameTree(tree, built.tree);
  }
}

TEST(ProbeTreeData, RefusesListsOfDifferentLengths) {
  const auto expectRefused = [](auto spoil) {
    ProbeTreeData data = probeTreeData(smallTree());
    spoil(data);
    ProbeTree tree = smallTree();
    EXPECT_NE(makeProbeTree(std::move(data), &tree), "");
    EXPECT_EQ(tree.nodeCount(), 0u);
  };
  expectRefused([](ProbeTreeData& d) { d.child_mask.pop_back(); });
  expectRefused([](ProbeTreeData& d) { d.used_mask.clear(); });
  expectRefused([](ProbeTreeData& d) { d.first_child.pop_back(); });
  expectRefused([](ProbeTreeData& d) { d.first_slot.pop_back(); });
  expectRefused([](ProbeTreeData& d) { d.cell_log2.push_back(0); });
  expectRefused([](ProbeTreeData& d) { d.cell_count.clear(); });
  expectRefused([](ProbeTreeData& d) { d.slots.pop_back(); });
  expectRefused([](ProbeTreeData& d) { d.slots.push_back(kNoProbe); });
  expectRefused([](ProbeTreeData& d) { d.probe_keys.pop_back(); });
  expectRefused([](ProbeTreeData& d) { d.probe_log2.pop_back(); });
  expectRefused([](ProbeTreeData& d) {  // a probe that no cell reads
    d.probe_keys.push_back(d.probe_keys.back() + 1);
    d.probe_log2.push_back(0);
  });
}

}  // namespace
}  // namespace nlg
