#include "runtime_eval/light_grid/probe_tree_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "runtime_eval/light_grid/morton.h"

namespace nlg {

// The one that may see a tree's own lists.
class ProbeTreeAccess {
 public:
  static ProbeTreeData dataOf(const ProbeTree& tree) {
    ProbeTreeData data;
    data.frame = tree.frame_;
    for (const ProbeTree::Node& node : tree.nodes_) {
      data.child_mask.push_back(node.child_mask);
      data.used_mask.push_back(node.used_mask);
      data.first_child.push_back(node.first_child);
      data.first_slot.push_back(node.first_slot);
      data.cell_log2.push_back(node.cell_log2);
      data.cell_count.push_back(node.cell_count);
    }
    data.slots = tree.slots_;
    data.probe_keys = tree.probe_keys_;
    data.probe_log2 = tree.probe_log2_;
    return data;
  }

  // data   checked
  static ProbeTree treeOf(ProbeTreeData data) {
    ProbeTree tree;
    tree.frame_ = data.frame;
    tree.nodes_.resize(data.child_mask.size());
    for (size_t i = 0; i < tree.nodes_.size(); ++i) {
      tree.nodes_[i] = {data.child_mask[i], data.used_mask[i], data.first_child[i],
                        data.first_slot[i], data.cell_log2[i], data.cell_count[i]};
      tree.cell_count_ += static_cast<size_t>(std::popcount(data.used_mask[i]));
    }
    tree.slots_ = std::move(data.slots);
    tree.probe_keys_ = std::move(data.probe_keys);
    tree.probe_log2_ = std::move(data.probe_log2);
    return tree;
  }

  static constexpr int kIndexBits = ProbeTree::kIndexBits;
};

namespace {

// Walks the nodes as the builder made them, and expects in every list what it would have put there.
class TreeChecker {
 public:
  explicit TreeChecker(const ProbeTreeData& data) : data_(data), read_log2_(data.probe_keys.size(), kUnread) {}

  const std::string& fault() const { return fault_; }

  bool check() {
    if (!checkFrame() || !checkSizes()) return false;
    uint64_t root = 0;
    const std::array<int32_t, 3>& roots = data_.frame.root_count;
    next_node_ = static_cast<uint64_t>(roots[0]) * static_cast<uint64_t>(roots[1]) * static_cast<uint64_t>(roots[2]);
    if (next_node_ > data_.child_mask.size()) return expected("frame", "no more roots than nodes");
    for (int32_t z = 0; z < roots[2]; ++z) {
      for (int32_t y = 0; y < roots[1]; ++y) {
        for (int32_t x = 0; x < roots[0]; ++x)
          if (!checkNode(root++, {x * kRootSide, y * kRootSide, z * kRootSide}, kRootSide, 0)) return false;
      }
    }
    if (next_node_ != data_.child_mask.size()) return expected("nodes", "each to be a root or a child");
    if (next_slot_ != data_.slots.size()) return expected("slots", "no more than the bricks have");
    return checkProbes();
  }

 private:
  static constexpr uint8_t kUnread = 0xff;
  static constexpr int kLastLevel = 2;

  bool expected(const std::string& place, const std::string& what) {
    fault_ = place + ": expected " + what;
    return false;
  }

  bool checkFrame() {
    const ProbeTreeFrame& frame = data_.frame;
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(frame.first_m[axis])) return expected("frame", "a finite first_m");
      if (frame.root_count[axis] < 0 || frame.root_count[axis] > kMaxLatticeSide / kRootSide)
        return expected("frame", "root_count in 0 to " + std::to_string(kMaxLatticeSide / kRootSide));
    }
    if (!(std::isfinite(frame.spacing_m) && frame.spacing_m > 0.0)) return expected("frame", "a positive spacing_m");
    return true;
  }

  bool checkSizes() {
    const size_t nodes = data_.child_mask.size();
    for (const size_t size : {data_.used_mask.size(), data_.first_child.size(), data_.first_slot.size(), data_.cell_log2.size(),
                              data_.cell_count.size()}) {
      if (size != nodes) return expected("nodes", "lists of one length");
    }
    if (nodes > kNoProbe || data_.slots.size() > kNoProbe) return expected("nodes and slots", "fewer than 2^32");
    if (data_.probe_keys.size() > kMaxTreeProbes) return expected("probes", "at most " + std::to_string(kMaxTreeProbes));
    if (data_.probe_log2.size() != data_.probe_keys.size()) return expected("probes", "lists of one length");
    return true;
  }

  bool checkNode(uint64_t node, const LatticePoint& low, int32_t side, int level) {
    const std::string place = "node " + std::to_string(node);
    const uint32_t count = data_.cell_count[node];
    if (!(count == 2 || count == 4 || (count == 1 && level == 0))) return expected(place, "a cell_count of 1, 2 or 4");
    const int32_t cell_side = side / static_cast<int32_t>(count);
    if (data_.cell_log2[node] != std::countr_zero(static_cast<uint32_t>(cell_side)))
      return expected(place, "the cell_log2 of its level");
    const uint64_t children = data_.child_mask[node], used = data_.used_mask[node];
    if ((children & used) != 0) return expected(place, "no cell that is a child and used");
    if (((children | used) & ~cellsOf(count)) != 0) return expected(place, "only cells that it has");
    if (children != 0 && (count != 4 || level == kLastLevel)) return expected(place, "no children");
    if (data_.first_child[node] != next_node_) return expected(place, "first_child in the order of nodes");
    const uint64_t first_child = next_node_;
    next_node_ += static_cast<uint64_t>(std::popcount(children));
    if (next_node_ > data_.child_mask.size()) return expected(place, "children that are there");
    if (!checkBrick(node, low)) return false;
    uint64_t child = first_child;
    for (uint64_t mask = children; mask != 0; mask &= mask - 1, ++child) {
      const int bit = std::countr_zero(mask);
      LatticePoint child_low = low;
      for (int axis = 0; axis < 3; ++axis) child_low[axis] += cell_side * (bit >> 2 * axis & 3);
      if (!checkNode(child, child_low, cell_side, level + 1)) return false;
    }
    return true;
  }

