// ProbeTree::build: nodes from the judge's verdicts, then one number for every lattice point that a used cell reads.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "runtime_eval/light_grid/morton.h"
#include "runtime_eval/light_grid/probe_tree.h"

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
    if (!mergeKeys()) return false;
    numberProbes();
    tree_.nodes_.shrink_to_fit();
    tree_.slots_.shrink_to_fit();
    return true;
  }

 private:
  static constexpr int kLastLevel = 2;

  bool addNode(uint32_t node_idx, const ProbeCell& cube, int level) {
    ProbeTree::Node node;
    chooseBrick(cube, level, node);
    if (node.used_mask != 0 && !addBrick(cube.low, node)) return false;
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

  // Makes room for the brick's slots, marks those that used cells read, and notes their lattice points.
  bool addBrick(const LatticePoint& low, ProbeTree::Node& node) {
    const uint32_t edge = node.cell_count + 1u;
    const size_t first = tree_.slots_.size();
    if (first + edge * edge * edge > kNoProbe) return false;
    node.first_slot = static_cast<uint32_t>(first);
    tree_.slots_.resize(first + edge * edge * edge, kNoProbe);
    for (uint64_t mask = node.used_mask; mask != 0; mask &= mask - 1) {
      const auto bit = static_cast<uint32_t>(std::countr_zero(mask));
      const size_t cell = first + ((bit >> 4) * edge + (bit >> 2 & 3)) * edge + (bit & 3);
      for (uint32_t c = 0; c < 8; ++c) tree_.slots_[cell + (c & 1) + (c >> 1 & 1) * edge + (c >> 2) * edge * edge] = kRead;
    }
    forEachRead(low, node, [&](uint32_t&, uint64_t key) { keys().push_back(key); });
    // every used cell has a low corner that no other has: there are at least as many probes
    tree_.cell_count_ += static_cast<size_t>(std::popcount(node.used_mask));
    if (tree_.cell_count_ > probe_limit_) return false;
    return keys().size() < merge_at_ || mergeKeys();
  }

  // Keys once each, so that they never take much more memory than the tree's own.
  bool mergeKeys() {
    std::sort(keys().begin(), keys().end());
    keys().erase(std::unique(keys().begin(), keys().end()), keys().end());
    merge_at_ = std::max(merge_at_, 2 * keys().size());
    return keys().size() <= probe_limit_;
  }

  // Slots become indices; a probe's spacing is the largest of the cells that read it.
  void numberProbes() {
    keys().shrink_to_fit();
    tree_.probe_log2_.assign(keys().size(), 0);
    tree_.visitAllNodes([&](const ProbeNode& place, const ProbeTree::Node& node) {
      if (node.used_mask == 0) return;
      forEachRead(place.low, node, [&](uint32_t& slot, uint64_t key) {
        slot = static_cast<uint32_t>(std::lower_bound(keys().begin(), keys().end(), key) - keys().begin());
        tree_.probe_log2_[slot] = std::max(tree_.probe_log2_[slot], node.cell_log2);
      });
    });
  }

  template <class Visit>
  void forEachRead(const LatticePoint& low, const ProbeTree::Node& node, const Visit& visit) {
    const uint32_t edge = node.cell_count + 1u;
    uint32_t* slot = &tree_.slots_[node.first_slot];
    for (uint32_t z = 0; z < edge; ++z) {
      for (uint32_t y = 0; y < edge; ++y) {
        for (uint32_t x = 0; x < edge; ++x, ++slot) {
          if (*slot == kNoProbe) continue;
          const auto at = [&](int axis, uint32_t step) { return low[axis] + static_cast<int32_t>(step << node.cell_log2); };
          visit(*slot, mortonFromLattice({at(0, x), at(1, y), at(2, z)}));
        }
      }
    }
  }

  std::vector<uint64_t>& keys() { return tree_.probe_keys_; }

  static constexpr uint32_t kRead = 0;            // a slot that waits for its number
  static constexpr uint64_t kMinLimit = 1 << 10;  // nodes that any tree may have
  const CellJudge& judge_;
  uint64_t probe_limit_;
  ProbeTree& tree_;
  size_t merge_at_ = size_t{1} << 20;
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
