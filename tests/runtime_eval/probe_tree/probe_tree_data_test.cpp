#include "runtime_eval/probe_tree/probe_tree_data.h"

#include <gtest/gtest.h>

#include <bit>

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

// What makeProbeTree says to the small tree with one thing changed.
template <class Spoil>
std::string faultOf(const Spoil& spoil) {
  ProbeTreeData data = probeTreeData(smallTree());
  uint64_t probe_count = smallTree().probeCount();
  spoil(data, probe_count);
  ProbeTree tree = smallTree();
  const std::string fault = makeProbeTree(data, probe_count, &tree);
  EXPECT_EQ(tree.nodeCount() == 0, !fault.empty());
  return fault;
}

TEST(ProbeTreeData, NamesWhatIsWrong) {
  const uint64_t all = ~uint64_t{0};
  EXPECT_EQ(faultOf([](ProbeTreeData&, uint64_t&) {}), "");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.child_mask.pop_back(); }), "nodes: expected lists of one length");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.used_mask.clear(); }), "nodes: expected lists of one length");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.cell_count.push_back(2); }), "nodes: expected lists of one length");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.frame.root_count[0] = 0; }),
            "nodes: expected each to be a root or a child");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) {
              d.frame.root_count = {32767, 32767, 32767};
            }),
            "frame: expected no more roots than nodes");
  EXPECT_EQ(faultOf([=](ProbeTreeData& d, uint64_t&) { d.child_mask[1] = all, d.used_mask[1] = 0; }),
            "node 1: expected children that are there");
  EXPECT_EQ(faultOf([=](ProbeTreeData& d, uint64_t&) { d.child_mask[2] = 1, d.used_mask[2] = all - 1; }),
            "node 2: expected no children");
  EXPECT_EQ(faultOf([=](ProbeTreeData& d, uint64_t&) { d.used_mask[0] |= d.child_mask[0]; }),
            "node 0: expected no cell that is a child and used");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.cell_count[2] = 1; }), "node 2: expected a cell_count of 1, 2 or 4");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.cell_count[2] = 0; }), "node 2: expected a cell_count of 1, 2 or 4");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.cell_count[2] = 2; }), "node 2: expected only cells that it has");
  const std::string count = std::to_string(smallTree().probeCount());
  EXPECT_EQ(faultOf([](ProbeTreeData&, uint64_t& probes) { ++probes; }).substr(0, 6), "probes");
  EXPECT_EQ(faultOf([](ProbeTreeData&, uint64_t& probes) { --probes; }).substr(0, 6), "probes");
  EXPECT_EQ(faultOf([](ProbeTreeData&, uint64_t& probes) { probes = 3; }).substr(0, 6), "probes");
  EXPECT_EQ(faultOf([](ProbeTreeData& d, uint64_t&) { d.used_mask[2] = 0; }),
            "probes: expected the " + count + " that there are numbers for");
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

TEST(PackedNodes, TakeOneByteForANodeWhoseCellsAreAllAlike) {
  ProbeTree tree;
  const CellJudge fine = [](const ProbeCell& cell) { return cell.side > 4 ? CellVerdict::too_coarse : CellVerdict::fits; };
  ASSERT_EQ(ProbeTree::build({{}, 1.0, {1, 1, 1}}, fine, kMaxTreeProbes, &tree), ProbeTreeStatus::ok);
  const PackedNodes packed = packNodes(probeTreeData(tree));
  EXPECT_EQ(packed.kind.size(), 65u);
  EXPECT_TRUE(packed.bits.empty());
}

TEST(PackedNodes, RefuseWhatHasAShorterForm) {
  ProbeTreeData data;
  const auto faultOfBytes = [&](const PackedNodes& packed) { return unpackNodes(packed, &data); };
  EXPECT_EQ(faultOfBytes({{2 + 16}, {}}), "");      // 4³ cells, all used
  EXPECT_EQ(faultOfBytes({{1 + 32}, {0x81}}), "");  // 2³ cells, the first and the last used
  EXPECT_EQ(data.used_mask[0], (uint64_t{1} << 21) + 1);
  EXPECT_NE(faultOfBytes({{1 + 32}, {0}}), "");              // none of them
  EXPECT_NE(faultOfBytes({{1 + 32}, {0xff}}), "");           // all of them
  EXPECT_NE(faultOfBytes({{1 + 32}, {}}), "");               // no bits
  EXPECT_NE(faultOfBytes({{1 + 32}, {0x81, 0}}), "");        // too many
  EXPECT_NE(faultOfBytes({{2 + 32}, {1, 2, 3, 4, 5}}), "");  // too few
  EXPECT_NE(faultOfBytes({{2 + 4 + 16}, {}}), "");           // all cells are children, and all others are used
  EXPECT_NE(faultOfBytes({{3}, {}}), "");                    // 8³ cells
  EXPECT_NE(faultOfBytes({{2 + 12}, {}}), "");
  EXPECT_NE(faultOfBytes({{2 + 48}, {}}), "");
  EXPECT_NE(faultOfBytes({{2 + 128}, {}}), "");
}

}  // namespace
}  // namespace nlg
