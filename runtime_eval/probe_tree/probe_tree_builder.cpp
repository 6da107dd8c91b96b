// ProbeTree::build: nodes from the judge's verdicts, then their probes.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "runtime_eval/probe_tree/probe_tree_data.h"

namespace nlg {

class ProbeTreeBuilder {
 public:
  ProbeTreeBuilder(const CellJudge& judge, uint64_t probe_limit, ProbeTree& tree)
      : judge_(judge), probe_limit_(probe_limit), tree_(tree) {}

  // false: too many probes
  bool build() {
    const std::array<int32_t, 3>& roots = tree_.frame_.root_count;
    tree_.nodes_.resize(static_cast<size_t>(roots[0]) * roots[1] * roots[2]);
    uint32_t root_idx = 0;
    for (int32_t z = 0; z < roots[2]; ++z) {
      for (int32_t y = 0; y < roots[1]; ++y) {
        for (int32_t x = 0; x < roots[0]; ++x, ++root_idx) {
          if (!addNode(root_idx, {{x * kRootSide, y * kRootSide, z * kRootSide}, kRootSide}, 0)) return false;
        }
      }
    }
    // bricks only now: a tree that is too large is known by its nodes, long before its probes are
    tree_.nodes_.shrink_to_fit();
    return ProbeTreeNumbering(probe_limit_, tree_).number();
  }

 private:
  static constexpr int kLastLevel = 2;

  bool addNode(uint32_t node_idx, const ProbeCell& cube, int level) {
    ProbeTree::Node node;
    chooseBrick(cube, level, node);
    // every used cell has a low corner that no other has: there are at least as many probes
    tree_.cell_count_ += static_cast<size_t>(std::popcount(node.used_mask));
    if (tree_.cell_count_ > probe_limit_) return false;
    const size_t first_child = tree_.nodes_.size();
    node.first_child = static_cast<uint32_t>(first_child);
    tree_.nodes_[node_idx] = node;
    tree_.nodes_.resize(first_child + static_cast<size_t>(std::popcount(node.child_mask)));
    if (tree_.nodes_.size() > 2 * probe_limit_ + kMinLimit) return false;
    uint32_t child_idx = node.first_child;
    for (uint64_t mask = node.child_mask; mask != 0; mask &= mask - 1) {
      if (!addNode(child_idx++, ProbeTree::cellOf(cube.low, std::countr_zero(mask), node.cell_log2), level + 1)) return false;
    }
    return true;
  }

  // The smallest brick whose cells fit. A node below the roots exists because one cell is too coarse for it.
  void chooseBrick(const ProbeCell& cube, int level, ProbeTree::Node& node) {
    const bool asks_quarters = (level > 0 || !tryCells(cube, 1, node)) && !tryCells(cube, 2, node);
    if (!asks_quarters) return;
    tryCells(cube, 4, node);
    if (level == kLastLevel) node.used_mask |= std::exchange(node.child_mask, 0);
  }

  // Cuts the cube into cell_count cells along an edge. false as soon as one is too coarse, but for quarters, where it is a child.
  bool tryCells(const ProbeCell& cube, int cell_count, ProbeTree::Node& node) {
    node = {};
    node.cell_count = static_cast<uint8_t>(cell_count);
    node.cell_log2 = static_cast<uint8_t>(std::countr_zero(static_cast<uint32_t>(cube.side / cell_count)));
    for (int bit = 0; bit < 64; ++bit) {
      if ((bit & 3) >= cell_count || (bit >> 2 & 3) >= cell_count || bit >> 4 >= cell_count) continue;
      const CellVerdict verdict = judge_(ProbeTree::cellOf(cube.low, bit, node.cell_log2));
      if (verdict == CellVerdict::too_coarse && cell_count < 4) return false;
      if (verdict == CellVerdict::too_coarse) node.child_mask |= uint64_t{1} << bit;
      if (verdict == CellVerdict::fits) node.used_mask |= uint64_t{1} << bit;
    }
    return true;
  }

  static constexpr uint64_t kMinLimit = 1 << 10;  // nodes that any tree may have
  const CellJudge& judge_;
  uint64_t probe_limit_;
  ProbeTree& tree_;
};

ProbeTreeStatus ProbeTree::build(const ProbeTreeFrame& frame, const CellJudge& judge, uint64_t probe_limit, ProbeTree* tree) {
  *tree = {};
  uint64_t root_count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_valid = std::isfinite(frame.first_m[axis]) && frame.root_count[axis] >= 0 &&
                          frame.root_count[axis] <= kMaxLatticeSide / kRootSide;
    if (!is_valid) return ProbeTreeStatus::invalid_frame;
    root_count *= static_cast<uint64_t>(frame.root_count[axis]);
  }
  if (!(std::isfinite(frame.spacing_m) && frame.spacing_m > 0.0)) return ProbeTreeStatus::invalid_frame;
  probe_limit = std::min(probe_limit, kMaxTreeProbes);
  if (root_count > probe_limit) return ProbeTreeStatus::too_many_probes;
  tree->frame_ = frame;
  if (ProbeTreeBuilder(judge, probe_limit, *tree).build()) return ProbeTreeStatus::ok;
  *tree = {};
  return ProbeTreeStatus::too_many_probes;
}

}  // namespace nlg
