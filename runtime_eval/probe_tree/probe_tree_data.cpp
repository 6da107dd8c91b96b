#include "runtime_eval/probe_tree/probe_tree_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

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

// The one that may see a tree's own lists.
class ProbeTreeAccess {
 public:
  static ProbeTreeData dataOf(const ProbeTree& tree) {
    ProbeTreeData data;
    data.frame = tree.frame_;
    for (const ProbeTree::Node& node : tree.nodes_) {
      data.child_mask.push_back(node.child_mask);
      data.used_mask.push_back(node.used_mask);
      data.cell_count.push_back(node.cell_count);
    }
    return data;
  }

  static ProbeTreeLists listsOf(const ProbeTree& tree) {
    ProbeTreeLists lists;
    for (const ProbeTree::Node& node : tree.nodes_) {
      lists.first_child.push_back(node.first_child);
      lists.first_slot.push_back(node.first_slot);
      lists.cell_log2.push_back(node.cell_log2);
    }
    lists.slots = tree.slots_;
    return lists;
  }

  // first_child, cell_log2   by node, as the builder would have them
  static bool makeTree(const ProbeTreeData& data, const std::vector<uint32_t>& first_child, const std::vector<uint8_t>& cell_log2,
                       uint64_t probe_limit, ProbeTree* tree) {
    tree->frame_ = data.frame;
    tree->nodes_.resize(data.child_mask.size());
    for (size_t i = 0; i < tree->nodes_.size(); ++i) {
      tree->nodes_[i] = {data.child_mask[i], data.used_mask[i], first_child[i], 0, cell_log2[i], data.cell_count[i]};
      tree->cell_count_ += static_cast<size_t>(std::popcount(data.used_mask[i]));
    }
    return ProbeTreeNumbering(probe_limit, *tree).number();
  }
};

namespace {

constexpr int kLastLevel = 2;

// The cells that a node has.
uint64_t cellsOf(uint32_t cell_count) {
  uint64_t mask = 0;
  for (uint32_t bit = 0; bit < 64; ++bit) {
    if ((bit & 3) < cell_count && (bit >> 2 & 3) < cell_count && bit >> 4 < cell_count) mask |= uint64_t{1} << bit;
  }
  return mask;
}

// Walks the nodes as the builder made them: what is wrong with them, and where their children stand.
class NodeWalk {
 public:
  explicit NodeWalk(const ProbeTreeData& data) : data_(data) {}

  std::vector<uint32_t> first_child;
  std::vector<uint8_t> cell_log2;
  uint64_t used_count = 0;  // cells
  std::string fault;

  bool check() {
    if (!checkFrame() || !checkSizes()) return false;
    const std::array<int32_t, 3>& roots = data_.frame.root_count;
    const uint64_t root_count =
        static_cast<uint64_t>(roots[0]) * static_cast<uint64_t>(roots[1]) * static_cast<uint64_t>(roots[2]);
    const uint64_t node_count = data_.child_mask.size();
    if (root_count > node_count) return expected("frame", "no more roots than nodes");
    first_child.resize(node_count);
    cell_log2.resize(node_count);
    next_node_ = root_count;
    // nodes stand as the builder numbers them: all roots, then the children of one node side by side
    for (uint64_t root = 0; root < root_count; ++root) {
      if (!checkNode(root, kRootSide, 0)) return false;
    }
    return next_node_ == node_count || expected("nodes", "each to be a root or a child");
  }

 private:
  bool expected(const std::string& place, const std::string& what) {
    fault = place + ": expected " + what;
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
    if (data_.used_mask.size() != nodes || data_.cell_count.size() != nodes) return expected("nodes", "lists of one length");
    if (nodes > kNoProbe) return expected("nodes", "fewer than 2^32");
    return true;
  }

  bool checkNode(uint64_t node, int32_t side, int level) {
    const std::string place = "node " + std::to_string(node);
    const uint32_t count = data_.cell_count[node];
    if (!(count == 2 || count == 4 || (count == 1 && level == 0))) return expected(place, "a cell_count of 1, 2 or 4");
    const int32_t cell_side = side / static_cast<int32_t>(count);
    // a cell is a child, or used, or neither
    const uint64_t children = data_.child_mask[node], used = data_.used_mask[node];
    if ((children & used) != 0) return expected(place, "no cell that is a child and used");
    if (((children | used) & ~cellsOf(count)) != 0) return expected(place, "only cells that it has");
    if (children != 0 && (count != 4 || level == kLastLevel)) return expected(place, "no children");
    // children stand where the builder would have put them
    cell_log2[node] = static_cast<uint8_t>(std::countr_zero(static_cast<uint32_t>(cell_side)));
    first_child[node] = static_cast<uint32_t>(next_node_);
    used_count += static_cast<uint64_t>(std::popcount(used));
    const uint64_t first = next_node_;
    next_node_ += static_cast<uint64_t>(std::popcount(children));
    if (next_node_ > data_.child_mask.size()) return expected(place, "children that are there");
    for (uint64_t child = first; child < first + static_cast<uint64_t>(std::popcount(children)); ++child) {
      if (!checkNode(child, cell_side, level + 1)) return false;
    }
    return true;
  }

