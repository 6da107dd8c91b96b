// Random probe trees, and what a tree must be by its definition alone, for tests.
#pragma once

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "nlg/probe_tree.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

struct RandomTree {
  ProbeTreeFrame frame;
  CellJudge judge;
  ProbeTree tree;
  std::string name;  // to print
};

// Any verdict for any cell: level borders of every kind, 64 to 1 included.
inline CellJudge wildJudge(uint64_t seed) {
  return [seed](const ProbeCell& cell) {
    const auto low = [&](int axis) { return static_cast<uint64_t>(cell.low[axis]) << 8; };
    Random random(mixSeed(seed, low(0) + static_cast<uint64_t>(cell.side), low(1), low(2)));
    if (random.chance(0.1)) return CellVerdict::unneeded;
    return random.chance(cell.side >= 32 ? 0.8 : 0.3) ? CellVerdict::too_coarse : CellVerdict::fits;
  };
}

// Cells that grow with the distance from a few points, inside a box.
inline CellJudge pointsJudge(uint64_t seed, const std::array<int32_t, 3>& root_count) {
  Random random(seed);
  const auto coordinate = [&](int axis) {
    return static_cast<int32_t>(random.below(1u + 64u * static_cast<uint32_t>(root_count[axis])));
  };
  LatticePoint low, high;
  std::vector<LatticePoint> points;
  points.reserve(3);
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = coordinate(axis), high[axis] = coordinate(axis);
    if (low[axis] > high[axis]) std::swap(low[axis], high[axis]);
  }
  for (int i = 0; i < 3; ++i) points.push_back({coordinate(0), coordinate(1), coordinate(2)});
  return [=](const ProbeCell& cell) {
    int32_t nearest = kMaxLatticeSide;
    for (const LatticePoint& point : points) {
      int32_t distance = 0;
      for (int axis = 0; axis < 3; ++axis)
        distance = std::max({distance, cell.low[axis] - point[axis], point[axis] - cell.low[axis] - cell.side});
      nearest = std::min(nearest, distance);
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (cell.low[axis] > high[axis] || cell.low[axis] + cell.side <= low[axis]) return CellVerdict::unneeded;
    }
    return nearest < 2 * cell.side ? CellVerdict::too_coarse : CellVerdict::fits;
  };
}

inline RandomTree randomTree(uint64_t seed) {
  Random random(mixSeed(seed, 0x74657374));
  RandomTree result;
  const bool is_wild = seed % 2 == 0;
  result.name = (is_wild ? "wild tree " : "tree around points ") + std::to_string(seed);
  for (int axis = 0; axis < 3; ++axis) {
    result.frame.root_count[axis] = 1 + static_cast<int32_t>(random.below(2));
    // up to 100 km away
    result.frame.first_m[axis] = random.uniform(-1.0, 1.0) * (seed % 3 == 0 ? 1e5 : 10.0);
  }
  result.frame.spacing_m = random.uniform(0.5, 2.0);
  result.judge = is_wild ? wildJudge(seed) : pointsJudge(seed, result.frame.root_count);
  ProbeTree::build(result.frame, result.judge, kMaxTreeProbes, &result.tree);
  return result;
}

// The cells of a tree by the words of its header, without the tree's own arithmetic.
inline void addExpectedCells(const CellJudge& judge, const ProbeCell& node, bool is_root, std::vector<ProbeCell>& cells) {
  const auto parts = [&](int count) {
    std::vector<ProbeCell> result;
    for (int z = 0; z < count; ++z)
      for (int y = 0; y < count; ++y)
        for (int x = 0; x < count; ++x) {
          const int32_t side = node.side / count;
          result.push_back({{node.low[0] + x * side, node.low[1] + y * side, node.low[2] + z * side}, side});
        }
    return result;
  };
  for (const int count : {1, 2}) {
    const std::vector<ProbeCell> bricks_cells = parts(count);
    const auto is_coarse = [&](const ProbeCell& cell) { return judge(cell) == CellVerdict::too_coarse; };
    if ((count == 1 && !is_root) || std::any_of(bricks_cells.begin(), bricks_cells.end(), is_coarse)) continue;
    for (const ProbeCell& cell : bricks_cells) {
      if (judge(cell) == CellVerdict::fits) cells.push_back(cell);
    }
    return;
  }
  for (const ProbeCell& cell : parts(4)) {
    const CellVerdict verdict = judge(cell);
    if (verdict == CellVerdict::unneeded) continue;
    if (verdict == CellVerdict::fits || node.side == 4)
      cells.push_back(cell);
    else
      addExpectedCells(judge, cell, false, cells);
  }
}

inline std::vector<ProbeCell> expectedCells(const ProbeTreeFrame& frame, const CellJudge& judge) {
  std::vector<ProbeCell> cells;
  for (int32_t z = 0; z < frame.root_count[2]; ++z)
    for (int32_t y = 0; y < frame.root_count[1]; ++y)
      for (int32_t x = 0; x < frame.root_count[0]; ++x) addExpectedCells(judge, {{64 * x, 64 * y, 64 * z}, 64}, true, cells);
  return cells;
}

inline LatticePoint cornerOf(const ProbeCell& cell, int c) {
  return {cell.low[0] + cell.side * (c & 1), cell.low[1] + cell.side * (c >> 1 & 1), cell.low[2] + cell.side * (c >> 2)};
}

inline PositionM positionAt(const ProbeTreeFrame& frame, const std::array<double, 3>& units) {
  PositionM position_m;
  for (int axis = 0; axis < 3; ++axis) position_m[axis] = frame.first_m[axis] + frame.spacing_m * units[axis];
  return position_m;
}

}  // namespace nlg
