
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/runtime_eval/probe_tree/random_tree.h"

namespace nlg {
namespace {

constexpr uint64_t kTreeCount = 12;

bool byLow(const ProbeCell& a, const ProbeCell& b) { return a.low < b.low; }

std::vector<ProbeCell> cellsOf(const ProbeTree& tree) {
  std::vector<ProbeCell> cells;
  tree.forEachCell([&](const ProbeCell& cell) { cells.push_back(cell); });
  return cells;
}

std::string printed(const ProbeCell& cell) {
  return "cell (" + std::to_string(cell.low[0]) + ", " + std::to_string(cell.low[1]) + ", " + std::to_string(cell.low[2]) +
         ") of side " + std::to_string(cell.side);
}

// A position well inside a cell, so that rounding does not move it into the next.
std::array<double, 3> unitsInside(const ProbeCell& cell, Random& random) {
  std::array<double, 3> units;
  for (int axis = 0; axis < 3; ++axis) units[axis] = cell.low[axis] + cell.side * random.uniform(1e-6, 1.0 - 1e-6);
  return units;
}

// Calls check with every tree, and a cell, a position in it (in units) and its probes, for a fair sample of the tree's cells.
template <class Check>
void forManyLookUps(const Check& check) {
  for (uint64_t seed = 0; seed < kTreeCount; ++seed) {
    const RandomTree random_tree = randomTree(seed);
    const ProbeTree& tree = random_tree.tree;
    Random random(seed);
    const std::vector<ProbeCell> cells = cellsOf(tree);
    for (size_t i = 0; i < cells.size(); i += 1 + cells.size() / 4000) {
      SCOPED_TRACE(random_tree.name + ", " + printed(cells[i]));
      const std::array<double, 3> units = unitsInside(cells[i], random);
      ProbesAround around;
      ASSERT_TRUE(tree.lookUp(positionAt(tree.frame(), units), &around));
      check(tree, cells[i], units, around);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// What a user computes: the field at the 8 probes, by the cell's tents.
template <class Field>
double interpolated(const ProbeTree& tree, const ProbesAround& around, const Field& field) {
  double sum = 0.0;
  for (const ProbeAround& corner : around.corners) {
    const LatticePoint p = tree.probeLattice(corner.probe);
    sum +=
        double{tent(corner.local)} * corner.tent_ratio * field(std::array<double, 3>{double(p[0]), double(p[1]), double(p[2])});
  }
  return sum;
}

// Looks up on both sides of the plane `face` of an axis; false when one of them is outside.
bool cellAcross(const ProbeTree& tree, std::array<double, 3> units, int axis, double face, ProbesAround* below,
                ProbesAround* above) {
  constexpr double kStep = 1e-7;
  units[axis] = face - kStep;
  if (!tree.lookUp(positionAt(tree.frame(), units), below)) return false;
  units[axis] = face + kStep;
  return tree.lookUp(positionAt(tree.frame(), units), above);
}

TEST(ProbeTree, HasTheCellsOfItsDefinition) {
  for (uint64_t seed = 0; seed < kTreeCount; ++seed) {
    const RandomTree random_tree = randomTree(seed);
    std::vector<ProbeCell> cells = cellsOf(random_tree.tree), expected = expectedCells(random_tree.frame, random_tree.judge);
    std::sort(cells.begin(), cells.end(), byLow);
    std::sort(expected.begin(), expected.end(), byLow);
    EXPECT_EQ(cells.size(), random_tree.tree.cellCount()) << random_tree.name;
    EXPECT_TRUE(cells == expected) << random_tree.name << ": " << cells.size() << " cells, not " << expected.size();
  }
}

TEST(ProbeTree, LookUpIsOutsideExactlyWhereNoCellIs) {
  for (uint64_t seed = 0; seed < kTreeCount; ++seed) {
    const RandomTree random_tree = randomTree(seed);
    const ProbeTreeFrame& frame = random_tree.frame;
    // every unit cube that a cell covers
    std::vector<bool> is_used(size_t{128} * 128 * 128, false);
    const auto cube = [](int32_t x, int32_t y, int32_t z) { return (size_t(z) * 128 + size_t(y)) * 128 + size_t(x); };
    for (const ProbeCell& cell : expectedCells(frame, random_tree.judge)) {
      for (int32_t z = 0; z < cell.side; ++z)
        for (int32_t y = 0; y < cell.side; ++y)
          for (int32_t x = 0; x < cell.side; ++x) is_used[cube(cell.low[0] + x, cell.low[1] + y, cell.low[2] + z)] = true;
    }
    Random random(seed);
    ProbesAround around;
    for (int i = 0; i < 20000; ++i) {
      const ProbeCell unit{{static_cast<int32_t>(random.below(168)) - 20, static_cast<int32_t>(random.below(168)) - 20,
                            static_cast<int32_t>(random.below(168)) - 20},
                           1};
      bool is_inside = true;
      for (int axis = 0; axis < 3; ++axis) is_inside &= unit.low[axis] >= 0 && unit.low[axis] < 64 * frame.root_count[axis];
      const bool expected = is_inside && is_used[cube(unit.low[0], unit.low[1], unit.low[2])];
      ASSERT_EQ(random_tree.tree.lookUp(positionAt(frame, unitsInside(unit, random)), &around), expected)
          << random_tree.name << ", " << printed(unit);
    }
  }
}

TEST(ProbeTree, PositionsOnAFaceBelongToTheUpperCell) {
  ProbeTree tree;
  const CellJudge finest = [](const ProbeCell&) { return CellVerdict::too_coarse; };
  ASSERT_EQ(ProbeTree::build({{0, 0, 0}, 0.5, {1, 1, 1}}, finest, kMaxTreeProbes, &tree), ProbeTreeStatus::ok);
  ProbesAround around;
  ASSERT_TRUE(tree.lookUp({0.0, 1.0, 31.5}, &around));
  EXPECT_EQ(around.cell, (ProbeCell{{0, 2, 63}, 1}));
  EXPECT_FALSE(tree.lookUp({0.0, 1.0, 32.0}, &around));
  EXPECT_FALSE(tree.lookUp({-1e-300, 1.0, 31.5}, &around));
}

TEST(ProbeTree, WhatIsNotFiniteLiesOutside) {
  const RandomTree random_tree = randomTree(0);
  ProbesAround around;
  for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, -1e300}) {
    for (int axis = 0; axis < 3; ++axis) {
      PositionM position = positionAt(random_tree.frame, {32, 32, 32});
      position[axis] = value;
      EXPECT_FALSE(random_tree.tree.lookUp(position, &around)) << value << ", axis " << axis;
    }
  }
  EXPECT_FALSE(ProbeTree().lookUp({0, 0, 0}, &around));
}

TEST(ProbeTree, ReproducesLinearFieldsAcrossAllBorders) {
  const auto field = [](const std::array<double, 3>& u) { return 3.0 + 0.25 * u[0] - 0.5 * u[1] + 0.125 * u[2]; };
  forManyLookUps([&](const ProbeTree& tree, const ProbeCell&, const std::array<double, 3>& units, const ProbesAround& around) {
    // values up to about 130 in float weights: 8 roundings of 2^-24 each
    ASSERT_NEAR(interpolated(tree, around, field), field(units), 1e-4);
  });
}

TEST(ProbeTree, WeightsFadeAtTheFacesThatTheirProbeIsNotOn) {
  forManyLookUps([](const ProbeTree& tree, const ProbeCell& cell, std::array<double, 3> units, ProbesAround around) {
    for (int axis = 0; axis < 3; ++axis) {
      std::array<double, 3> at_face = units;
      at_face[axis] = cell.low[axis] + cell.side * (1.0 - 1e-6);
      ASSERT_TRUE(tree.lookUp(positionAt(tree.frame(), at_face), &around));
      for (int c = 0; c < 8; ++c) {
        const ProbeAround& corner = around.corners[c];
        const float weight = c >> axis & 1 ? 0.0f : tent(corner.local) * corner.tent_ratio;
        ASSERT_LE(weight, 2e-6f) << "corner " << c << ", axis " << axis;
      }
    }
  });
}

TEST(ProbeTree, IsContinuousThroughFacesOfCellsOfOneSize) {
  int faces = 0, beside_a_border = 0;
  forManyLookUps([&](const ProbeTree& tree, const ProbeCell& cell, const std::array<double, 3>& units, const ProbesAround&) {
    for (int axis = 0; axis < 3; ++axis) {
      ProbesAround below, above;
      if (!cellAcross(tree, units, axis, cell.low[axis] + cell.side, &below, &above) || above.cell.side != cell.side) continue;
      ++faces;
      std::map<uint32_t, double> change;
      for (const ProbeAround& corner : below.corners) {
        change[corner.probe] -= double{tent(corner.local)} * corner.tent_ratio;
        beside_a_border += corner.tent_ratio != 1.0f;
      }
      for (const ProbeAround& corner : above.corners) change[corner.probe] += double{tent(corner.local)} * corner.tent_ratio;
      // 2e-7 units apart, weights change by at most 1 a unit in each cell, and are floats
      for (const auto& [probe, difference] : change) ASSERT_NEAR(difference, 0.0, 1e-6) << "probe " << probe << ", axis " << axis;
    }
  });
  EXPECT_GT(faces, 1000);
  EXPECT_GT(beside_a_border, 1000);
}

TEST(ProbeTree, JumpsAtHangingFacesByNoMoreThanTheBound) {
  // docs/theory/probes.md: (C² + c²) / 8 (M_u + M_v) for cells of side C and c and second derivatives of at most M along the face;
  // here M = 2 along every axis
  const auto field = [](const std::array<double, 3>& u) {
    const double x = u[0] - 50, y = u[1] - 50, z = u[2] - 50;
    return x * x - y * y + z * z;
  };
  int faces = 0;
  double largest_share = 0.0;
  forManyLookUps([&](const ProbeTree& tree, const ProbeCell& cell, const std::array<double, 3>& units, const ProbesAround&) {
    for (int axis = 0; axis < 3; ++axis) {
      ProbesAround below, above;
      if (!cellAcross(tree, units, axis, cell.low[axis] + cell.side, &below, &above) || above.cell.side == cell.side) continue;
      ++faces;
      const double bound = (below.cell.side * below.cell.side + above.cell.side * above.cell.side) / 8.0 * (2.0 + 2.0);
      const double jump = std::abs(interpolated(tree, above, field) - interpolated(tree, below, field));
      // field values up to 1.5e4 in float weights
      ASSERT_LE(jump, bound + 0.01) << printed(below.cell) << " and " << printed(above.cell) << ", axis " << axis;
      largest_share = std::max(largest_share, jump / bound);
    }
  });
  EXPECT_GT(faces, 1000);
  EXPECT_GT(largest_share, 0.3) << "the bound is far from what happens";
}

// Where a look-up took its position to be, in units, by its first corner.
std::array<double, 3> takenUnits(const ProbeTree& tree, const ProbesAround& around) {
  const ProbeAround& corner = around.corners[0];
  const double spacing = double{tree.probeSpacing(corner.probe)} / tree.frame().spacing_m;
  const LatticePoint lattice = tree.probeLattice(corner.probe);
  std::array<double, 3> units;
  for (int axis = 0; axis < 3; ++axis) units[axis] = lattice[axis] + spacing * double{corner.local[axis]};
  return units;
}

TEST(ProbeTree, FindsTheNearestCellWithinOneUnit) {
  int64_t inside = 0, near = 0, far = 0;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const RandomTree random_tree = randomTree(seed);
    const ProbeTree& tree = random_tree.tree;
    const std::vector<ProbeCell> cells = expectedCells(random_tree.frame, random_tree.judge);
    Random random(seed);
    for (int i = 0; i < 300; ++i) {
      std::array<double, 3> units;
      for (int axis = 0; axis < 3; ++axis) units[axis] = random.uniform(-1.5, 64.0 * tree.frame().root_count[axis] + 1.5);
      const PositionM at = positionAt(tree.frame(), units);
      double least = HUGE_VAL;  // squared distance to a cell within one unit along every axis
      for (const ProbeCell& cell : cells) {
        double squares = 0.0, along = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
          const double low = cell.low[axis], high = low + cell.side;
          const double distance = std::max({0.0, low - units[axis], units[axis] - high});
          squares += distance * distance;
          along = std::max(along, distance);
        }
        if (along < 1.0) least = std::min(least, squares);
      }
      ProbesAround around;
      ASSERT_EQ(tree.lookUpNear(at, &around), least < HUGE_VAL) << random_tree.name << ", " << i;
      if (least == HUGE_VAL) {
        ++far;
        continue;
      }
      double squares = 0.0;
      const std::array<double, 3> taken = takenUnits(tree, around);
      for (int axis = 0; axis < 3; ++axis) squares += (taken[axis] - units[axis]) * (taken[axis] - units[axis]);
      // coordinates in floats of cells up to 64 units
      ASSERT_NEAR(std::sqrt(squares), std::sqrt(least), 1e-4) << random_tree.name << ", " << i;
      ++(least == 0.0 ? inside : near);
    }
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(near, 20);
  EXPECT_GT(far, 20);
}

TEST(ProbeTree, ReachesTheEndOfTheLargestLattice) {
  const int32_t most = kMaxLatticeSide / kRootSide;
  const CellJudge coarsest = [](const ProbeCell&) { return CellVerdict::fits; };
  ProbeTree tree;
  ASSERT_EQ(ProbeTree::build({{}, 1.0, {1, most, 1}}, coarsest, kMaxTreeProbes, &tree), ProbeTreeStatus::ok);
  EXPECT_EQ(tree.probeCount(), 4u * (size_t(most) + 1u));
  ProbesAround around;
  ASSERT_TRUE(tree.lookUp({1, kMaxLatticeSide - 1, 1}, &around));
  EXPECT_EQ(tree.probeLattice(around.corners[7].probe), (LatticePoint{64, kMaxLatticeSide, 64}));
}

}  // namespace
}  // namespace nlg
