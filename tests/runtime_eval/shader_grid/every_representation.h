// A grid with functions of every representation, and places to ask it at.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tests/runtime_eval/shader_grid/places.h"

namespace nlg {

// Four roots with cells of every size and gaps of every kind between them.
inline ProbeTree wildTree(uint64_t seed) {
  ProbeTree tree;
  EXPECT_EQ(ProbeTree::build({{-3.0, 100.0, 0.25}, 0.5, {2, 1, 2}}, wildJudge(seed), kMaxTreeProbes, &tree), ProbeTreeStatus::ok);
  return tree;
}

// Every representation there is; theta and light as files have them.
inline LightGrid everyRepresentation(ThetaPrecision precision, uint64_t seed) {
  LightGrid grid = randomGrid(wildTree(seed), seed);
  for (const RepresentationKind kind : {RepresentationKind::tent_mlp44, RepresentationKind::tent_mlp4}) {
    grid.representations.push_back({kind, 0.02f});
    const auto representation = static_cast<uint8_t>(grid.representations.size() - 1);
    for (uint64_t i = 0; i < 4; ++i) {
      const uint32_t function =
          grid.addFunction(representation, randomTheta(grid.representations.back(), mixSeed(seed, 100 + i)).data());
      for (size_t probe = function; probe < grid.probe_function.size(); probe += 31) grid.probe_function[probe] = function;
    }
  }
  // a region of a function that is hardly more than the residue everywhere, and one that nothing lights
  Theta theta(ThetaLayout::count);
  theta[ThetaLayout::b3] = 1.5f * kResidue;
  const uint32_t faint = grid.addFunction(1, theta.data());  // tent_mlp
  for (size_t probe = 0; probe < grid.probe_function.size(); ++probe) {
    const auto lattice = grid.tree.probeLattice(probe);
    if (lattice[0] >= 96) grid.probe_function[probe] = faint;
    if (lattice[1] >= 48) grid.probe_function[probe] = kNoWeight;
  }
  for (size_t f = 0; f < grid.functionCount(); ++f) {
    EXPECT_TRUE(roundTheta(grid.representations[grid.function_representation[f]], precision, &grid.theta[grid.theta_begin[f]]));
  }
  grid.makeBricks();
  grid.light = randomLight(grid.tree.probeCount(), seed);
  roundGridLight(kLightError, &grid);
  return grid;
}

// As an engine has it, in float; not so near a face between two units that float takes it to the other side.
inline PositionM randomPlace(const ProbeTreeFrame& frame, Random& random) {
  for (;;) {
    const PositionM at = asFloats(randomPosition(frame, random));
    bool is_clear = true;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double units = (at[axis] - frame.first_m[axis]) / frame.spacing_m;
      is_clear = is_clear && std::abs(units - std::round(units)) > 1e-3;
    }
    if (is_clear) return at;
  }
}

// All over a grid, and a little outside.
inline ShaderPlaces randomPlaces(const LightGrid& grid, size_t count, uint64_t seed) {
  Random random(seed);
  ShaderPlaces places;
  for (size_t i = 0; i < count; ++i) {
    places.positions_m.push_back(randomPlace(grid.tree.frame(), random));
    places.normals.push_back(randomNormal(random));
  }
  return places;
}

}  // namespace nlg
