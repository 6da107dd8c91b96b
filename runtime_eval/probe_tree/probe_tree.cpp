// ProbeTree::build: nodes from the judge's verdicts, then their probes.

#include "nlg/probe_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "runtime_eval/probe_tree/morton.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"

namespace nlg {
namespace {

// Without the instruction, which not every machine of the build's base has, std::popcount is a call.
uint32_t countBits(uint64_t bits) {
  bits -= bits >> 1 & 0x5555555555555555u;
  bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu;
  return static_cast<uint32_t>(bits * 0x0101010101010101u >> 56);
}

// Whether what is computed of a position is a number that an integer can hold: compilers convert before they compare. Of NaN this is
// false, and other than <= it raises nothing, which engines may trap.
bool isNear(const ProbeTreeFrame& frame, const PositionM& position_m) {
  const auto fits = [&](size_t axis) {
    return std::islessequal(std::abs(position_m[axis] - frame.first_m[axis]), 1e9 * frame.spacing_m);
  };
  return fits(0) && fits(1) && fits(2);
}

}  // namespace

size_t ProbeTree::byteCount() const {
  return sizeof(*this) + nodes_.capacity() * sizeof(Node) + slots_.capacity() * sizeof(uint32_t) +
         probe_keys_.capacity() * sizeof(uint64_t) + probe_log2_.capacity();
}

LatticePoint ProbeTree::probeLattice(size_t index) const { return latticeFromMorton(probe_keys_[index]); }

PositionM ProbeTree::probePosition(size_t index) const {
  const LatticePoint lattice = probeLattice(index);
  PositionM position_m;
  for (int axis = 0; axis < 3; ++axis) position_m[axis] = frame_.first_m[axis] + frame_.spacing_m * lattice[axis];
  return position_m;
}

float ProbeTree::probeSpacing(size_t index) const { return static_cast<float>(frame_.spacing_m * (1 << probe_log2_[index])); }

bool ProbeTree::lookUp(const PositionM& position_m, ProbesAround* around) const {
  PositionM units;
  LatticePoint unit;
  CellPlace place;
  if (!unitsOf(position_m, &units, &unit) || !findCellOfUnit(unit, units, &place)) return false;
  *around = aroundOf(unit, place);
  return true;
}

void ProbeTree::findCells(const PositionM* positions_m, size_t count, CellPlace* places) const {
  PositionM units;
  LatticePoint unit, before{};
  const CellPlace* same = nullptr;  // the last cell that was found, which holds the unit `before`
  for (size_t i = 0; i < count; ++i) {
    places[i] = {};
    if (!unitsOf(positions_m[i], &units, &unit)) continue;
    const auto differs = [&](int axis) { return static_cast<uint32_t>(unit[axis] ^ before[axis]) >> same->cell_log2; };
    if (same != nullptr && (differs(0) | differs(1) | differs(2)) == 0) {
      places[i] = *same;
      placeIn(unit, units, &places[i]);
    } else if (!findCellOfUnit(unit, units, &places[i])) {
      continue;
    }
    same = &places[i];
    before = unit;
  }
}

bool ProbeTree::lookUpNear(const PositionM& position_m, ProbesAround* around) const {
  if (!isNear(frame_, position_m)) return false;
  if (lookUp(position_m, around)) return true;
  PositionM units;
  LatticePoint unit;
  // more than a unit beyond the roots no cell is near enough
  for (int axis = 0; axis < 3; ++axis) {
    units[axis] = (position_m[axis] - frame_.first_m[axis]) / frame_.spacing_m;
    if (!(units[axis] > -1.0 && units[axis] < kRootSide * frame_.root_count[axis] + 1.0)) return false;
    unit[axis] = static_cast<int32_t>(std::floor(units[axis]));
  }
  // a used cell holds whole units: the nearest of the 26 around is as near as the nearest cell
  double least_distance = HUGE_VAL;
  for (int step = 0; step < 27; ++step) {
    const LatticePoint near{unit[0] + step % 3 - 1, unit[1] + step / 3 % 3 - 1, unit[2] + step / 9 - 1};
    if (!isOnLattice(near)) continue;
    PositionM nearest;
    double distance = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      nearest[axis] = std::clamp(units[axis], near[axis] + 0.0, near[axis] + 1.0);
      distance += (units[axis] - nearest[axis]) * (units[axis] - nearest[axis]);
    }
    CellPlace place;
    if (distance >= least_distance || !findCellOfUnit(near, nearest, &place)) continue;
    least_distance = distance;
    *around = aroundOf(near, place);
  }
  return least_distance < HUGE_VAL;
}

