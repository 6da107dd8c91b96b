// Segments and points that never change from probe to probe, packed as the segment tests read them, and the trees over packets.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nlg/support.h"
#include "runtime_eval/simd/aligned.h"

namespace nlg {

inline constexpr int kPacketLanes = 16;
inline constexpr int kTreeWidth = 8;
inline constexpr int kTreeLevels = 3;
inline constexpr int kLeafCount = 512;                  // kTreeWidth ^ kTreeLevels
inline constexpr int kNodeCount = 8 + 64 + kLeafCount;  // children of the root, their children, leaves
inline constexpr int kFirstLeaf = kNodeCount - kLeafCount;

// Boxes as centre and half extent, structure of arrays.
struct Boxes {
  std::array<AlignedFloats, 3> center, extent;
  void resize(size_t count);
  void set(size_t index, const LocalPoint& low, const LocalPoint& high);  // rounded outwards
};

// A fixed bounding-volume hierarchy, 8-wide and three levels deep, over packets of 16 items: the links or points of the support.
//
// Items never change from probe to probe, so that the tree is made once a process. Its leaves hold whole packets; an item's
// place is its index in packet order, packet i / 16, lane i % 16.
struct PacketTree {
  std::vector<uint32_t> order;  // item by place: a permutation, then the last item again until the last packet is full
  Boxes nodes;  // kNodeCount, and room to read whole vectors; the children of node i are 8 (i + 1) … 8 (i + 1) + 7, the root's
                // are 0 … 7
  Boxes packets;  // packet boxes, and 16 more that nothing touches, so that a leaf may be read in whole vectors
  std::array<uint32_t, kLeafCount + 1> first_packet{};  // of leaf l, node kFirstLeaf + l

  size_t packetCount() const { return order.size() / kPacketLanes; }
};

struct ItemBox {
  LocalPoint low, high;
};

// Splits the items by the median of their centres along the widest axis, again and again. At least one item.
PacketTree makePacketTree(const std::vector<ItemBox>& items);

// Segments by place of their tree.
struct LinkPackets {
  PacketTree tree;
  std::array<AlignedFloats, 3> from, to;  // local coordinates
  std::vector<uint32_t> from_point, to_point;
};
// pairs   from << 32 | to, indices into points; at least one
LinkPackets makeLinkPackets(const std::vector<LocalPoint>& points, const std::vector<uint64_t>& pairs);

struct PointPackets {
  PacketTree tree;
  std::array<AlignedFloats, 3> at;
};
// points   at least one
PointPackets makePointPackets(const std::vector<LocalPoint>& points);
// Of the support points; made once a process.
const PointPackets& supportPackets();

// Which points of a support are looked at.
enum class PointChoice {
  all,
  samples,  // octantSamples() of every octant: an eighth of the rays
};

// Points of a lattice cell in the coordinates of the probe at one of its corners, in the cell's order (cell_links.h).
struct CornerPackets {
  Boxes packets;  // at least packet_count, and 16
  std::array<AlignedFloats, 3> at;
  uint32_t packet_count = 0;  // with more points than these have, they begin anew, so that whole vectors may be read
};
// corner   bits as in SupportPattern
CornerPackets makeCornerPackets(int corner, PointChoice choice = PointChoice::all);

}  // namespace nlg
