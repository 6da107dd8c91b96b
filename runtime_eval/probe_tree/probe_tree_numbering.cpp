#include "runtime_eval/probe_tree/probe_tree_numbering.h"

#include <algorithm>
#include <bit>

#include "runtime_eval/probe_tree/morton.h"

namespace nlg {

bool ProbeTreeNumbering::number() {
  bool fits = true;
  tree_.visitAllNodes(
      [&](const ProbeNode& place, uint32_t node_idx) { fits = fits && addBrick(place.low, tree_.nodes_[node_idx]); });
  if (!fits || !mergeKeys()) return false;
  numberProbes();
  tree_.slots_.shrink_to_fit();
  return true;
}

template <class Visit>
void ProbeTreeNumbering::forEachRead(const LatticePoint& low, const ProbeTree::Node& node, const Visit& visit) {
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

// Makes room for the brick's slots, marks those that used cells read, and notes their lattice points.
bool ProbeTreeNumbering::addBrick(const LatticePoint& low, ProbeTree::Node& node) {
  if (node.used_mask == 0) return true;
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
  return keys().size() < merge_at_ || mergeKeys();
}

// Keys once each, so that they never take much more memory than the tree's own.
bool ProbeTreeNumbering::mergeKeys() {
  std::sort(keys().begin(), keys().end());
  keys().erase(std::unique(keys().begin(), keys().end()), keys().end());
  merge_at_ = std::max(merge_at_, 2 * keys().size());
  return keys().size() <= probe_limit_;
}

// Slots become indices; a probe's spacing is the largest of the cells that read it.
void ProbeTreeNumbering::numberProbes() {
  keys().shrink_to_fit();
  tree_.probe_log2_.assign(keys().size(), 0);
  tree_.visitAllNodes([&](const ProbeNode& place, uint32_t node_idx) {
    const ProbeTree::Node& node = tree_.nodes_[node_idx];
    if (node.used_mask == 0) return;
    forEachRead(place.low, node, [&](uint32_t& slot, uint64_t key) {
      slot = static_cast<uint32_t>(std::lower_bound(keys().begin(), keys().end(), key) - keys().begin());
      tree_.probe_log2_[slot] = std::max(tree_.probe_log2_[slot], node.cell_log2);
    });
  });
  for (uint32_t& slot : tree_.slots_) {
    if (slot != kNoProbe) slot |= uint32_t{tree_.probe_log2_[slot]} << ProbeTree::kIndexBits;
  }
}

}  // namespace nlg
