// The support points of a lattice cell, and their links to each other and to those of the cells around.
//
// The eight probes of a cell sample it at the same 1024 points: the pattern's first octant, seen from the cell's low corner
// (nlg/support.h). Continued from cell to cell they are one periodic pattern. A link joins a point and one of its 32 nearest, over borders
// of cells, too; what lies between two points is asked once, whichever probes read it. Test points have links of their own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/visibility/segment_kernel.h"

namespace nlg {

inline constexpr int kLinkCount = 32;
// Groups of points are carried along each point's 16 nearest links.
inline constexpr int kCarryingLinkCount = 16;

// A cell's eight corners: bits 0, 1, 2 of a corner are set on the high side in x, y, z. The cell is the octant of that number, of the probe
// at that corner.
inline constexpr int kCellCorners = kMirrorCount;

// A set of a cell's points, a bit each.
struct CellPoints {
  static const CellPoints& all();
  static const CellPoints& none();

  bool has(size_t point) const { return words[point / 64] >> (point % 64) & 1; }
  void add(size_t point) { words[point / 64] |= uint64_t{1} << (point % 64); }
  void remove(size_t point) { words[point / 64] &= ~(uint64_t{1} << (point % 64)); }
  void operator|=(const CellPoints& other);
  void operator&=(const CellPoints& other);
  bool operator==(const CellPoints&) const = default;

  // Calls visit(point) for every point outside the set, rising.
  template <class Visit>
  void forEachOther(const Visit& visit) const {
    for (size_t w = 0; w < words.size(); ++w) {
      for (uint64_t others = ~words[w]; others != 0; others &= others - 1)
        visit(64 * w + static_cast<size_t>(__builtin_ctzll(others)));
    }
  }

  std::array<uint64_t, kOctantPointCount / 64> words{};
};

struct CellLinks {
  struct Edge {
    uint16_t point;              // at the other end, in its own cell
    uint16_t link;               // place in packets
    std::array<int8_t, 3> away;  // that cell, -1 … 1 along each axis
    bool is_theirs;              // the link is that cell's: of two cells the lower one has it, by z, then y, then x
  };
  struct InnerEdge {
    uint16_t point, link;
  };

  // By corner and point i of the octant there, in the order of the support pattern: the cell's point. The same the other way round.
  std::array<std::array<uint16_t, kOctantPointCount>, kCellCorners> point_of;
  std::vector<Edge> nearest;          // 1024 x 32, nearest first; lists of mirrored points are mirrored
  std::vector<float> distance;        // 1024 x 32, in spacings; below 1/4
  std::vector<uint32_t> first_inner;  // 1024 + 1: the carrying links of a point that stay in its cell
  std::vector<InnerEdge> inner;       // each at both its ends
  LinkPackets packets;                // 16,932 links, in the frame of the cube below
};

// Half the side, in spacings, of the cube around a cell's middle that holds all its links: the local unit of packets.
inline constexpr double kCellReach = 0.75;

// Made once a process; the first call takes some 30 ms.
const CellLinks& cellLinks();

// Where a cell's point lies, in spacings from the cell's low corner: exact.
const LocalPoint& cellPoint(size_t point);

// --- further points of a support, which read from its support points and from which none of them reads: test points

inline constexpr int kMaxTestPointCount = 65536 - kSupportPointCount;

// The 32 support points nearest to any place, nearest first: the links that a further point there has.
struct NearestPoints {
  std::array<uint32_t, kLinkCount> point;
  std::array<float, kLinkCount> distance;  // local units
};
NearestPoints nearestSupportPoints(const LocalPoint& place);

struct TestLinks {
  std::vector<LocalPoint> points;  // U, local coordinates
  std::vector<NearestPoints> nearest;
  PointPackets point_packets;  // none without points, and …
  LinkPackets link_packets;
  std::vector<uint32_t> place;  // U x 32: of each link in link_packets
};

// points   at most kMaxTestPointCount
TestLinks makeTestLinks(const std::vector<LocalPoint>& points);

}  // namespace nlg
