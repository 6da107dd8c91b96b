// The tree of probes over a level, and the look-up of the 8 probes around a position.
//
// Probes stand on an integer lattice of the finest spacing: lattice point i lies at first_m + spacing_m * i. A regular array of
// root nodes, 64 units wide, covers the extent. Each is a tree of at most 3 levels that splits every axis in 4: nodes are 64, 16
// and 4 units wide. A node's brick of 2³, 3³ or 5³ probes cuts it into cells of its whole, half or quarter width, so that cell
// sides are powers of two from 1 to 64 units. The cells of a 5³ brick coincide with the node's 64 children; each cell is a child,
// is used, or is left out if no look-up needs it. Borders between levels: docs/theory/probes.md.
//
// A built tree is constant: any number of threads may look up. A look-up allocates nothing and cannot fail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "nlg/support.h"

namespace nlg {

using LatticePoint = std::array<int32_t, 3>;
using PositionM = std::array<double, 3>;  // metres, in the frame of ProbeTreeFrame::first_m

inline constexpr int32_t kRootSide = 64;                    // units
inline constexpr int32_t kMaxLatticeSide = (1 << 21) - 64;  // units along an axis, over all roots
inline constexpr uint32_t kNoProbe = 0xffffffffu;           // in place of an index: no probe
inline constexpr uint64_t kMaxTreeProbes = 1ull << 27;      // of one tree

struct ProbeTreeFrame {
  PositionM first_m{};                  // the lattice point (0, 0, 0); finite
  double spacing_m = 1.0;               // one unit: the finest spacing; finite, > 0
  std::array<int32_t, 3> root_count{};  // roots along each axis; >= 0, and 64 root_count <= kMaxLatticeSide
};

// A cube of the lattice: [low, low + side) along each axis.
struct ProbeCell {
  LatticePoint low{};
  int32_t side = 1;  // units: 1, 2, 4, … 64
  bool operator==(const ProbeCell&) const = default;
};

// Verdict on a cell that the builder may use.
enum class CellVerdict : uint8_t {
  unneeded,    // no look-up inside this cube
  fits,        // 8 probes, a cell's side apart, are enough
  too_coarse,  // smaller cells are needed; a cell of side 1 is used nevertheless
};
// Must be a pure function of the cell.
using CellJudge = std::function<CellVerdict(const ProbeCell&)>;

enum class ProbeTreeStatus {
  ok,
  invalid_frame,    // a number of the frame lies outside its range
  too_many_probes,  // the tree would hold more probes than the limit; detected before it takes much more memory than these
};

// One of the 8 probes around a position.
struct ProbeAround {
  uint32_t probe = kNoProbe;  // index, < probeCount()
  LocalPoint local{};         // the position in the probe's own support, in [-1, 1]³
  float tent_ratio = 1.0f;    // in [0, 1]: the cell's tent over the tent of the probe's own support; 1 inside one level
};

// The cell around a position and the probes at its 8 corners. Bits 0, 1, 2 of a corner's index are set on the high side in x, y,
// z. The sum over the corners of tent(local) * tent_ratio is 1; a weight φ(local) * tent_ratio fades to 0 at the faces that the
// probe is not on.
struct ProbesAround {
  ProbeCell cell;
  std::array<ProbeAround, 8> corners;
};

// The cell of a position, for ProbeTree::cornersOf, and the position in it. For look-ups of many positions that share cells.
struct CellPlace {
  uint32_t first_slot = 0;  // identifies the cell: unique in a tree
  uint8_t edge = 0;         // slots along an edge of the cell's brick; 0: no cell
  uint8_t cell_log2 = 0;    // log2 of the side, units
  LocalPoint from_low{};    // in shares of the cell's side, [0, 1]
};

// The probes of a cell, in the order of ProbesAround's corners.
struct CellCorners {
  uint32_t probe[8];
  uint8_t spacing_log2[8];  // log2 of the probe's spacing over the cell's side: 0 inside one level, up to 6 elsewhere
};

// A node, for drawing.
struct ProbeNode {
  LatticePoint low{};
  int32_t side = kRootSide;  // units: 64, 16, 4
  int level = 0;             // 0, 1, 2
  int brick_side = 2;        // probes along an edge of its brick: 2, 3, 5; 0: the node is not needed
};

class ProbeTree {
 public:
  // Builds a tree. A node takes the smallest brick whose cells all fit; cells of a 5³ brick that are too coarse become children,
  // and at the last level are used nevertheless. Probes that no used cell reads are left out; a probe of several bricks is stored
  // once. The same frame and verdicts give the same tree, bit for bit.
  //
  // judge         a pure function of the cell
  // probe_limit   <= kMaxTreeProbes, as 1000000
  // tree          overwritten; empty on failure
  static ProbeTreeStatus build(const ProbeTreeFrame& frame, const CellJudge& judge, uint64_t probe_limit, ProbeTree* tree);