bool ProbeTree::isOnLattice(const LatticePoint& unit) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (unit[axis] < 0 || unit[axis] >= kRootSide * frame_.root_count[axis]) return false;
  }
  return true;
}

// false where the position is on no root
bool ProbeTree::unitsOf(const PositionM& position_m, PositionM* units, LatticePoint* unit) const {
  if (!isNear(frame_, position_m)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const double along = (position_m[axis] - frame_.first_m[axis]) / frame_.spacing_m;
    if (!(along >= 0.0 && along < kRootSide * frame_.root_count[axis])) return false;
    (*units)[axis] = along;
    (*unit)[axis] = static_cast<int32_t>(along);
  }
  return true;
}

// unit    on the lattice: which cell is read
// units   the position, in the closed cube [unit, unit + 1]
bool ProbeTree::findCellOfUnit(const LatticePoint& unit, const PositionM& units, CellPlace* place) const {
  // roots are an array: the first step is an index
  const auto root = [&](int axis) { return static_cast<uint32_t>(unit[axis] / kRootSide); };
  const auto roots = [&](int axis) { return static_cast<uint32_t>(frame_.root_count[axis]); };
  const Node* node = &nodes_[(root(2) * roots(1) + root(1)) * roots(0) + root(0)];

  // down while the cell is a child
  std::array<uint32_t, 3> in_node;
  uint64_t cell_bit;
  for (;;) {
    for (int axis = 0; axis < 3; ++axis)
      in_node[axis] = static_cast<uint32_t>(unit[axis] >> node->cell_log2) & (node->cell_count - 1u);
    cell_bit = uint64_t{1} << (in_node[0] + 4 * in_node[1] + 16 * in_node[2]);
    if (!(node->child_mask & cell_bit)) break;
    node = &nodes_[node->first_child + countBits(node->child_mask & (cell_bit - 1))];
  }
  if (!(node->used_mask & cell_bit)) return false;

  // where the cell's low corner stands among the slots of its brick
  const uint32_t edge = node->cell_count + 1u;
  place->first_slot = node->first_slot + (in_node[2] * edge + in_node[1]) * edge + in_node[0];
  place->edge = static_cast<uint8_t>(edge);
  place->cell_log2 = node->cell_log2;
  placeIn(unit, units, place);
  return true;
}

// Where in its cell a position lies.
void ProbeTree::placeIn(const LatticePoint& unit, const PositionM& units, CellPlace* place) {
  const int32_t side = 1 << place->cell_log2;
  const double per_side = 1.0 / side;  // exact, a power of two
  for (int axis = 0; axis < 3; ++axis)
    place->from_low[axis] = static_cast<float>((units[axis] - (unit[axis] & -side)) * per_side);
}

CellCorners ProbeTree::cornersOf(const CellPlace& place) const {
  CellCorners corners;
  const uint32_t edge = place.edge;
  const uint32_t* slot = &slots_[place.first_slot];
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t probe = slot[(c & 1) + (c >> 1 & 1) * edge + (c >> 2) * edge * edge];
    corners.probe[c] = probe & (kMaxTreeProbes - 1);
    corners.spacing_log2[c] = static_cast<uint8_t>((probe >> kIndexBits) - place.cell_log2);
  }
  return corners;
}

