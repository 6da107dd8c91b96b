// Segments and points that never change from probe to probe, packed as the segment tests read them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/visibility/packet_tree.h"

namespace nlg {

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
