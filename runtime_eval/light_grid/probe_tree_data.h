// A probe tree as plain lists of numbers, for files.
//
// What the lists mean is what ProbeTree's look-up reads (docs/reference/formats.md, "Light grid"). A tree made of lists is checked to the
// last entry: what passes is a tree that ProbeTree::build gives for some verdicts, so no look-up can leave it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime_eval/light_grid/probe_tree.h"

namespace nlg {

struct ProbeTreeData {
  ProbeTreeFrame frame;
  // by node: the roots first, x fastest; the children of a node, then their descendants, in the order of forEachNode
  std::vector<uint64_t> child_mask;   // bit x + 4 y + 16 z: the cell is a child, not used itself
  std::vector<uint64_t> used_mask;    // the cell is used itself
  std::vector<uint32_t> first_child;  // node of the lowest bit of child_mask; of the next child to be, when there is none
  std::vector<uint32_t> first_slot;   // of the brick; 0 when used_mask is 0
  std::vector<uint8_t> cell_log2;     // side of a cell, units
  std::vector<uint8_t> cell_count;    // cells along an edge: 1 (roots only), 2, 4
  // by brick, in the order of nodes, (cell_count + 1)³ numbers each, x fastest: probe + 2^27 * probe_log2 of it, or kNoProbe
  std::vector<uint32_t> slots;
  std::vector<uint64_t> probe_keys;  // by probe: lattice point as a Morton code, x in bit 0; rising
  std::vector<uint8_t> probe_log2;   // by probe: of the largest cell that reads it, units

  // Bytes of all of it in a file.
  size_t byteCount() const;
};

ProbeTreeData probeTreeData(const ProbeTree& tree);

// The tree of some lists. Takes no more memory than they do.
// returns   an empty text, or what was expected and where: "node 17: first_child"; then *tree is empty
std::string makeProbeTree(ProbeTreeData data, ProbeTree* tree);

}  // namespace nlg
