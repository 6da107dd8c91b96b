// Numbers the probes of a tree: bricks, and one number for every lattice point that a used cell reads. Internal to
// ProbeTree::build and the reader of files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nlg/probe_tree.h"

namespace nlg {

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

}  // namespace nlg