  const ProbeTreeData& data_;
  uint64_t next_node_ = 0;
};

enum MaskForm : uint8_t { kNoCell, kAllCells, kStored, kFormCount };

// The bits of a mask that a node of 2³ or 4³ cells has, side by side: x + 2 y + 4 z instead of x + 4 y + 16 z for 2³.
void storeMask(uint64_t mask, uint32_t cell_count, std::vector<uint8_t>* bits) {
  if (cell_count == 4) {
    for (int byte = 0; byte < 8; ++byte) bits->push_back(static_cast<uint8_t>(mask >> 8 * byte));
    return;
  }
  uint8_t small = 0;
  for (int cell = 0; cell < 8; ++cell)
    small |= static_cast<uint8_t>((mask >> ((cell & 1) + 4 * (cell >> 1 & 1) + 16 * (cell >> 2)) & 1) << cell);
  bits->push_back(small);
}

uint64_t loadMask(const uint8_t* bits, uint32_t cell_count) {
  uint64_t mask = 0;
  for (int byte = 0; byte < 8 && cell_count == 4; ++byte) mask |= uint64_t{bits[byte]} << 8 * byte;
  for (int cell = 0; cell < 8 && cell_count != 4; ++cell)
    mask |= uint64_t{bits[0] >> cell & 1u} << ((cell & 1) + 4 * (cell >> 1 & 1) + 16 * (cell >> 2));
  return mask;
}

// all   what the mask can be at most
uint8_t formOf(uint64_t mask, uint64_t all) { return mask == 0 ? kNoCell : mask == all ? kAllCells : kStored; }

// Takes masks out of stored bits, one after another.
class MaskReader {
 public:
  explicit MaskReader(const std::vector<uint8_t>& bits) : bits_(bits) {}
  bool isAtEnd() const { return next_ == bits_.size(); }

  // false where no bits are left, or where stored bits say what another form says in less
  bool read(uint32_t form, uint32_t cell_count, uint64_t all, uint64_t* mask) {
    *mask = form == kAllCells ? all : 0;
    if (form != kStored) return form != kAllCells || all != 0;
    const size_t bytes = cell_count == 4 ? 8 : 1;
    if (bytes > bits_.size() - next_) return false;
    *mask = loadMask(&bits_[next_], cell_count);
    next_ += bytes;
    return formOf(*mask, all) == kStored;
  }

 private:
  const std::vector<uint8_t>& bits_;
  size_t next_ = 0;
};

}  // namespace

ProbeTreeData probeTreeData(const ProbeTree& tree) { return ProbeTreeAccess::dataOf(tree); }

ProbeTreeLists probeTreeLists(const ProbeTree& tree) { return ProbeTreeAccess::listsOf(tree); }

std::string makeProbeTree(const ProbeTreeData& data, uint64_t probe_count, ProbeTree* tree) {
  *tree = {};
  NodeWalk walk(data);
  if (!walk.check()) return walk.fault;
  const std::string wrong_count = "probes: expected the " + std::to_string(probe_count) + " that there are numbers for";
  // every used cell has a low corner that no other has; before slots are made for them
  if (probe_count > kMaxTreeProbes || walk.used_count > probe_count) return wrong_count;
  ProbeTree made;
  if (!ProbeTreeAccess::makeTree(data, walk.first_child, walk.cell_log2, probe_count, &made) || made.probeCount() != probe_count)
    return wrong_count;
  *tree = std::move(made);
  return {};
}

PackedNodes packNodes(const ProbeTreeData& data) {
  PackedNodes packed;
  for (size_t i = 0; i < data.child_mask.size(); ++i) {
    const uint32_t count = data.cell_count[i];
    const uint64_t cells = cellsOf(count), children = data.child_mask[i], used = data.used_mask[i];
    const uint8_t child_form = formOf(children, cells), used_form = formOf(used, cells & ~children);
    packed.kind.push_back(static_cast<uint8_t>(std::countr_zero(count) + 4 * child_form + 16 * used_form));
    if (child_form == kStored) storeMask(children, count, &packed.bits);
    if (used_form == kStored) storeMask(used, count, &packed.bits);
  }
  return packed;
}

std::string unpackNodes(const PackedNodes& packed, ProbeTreeData* data) {
  data->child_mask.clear();
  data->used_mask.clear();
  data->cell_count.clear();
  MaskReader reader(packed.bits);
  for (size_t i = 0; i < packed.kind.size(); ++i) {
    const uint32_t kind = packed.kind[i], count = 1u << (kind & 3), child_form = kind >> 2 & 3, used_form = kind >> 4;
    const std::string place = "node " + std::to_string(i);
    if (count > 4 || child_form >= kFormCount || used_form >= kFormCount) return place + ": expected a kind of node";
    uint64_t children = 0, used = 0;
    const uint64_t cells = cellsOf(count);
    if (!reader.read(child_form, count, cells, &children) || !reader.read(used_form, count, cells & ~children, &used))
      return place + ": expected bits of some of its cells";
    data->child_mask.push_back(children);
    data->used_mask.push_back(used);
    data->cell_count.push_back(static_cast<uint8_t>(count));
  }
  return reader.isAtEnd() ? "" : "nodes: expected no more bits than masks";
}

}  // namespace nlg