  static uint64_t cellsOf(uint32_t count) {
    uint64_t mask = 0;
    for (uint32_t bit = 0; bit < 64; ++bit) {
      if ((bit & 3) < count && (bit >> 2 & 3) < count && bit >> 4 < count) mask |= uint64_t{1} << bit;
    }
    return mask;
  }

  bool checkBrick(uint64_t node, const LatticePoint& low) {
    const std::string place = "node " + std::to_string(node);
    const uint64_t used = data_.used_mask[node];
    if (data_.first_slot[node] != (used != 0 ? next_slot_ : 0)) return expected(place, "first_slot in the order of nodes");
    if (used == 0) return true;
    const uint32_t edge = data_.cell_count[node] + 1u;
    const uint64_t first = next_slot_;
    next_slot_ += edge * edge * edge;
    if (next_slot_ > data_.slots.size()) return expected(place, "slots that are there");
    std::array<bool, 125> is_read{};
    for (uint64_t mask = used; mask != 0; mask &= mask - 1) {
      const auto bit = static_cast<uint32_t>(std::countr_zero(mask));
      const uint32_t cell = ((bit >> 4) * edge + (bit >> 2 & 3)) * edge + (bit & 3);
      for (uint32_t c = 0; c < 8; ++c) is_read[cell + (c & 1) + (c >> 1 & 1) * edge + (c >> 2) * edge * edge] = true;
    }
    for (uint32_t slot = 0; slot < edge * edge * edge; ++slot) {
      LatticePoint point = low;
      point[0] += static_cast<int32_t>(slot % edge << data_.cell_log2[node]);
      point[1] += static_cast<int32_t>(slot / edge % edge << data_.cell_log2[node]);
      point[2] += static_cast<int32_t>(slot / (edge * edge) << data_.cell_log2[node]);
      if (!checkSlot(first + slot, is_read[slot], point, data_.cell_log2[node])) return false;
    }
    return true;
  }

  bool checkSlot(uint64_t slot, bool is_read, const LatticePoint& point, uint8_t cell_log2) {
    const uint32_t value = data_.slots[slot];
    const auto place = [&] { return "slot " + std::to_string(slot); };
    if (!is_read) return value == kNoProbe || expected(place(), "no probe where no cell reads");
    const uint32_t probe = value & (kMaxTreeProbes - 1);
    if (value == kNoProbe || probe >= data_.probe_keys.size()) return expected(place(), "a probe");
    if (value >> ProbeTreeAccess::kIndexBits != data_.probe_log2[probe]) return expected(place(), "the probe's spacing");
    if (data_.probe_keys[probe] != mortonFromLattice(point)) return expected(place(), "the probe at this lattice point");
    if (read_log2_[probe] == kUnread || read_log2_[probe] < cell_log2) read_log2_[probe] = cell_log2;
    return true;
  }

  bool checkProbes() {
    for (size_t probe = 0; probe < data_.probe_keys.size(); ++probe) {
      const auto place = [&] { return "probe " + std::to_string(probe); };
      if (probe > 0 && data_.probe_keys[probe - 1] >= data_.probe_keys[probe]) return expected(place(), "rising keys");
      if (read_log2_[probe] == kUnread) return expected(place(), "a cell that reads it");
      if (read_log2_[probe] != data_.probe_log2[probe]) return expected(place(), "the spacing of its largest cell");
    }
    return true;
  }

  const ProbeTreeData& data_;
  std::vector<uint8_t> read_log2_;  // by probe: of the largest cell that reads it so far
  uint64_t next_node_ = 0, next_slot_ = 0;
  std::string fault_;
};

}  // namespace

size_t ProbeTreeData::byteCount() const {
  const size_t frame_bytes = sizeof frame.first_m + sizeof frame.spacing_m + sizeof frame.root_count;
  const size_t node_bytes = 2 * sizeof(uint64_t) + 2 * sizeof(uint32_t) + 2 * sizeof(uint8_t);
  return frame_bytes + child_mask.size() * node_bytes + slots.size() * sizeof(uint32_t) +
         probe_keys.size() * (sizeof(uint64_t) + sizeof(uint8_t));
}

ProbeTreeData probeTreeData(const ProbeTree& tree) { return ProbeTreeAccess::dataOf(tree); }

std::string makeProbeTree(ProbeTreeData data, ProbeTree* tree) {
  *tree = {};
  TreeChecker checker(data);
  if (!checker.check()) return checker.fault();
  *tree = ProbeTreeAccess::treeOf(std::move(data));
  return {};
}

}  // namespace nlg