ProbesAround ProbeTree::aroundOf(const LatticePoint& unit, const CellPlace& place) const {
  ProbesAround around;
  around.cell.side = 1 << place.cell_log2;
  for (int axis = 0; axis < 3; ++axis) around.cell.low[axis] = unit[axis] & -around.cell.side;
  const CellCorners corners = cornersOf(place);
  for (uint32_t c = 0; c < 8; ++c) {
    ProbeAround& corner = around.corners[c];
    corner.probe = corners.probe[c];
    const float cell_per_spacing = 1.0f / static_cast<float>(1 << corners.spacing_log2[c]);
    corner.tent_ratio = 1.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_high = c >> axis & 1;
      const float distance = is_high ? 1.0f - place.from_low[axis] : place.from_low[axis];
      const float local = distance * cell_per_spacing;
      corner.local[axis] = is_high ? -local : local;
      // a probe of a coarser spacing has too wide a tent for this cell: ρ (docs/theory/probes.md)
      if (cell_per_spacing < 1.0f) corner.tent_ratio *= (1.0f - distance) / (1.0f - local);
    }
  }
  return around;
}

ProbeCell ProbeTree::cellOf(const LatticePoint& node_low, int bit, int cell_log2) {
  ProbeCell cell{node_low, 1 << cell_log2};
  for (int axis = 0; axis < 3; ++axis) cell.low[axis] += cell.side * (bit >> 2 * axis & 3);
  return cell;
}

void ProbeTree::visitNodes(uint32_t node_idx, const ProbeNode& place, const NodeVisit& visit) const {
  const Node& node = nodes_[node_idx];
  visit(place, node_idx);
  uint32_t child_idx = node.first_child;
  for (uint64_t mask = node.child_mask; mask != 0; mask &= mask - 1) {
    const ProbeCell child = cellOf(place.low, std::countr_zero(mask), node.cell_log2);
    visitNodes(child_idx, {child.low, child.side, place.level + 1, nodes_[child_idx].cell_count + 1}, visit);
    ++child_idx;
  }
}

void ProbeTree::visitAllNodes(const NodeVisit& visit) const {
  uint32_t root_idx = 0;
  for (int32_t z = 0; z < frame_.root_count[2]; ++z) {
    for (int32_t y = 0; y < frame_.root_count[1]; ++y) {
      for (int32_t x = 0; x < frame_.root_count[0]; ++x, ++root_idx) {
        const Node& root = nodes_[root_idx];
        const bool is_needed = (root.child_mask | root.used_mask) != 0;
        visitNodes(root_idx, {{x * kRootSide, y * kRootSide, z * kRootSide}, kRootSide, 0, is_needed ? root.cell_count + 1 : 0},
                   visit);
      }
    }
  }
}

void ProbeTree::forEachNode(const std::function<void(const ProbeNode&)>& visit) const {
  visitAllNodes([&](const ProbeNode& place, uint32_t) { visit(place); });
}

void ProbeTree::forEachCell(const std::function<void(const ProbeCell&)>& visit) const {
  visitAllNodes([&](const ProbeNode& place, uint32_t node_idx) {
    const Node& node = nodes_[node_idx];
    for (uint64_t mask = node.used_mask; mask != 0; mask &= mask - 1)
      visit(cellOf(place.low, std::countr_zero(mask), node.cell_log2));
  });
}

class ProbeTreeBuilder {
 public:
  ProbeTreeBuilder(const CellJudge& judge, uint64_t probe_limit, ProbeTree& tree)
      : judge_(judge), probe_limit_(probe_limit), tree_(tree) {}

  // false: too many probes
  bool build() {
    const std::array<int32_t, 3>& roots = tree_.frame_.root_count;
    tree_.nodes_.resize(static_cast<size_t>(roots[0]) * roots[1] * roots[2]);
    uint32_t root_idx = 0;
    for (int32_t z = 0; z < roots[2]; ++z) {
      for (int32_t y = 0; y < roots[1]; ++y) {
        for (int32_t x = 0; x < roots[0]; ++x, ++root_idx) {
          if (!addNode(root_idx, {{x * kRootSide, y * kRootSide, z * kRootSide}, kRootSide}, 0)) return false;
        }
      }
    }
    // bricks only now: a tree that is too large is known by its nodes, long before its probes are
    tree_.nodes_.shrink_to_fit();
    return ProbeTreeNumbering(probe_limit_, tree_).number();
  }