  // Moves all probes, for instance from coordinates around a scene's middle to world coordinates.
  // by_m   metres; finite, and the frame's first_m must stay finite
  void moveBy(const PositionM& by_m) {
    for (int axis = 0; axis < 3; ++axis) frame_.first_m[axis] += by_m[axis];
  }

  const ProbeTreeFrame& frame() const { return frame_; }
  size_t probeCount() const { return probe_keys_.size(); }
  size_t nodeCount() const { return nodes_.size(); }
  size_t cellCount() const { return cell_count_; }  // cells in use
  size_t byteCount() const;                         // memory of the tree, bytes

  // Return the position of a probe, on the lattice and in metres. Probes are numbered along a Morton curve: neighbours in space
  // are neighbours in memory.
  // index   < probeCount()
  LatticePoint probeLattice(size_t index) const;
  PositionM probePosition(size_t index) const;
  // Returns half the side of a probe's support, metres: the largest side of the cells that it is a corner of, so that the support
  // covers them.
  float probeSpacing(size_t index) const;

  // Finds the cell around a position and its 8 probes. Cells are half open: a position on the face between two is in the upper
  // one.
  // returns   false, with *around unchanged, if no cell holds the position: it is outside the roots, in a cell that was left out,
  //           or not finite
  bool lookUp(const PositionM& position_m, ProbesAround* around) const;

  // The two halves of lookUp, for many positions: findCells finds their cells, with edge 0 where lookUp returns false, and
  // cornersOf returns the probes of one.
  // places   count results, overwritten
  void findCells(const PositionM* positions_m, size_t count, CellPlace* places) const;
  CellCorners cornersOf(const CellPlace& place) const;

  // As lookUp; a position in no cell is moved to the nearest point of a used cell, if one is less than one unit away along every
  // axis.
  // returns   false, with *around unchanged, if there is none, or the position is not finite
  bool lookUpNear(const PositionM& position_m, ProbesAround* around) const;

  // Visit all nodes, parents first, and all cells in use, in a fixed order.
  void forEachNode(const std::function<void(const ProbeNode&)>& visit) const;
  void forEachCell(const std::function<void(const ProbeCell&)>& visit) const;

 private:
  friend class ProbeTreeBuilder;
  friend class ProbeTreeNumbering;
  friend class ProbeTreeAccess;

  static constexpr int kIndexBits = 27;
  static_assert(kMaxTreeProbes == uint64_t{1} << kIndexBits);

  struct Node {
    uint64_t child_mask = 0;   // bit x + 4 y + 16 z: the cell is a child; children are numbered on from first_child
    uint64_t used_mask = 0;    // the cell is used itself
    uint32_t first_child = 0;  // index into nodes_
    uint32_t first_slot = 0;   // of the brick, index into slots_; set when used_mask is not 0
    uint8_t cell_log2 = 0;     // side of a cell
    uint8_t cell_count = 1;    // cells along an edge: 1, 2, 4; 0: not needed at all
  };

  bool isOnLattice(const LatticePoint& unit) const;
  bool unitsOf(const PositionM& position_m, PositionM* units, LatticePoint* unit) const;
  bool findCellOfUnit(const LatticePoint& unit, const PositionM& units, CellPlace* place) const;
  static void placeIn(const LatticePoint& unit, const PositionM& units, CellPlace* place);
  ProbesAround aroundOf(const LatticePoint& unit, const CellPlace& place) const;

  using NodeVisit = std::function<void(const ProbeNode&, uint32_t node_idx)>;
  void visitAllNodes(const NodeVisit& visit) const;
  void visitNodes(uint32_t node_idx, const ProbeNode& place, const NodeVisit& visit) const;
  static ProbeCell cellOf(const LatticePoint& node_low, int bit, int cell_log2);

  ProbeTreeFrame frame_;
  std::vector<Node> nodes_;  // the roots first, x fastest
  // bricks, x fastest: a probe's index with probe_log2_ of it above, or kNoProbe for one that is left out
  std::vector<uint32_t> slots_;
  std::vector<uint64_t> probe_keys_;  // lattice coordinates as Morton codes, rising
  std::vector<uint8_t> probe_log2_;   // of the spacing, units
  size_t cell_count_ = 0;
};

}  // namespace nlg
