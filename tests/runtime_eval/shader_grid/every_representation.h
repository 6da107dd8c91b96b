// A grid with functions of every representation, and places to ask it at.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/light_form.h"
#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {

// Every representation there is; theta and light as files have them.
inline LightGrid everyRepresentation(ThetaPrecision precision, uint64_t seed) {
  LightGrid grid = randomGrid(smallTree(), seed);
  for (const RepresentationKind kind :
       {RepresentationKind::tent_mlp88, RepresentationKind::tent_mlp44, RepresentationKind::tent_mlp4}) {
    grid.representations.push_back({kind, 0.02f});
    const auto representation = static_cast<uint8_t>(grid.representations.size() - 1);
    for (uint64_t i = 0; i < 4; ++i) {
      const uint32_t function =
          grid.addFunction(representation, randomTheta(grid.representations.back(), mixSeed(seed, 100 + i)).data());
      for (size_t probe = function % 11; probe < grid.probe_function.size(); probe += 11) grid.probe_function[probe] = function;
    }
  }
  // one that is 0 everywhere, with a region of its own: bare tents light it
  const uint32_t nothing = grid.addFunction(0, Theta(static_cast<size_t>(grid.representations[0].thetaCount())).data());
  for (size_t probe = 0; probe < grid.probe_function.size(); ++probe) {
    if (grid.tree.probeLattice(probe)[0] >= 48) grid.probe_function[probe] = nothing;
  }
  for (size_t f = 0; f < grid.functionCount(); ++f) {
    EXPECT_TRUE(roundTheta(grid.representations[grid.function_representation[f]], precision, &grid.theta[grid.theta_begin[f]]));
  }
  grid.light = randomLight(grid.tree.probeCount(), seed);
  EXPECT_TRUE(roundLight(LightForm::sh2_8bit, &grid.light).ok());
  return grid;
}

inline std::array<float, 3> randomNormal(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal(), length = std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

// As an engine has it.
inline PositionM asFloats(const PositionM& position_m) {
  PositionM rounded;
  for (size_t axis = 0; axis < 3; ++axis) rounded[axis] = static_cast<float>(position_m[axis]);
  return rounded;
}

}  // namespace nlg