 private:
  static constexpr int kLastLevel = 2;

  bool addNode(uint32_t node_idx, const ProbeCell& cube, int level) {
    ProbeTree::Node node;
    chooseBrick(cube, level, node);
    // every used cell has a low corner that no other has: there are at least as many probes
    tree_.cell_count_ += static_cast<size_t>(std::popcount(node.used_mask));
    if (tree_.cell_count_ > probe_limit_) return false;
    const size_t first_child = tree_.nodes_.size();
    node.first_child = static_cast<uint32_t>(first_child);
    tree_.nodes_[node_idx] = node;
    tree_.nodes_.resize(first_child + static_cast<size_t>(std::popcount(node.child_mask)));
    if (tree_.nodes_.size() > 2 * probe_limit_ + kMinLimit) return false;
    uint32_t child_idx = node.first_child;
    for (uint64_t mask = node.child_mask; mask != 0; mask &= mask - 1) {
      if (!addNode(child_idx++, ProbeTree::cellOf(cube.low, std::countr_zero(mask), node.cell_log2), level + 1)) return false;
    }
    return true;
  }

  // The smallest brick whose cells fit. A node below the roots exists because one cell is too coarse for it.
  void chooseBrick(const ProbeCell& cube, int level, ProbeTree::Node& node) {
    const bool asks_quarters = (level > 0 || !tryCells(cube, 1, node)) && !tryCells(cube, 2, node);
    if (!asks_quarters) return;
    tryCells(cube, 4, node);
    if (level == kLastLevel) node.used_mask |= std::exchange(node.child_mask, 0);
  }

  // Cuts the cube into cell_count cells along an edge. false as soon as one is too coarse, but for quarters, where it is a child.
  bool tryCells(const ProbeCell& cube, int cell_count, ProbeTree::Node& node) {
    node = {};
    node.cell_count = static_cast<uint8_t>(cell_count);
    node.cell_log2 = static_cast<uint8_t>(std::countr_zero(static_cast<uint32_t>(cube.side / cell_count)));
    for (int bit = 0; bit < 64; ++bit) {
      if ((bit & 3) >= cell_count || (bit >> 2 & 3) >= cell_count || bit >> 4 >= cell_count) continue;
      const CellVerdict verdict = judge_(ProbeTree::cellOf(cube.low, bit, node.cell_log2));
      if (verdict == CellVerdict::too_coarse && cell_count < 4) return false;
      if (verdict == CellVerdict::too_coarse) node.child_mask |= uint64_t{1} << bit;
      if (verdict == CellVerdict::fits) node.used_mask |= uint64_t{1} << bit;
    }
    return true;
  }

  static constexpr uint64_t kMinLimit = 1 << 10;  // nodes that any tree may have
  const CellJudge& judge_;
  uint64_t probe_limit_;
  ProbeTree& tree_;
};

ProbeTreeStatus ProbeTree::build(const ProbeTreeFrame& frame, const CellJudge& judge, uint64_t probe_limit, ProbeTree* tree) {
  *tree = {};
  uint64_t root_count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_valid = std::isfinite(frame.first_m[axis]) && frame.root_count[axis] >= 0 &&
                          frame.root_count[axis] <= kMaxLatticeSide / kRootSide;
    if (!is_valid) return ProbeTreeStatus::invalid_frame;
    root_count *= static_cast<uint64_t>(frame.root_count[axis]);
  }
  if (!(std::isfinite(frame.spacing_m) && frame.spacing_m > 0.0)) return ProbeTreeStatus::invalid_frame;
  probe_limit = std::min(probe_limit, kMaxTreeProbes);
  if (root_count > probe_limit) return ProbeTreeStatus::too_many_probes;
  tree->frame_ = frame;
  if (ProbeTreeBuilder(judge, probe_limit, *tree).build()) return ProbeTreeStatus::ok;
  *tree = {};
  return ProbeTreeStatus::too_many_probes;
}

}  // namespace nlg
