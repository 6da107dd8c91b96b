// Light grids with functions of every representation drawn at random, for tests.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "nlg/light_grid.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"
#include "tests/runtime_eval/probe_tree/random_tree.h"
#include "tests/runtime_eval/sample_dictionary.h"

namespace nlg {

inline const Representation kGridRepresentations[] = {Representation::mlp(0.013f),
                                                      Representation::tentMlp(0.3f),
                                                      Representation::productField(3),
                                                      Representation::productField(5),
                                                      Representation::productField(7),
                                                      Representation::productField(9),
                                                      Representation::code(sampleDictionary(9, 64, 1)),
                                                      Representation::code(sampleDictionary(5, 16, 2))};

// What a grid may hold of a representation: codes of any length, in whole numbers as they are stored.
inline Theta randomGridTheta(const Representation& representation, uint64_t seed) {
  if (!representation.isCode()) return randomTheta(representation, seed);
  Random random(seed);
  const auto groups = static_cast<int>(random.below(static_cast<uint32_t>(representation.code_count / kCodeGroup) + 1));
  return sampleCode(*representation.dictionary, kCodeGroup * groups, random);
}

// One root with a brick at every level around one corner, and cells of 16, 4 and 1 units: some 300 probes.
inline ProbeTree smallTree() {
  ProbeTree tree;
  const CellJudge judge = [](const ProbeCell& cell) {
    bool holds_point = true;
    for (const int32_t low : cell.low) holds_point = holds_point && low <= 5 && 5 < low + cell.side;
    if (holds_point) return CellVerdict::too_coarse;
    return cell.side > 16 || cell.low[2] < 40 ? CellVerdict::fits : CellVerdict::unneeded;
  };
  ProbeTree::build({{-3.0, 1e4, 0.25}, 0.5, {1, 1, 1}}, judge, kMaxTreeProbes, &tree);
  return tree;
}

// Radiance of kShFloats coefficients a probe, whose irradiance is below its floor (kIrradianceFloor) for some normals.
inline std::vector<float> randomLight(size_t probe_count, uint64_t seed) {
  Random random(mixSeed(seed, 0x6c69676874));
  std::vector<float> light;
  for (size_t i = 0; i < probe_count * kShFloats; ++i) {
    const bool is_mean = i % kShFloats < kShChannels;
    light.push_back(static_cast<float>(is_mean ? random.uniform(1.0, 4.0) : random.uniform(-2.0, 2.0)));
  }
  return light;
}

// Two functions of each representation; probes have one of them, free space or no weight. Without light.
inline LightGrid randomGrid(ProbeTree tree, uint64_t seed) {
  Random random(mixSeed(seed, 0x67726964));
  LightGrid grid;
  grid.tree = std::move(tree);
  for (const Representation& representation : kGridRepresentations) grid.representations.push_back(representation);
  for (size_t i = 0; i < 2 * grid.representations.size(); ++i) {
    const auto representation = static_cast<uint8_t>(i % grid.representations.size());
    grid.addFunction(representation, randomGridTheta(grid.representations[representation], mixSeed(seed, i)).data());
  }
  const auto functions = static_cast<uint32_t>(grid.functionCount());
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    const uint32_t drawn = random.below(functions + 4);
    grid.probe_function.push_back(drawn < functions ? drawn : drawn < functions + 2 ? kFreeSpace : kNoWeight);
  }
  return grid;
}

// The same with light.
inline LightGrid litGrid(ProbeTree tree, uint64_t seed) {
  LightGrid grid = randomGrid(std::move(tree), seed);
  grid.light = randomLight(grid.tree.probeCount(), seed);
  return grid;
}

// Bare tents alone, with light.
inline LightGrid freeGrid() {
  LightGrid grid;
  grid.tree = smallTree();
  grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  grid.light = randomLight(grid.tree.probeCount(), 1);
  return grid;
}

inline std::array<float, 3> randomDirection(Random& random) {
  const double z = random.uniform(-1.0, 1.0), turn = random.uniform(0.0, 6.283185307179586), r = std::sqrt(1.0 - z * z);
  return {static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)), static_cast<float>(z)};
}

// Anywhere in the box of the roots, and a little outside.
inline PositionM randomPosition(const ProbeTreeFrame& frame, Random& random) {
  std::array<double, 3> units;
  for (int axis = 0; axis < 3; ++axis) units[axis] = kRootSide * frame.root_count[axis] * random.uniform(-0.01, 1.01);
  return positionAt(frame, units);
}

// List by list.
inline void expectSameTree(const ProbeTree& a, const ProbeTree& b) {
  const ProbeTreeData x = probeTreeData(a), y = probeTreeData(b);
  EXPECT_EQ(x.frame.first_m, y.frame.first_m);
  EXPECT_EQ(x.frame.spacing_m, y.frame.spacing_m);
  EXPECT_EQ(x.frame.root_count, y.frame.root_count);
  EXPECT_EQ(x.child_mask, y.child_mask);
  EXPECT_EQ(x.used_mask, y.used_mask);
  EXPECT_EQ(x.cell_count, y.cell_count);
  const ProbeTreeLists v = probeTreeLists(a), w = probeTreeLists(b);
  EXPECT_EQ(v.first_child, w.first_child);
  EXPECT_EQ(v.first_slot, w.first_slot);
  EXPECT_EQ(v.cell_log2, w.cell_log2);
  EXPECT_EQ(v.slots, w.slots);
  ASSERT_EQ(a.probeCount(), b.probeCount());
  for (size_t probe = 0; probe < a.probeCount(); ++probe) {
    EXPECT_EQ(a.probePosition(probe), b.probePosition(probe));
    EXPECT_EQ(a.probeSpacing(probe), b.probeSpacing(probe));
  }
  EXPECT_EQ(a.cellCount(), b.cellCount());
}

}  // namespace nlg
