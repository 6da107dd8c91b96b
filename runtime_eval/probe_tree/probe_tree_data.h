// A probe tree as plain lists of numbers, for files.
//
// A file holds the nodes alone: which of their cells are children and which are used. Slots and probes follow from them. What
// the lists mean: docs/reference/formats.md, "Light grid". A tree made of lists is checked to the last entry: what passes is a
// tree that ProbeTree::build gives for some verdicts, so no look-up can leave it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "nlg/probe_tree.h"

namespace nlg {

// Numbers the probes of a tree: bricks, and one number for every lattice point that a used cell reads. Internal to
// ProbeTree::build and the reader of files.
class ProbeTreeNumbering {
 public:
  // tree   its frame and nodes are there, but for first_slot; slots and probes are empty. Outlives this
  ProbeTreeNumbering(uint64_t probe_limit, ProbeTree& tree) : probe_limit_(probe_limit), tree_(tree) {}

  // Memory: 4 bytes a lattice point of every brick, 125 at most, and about 17 bytes a probe.
  // returns   false: more probes than the limit, or 2^32 slots; then the tree is of no use
  bool number();

 private:
  bool addBrick(const LatticePoint& low, ProbeTree::Node& node);
  bool mergeKeys();
  void numberProbes();
  template <class Visit>
  void forEachRead(const LatticePoint& low, const ProbeTree::Node& node, const Visit& visit);
  std::vector<uint64_t>& keys() { return tree_.probe_keys_; }

  static constexpr uint32_t kRead = 0;  // a slot that waits for its number
  uint64_t probe_limit_;
  ProbeTree& tree_;
  size_t merge_at_ = size_t{1} << 18;
};

// By node: the roots first, x fastest; the children of a node, then their descendants, in the order of forEachNode.
struct ProbeTreeData {
  ProbeTreeFrame frame;
  std::vector<uint64_t> child_mask;  // bit x + 4 y + 16 z: the cell is a child, not used itself
  std::vector<uint64_t> used_mask;   // the cell is used itself
  std::vector<uint8_t> cell_count;   // cells along an edge: 1 (roots only), 2, 4
};

ProbeTreeData probeTreeData(const ProbeTree& tree);

// The tree of some lists. Memory: 32 bytes a node, and for each of probe_count at most 500 of slots and 17 of its own: a caller
// that has some bytes for each node and each probe takes memory in proportion to them.
//
// probe_count   what the tree must come to
// returns       an empty text, or what was expected and where: "node 17: only cells that it has"; then *tree is empty
std::string makeProbeTree(const ProbeTreeData& data, uint64_t probe_count, ProbeTree* tree);

// The masks of all nodes in one or two bytes for most of them.
struct PackedNodes {
  // by node: log2 of cell_count + 4 * (form of child_mask) + 16 * (form of used_mask). Forms: 0 no cell; 1 all cells, of used_mask
  // all that are no child; 2 the cells that stored bits say
  std::vector<uint8_t> kind;
  // bits of those masks that are stored, in the order of nodes, child_mask first; cells x fastest: 1 byte for 2³ cells, 8 for 4³
  std::vector<uint8_t> bits;
};

PackedNodes packNodes(const ProbeTreeData& data);

// The inverse, but for the frame. What packNodes does not give, such as stored bits that say all cells, is refused.
// returns   an empty text, or what was expected and where
std::string unpackNodes(const PackedNodes& packed, ProbeTreeData* data);

// What follows from the nodes, as look-ups elsewhere need it.
struct ProbeTreeLists {
  std::vector<uint32_t>
      first_child;                   // by node: node of the lowest bit of child_mask; of the next child to be, when there is none
  std::vector<uint32_t> first_slot;  // of the brick; 0 when used_mask is 0
  std::vector<uint8_t> cell_log2;    // side of a cell, units
  // by brick, in the order of nodes, (cell_count + 1)³ numbers each, x fastest: probe + 2^27 * probe_log2 of it, or kNoProbe
  std::vector<uint32_t> slots;
};

ProbeTreeLists probeTreeLists(const ProbeTree& tree);

}  // namespace nlg
