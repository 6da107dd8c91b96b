#include "export/engine/texel_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "light/air.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr float kUp[3] = {0.0f, 1.0f, 0.0f};

TexelLookUp smallLookUp() { return {{{-1.0, 2.0, 0.0}, {3.0, 5.0, 10.0}, {4, 6, 5}}}; }

PositionM blendedCentre(const TexelLookUp& look_up, const ProbeWeights& weights) {
  PositionM sum{};
  for (int i = 0; i < weights.count; ++i) {
    const PositionM centre = look_up.box.texelCentre(weights.probe[i]);
    for (size_t axis = 0; axis < 3; ++axis) sum[axis] += double{weights.weight[i]} * centre[axis];
  }
  return sum;
}

// Linear functions come out of a linear filter as they are, and of one that is moved, at the place that it moves to.
TEST(TexelLookUp, IsLinearBetweenTexelsWhereTheBiasMovesTo) {
  TexelLookUp look_up = smallLookUp();
  const std::array<double, 3> texel_m = look_up.texelM();
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    look_up.bias = i % 2 == 0 ? 0.0 : 0.5;
    PositionM position_m;
    for (size_t axis = 0; axis < 3; ++axis)
      position_m[axis] = random.uniform(look_up.box.low_m[axis] + texel_m[axis], look_up.box.high_m[axis] - texel_m[axis]);
    ProbeWeights weights;
    look_up.weightsAt(position_m, kUp, &weights);
    const PositionM blended = blendedCentre(look_up, weights);
    for (size_t axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(blended[axis], position_m[axis] + look_up.bias * texel_m[axis] * double{kUp[axis]}, 1e-5) << i;
  }
}

TEST(TexelLookUp, ReadsTheEdgeBeyondIt) {
  ProbeWeights weights;
  smallLookUp().weightsAt({-100.0, 2.25, 1.0}, kUp, &weights);
  ASSERT_EQ(weights.count, 1);
  EXPECT_EQ(weights.probe[0], 0u);
  EXPECT_EQ(weights.weight[0], 1.0f);
}

TEST(TexelLookUp, ScalesUpWhatIsLeftOfTexelsThatAreLeftOut) {
  TexelLookUp look_up = smallLookUp();
  look_up.is_valid.assign(look_up.box.texelCount(), 1);
  Random random(2);
  for (uint8_t& valid : look_up.is_valid) valid = random.chance(0.5);
  for (int i = 0; i < 1000; ++i) {
    PositionM position_m;
    for (size_t axis = 0; axis < 3; ++axis) position_m[axis] = random.uniform(look_up.box.low_m[axis], look_up.box.high_m[axis]);
    ProbeWeights weights;
    look_up.weightsAt(position_m, kUp, &weights);
    float sum = 0.0f;
    for (int j = 0; j < weights.count; ++j) {
      EXPECT_TRUE(look_up.is_valid[weights.probe[j]]) << i;
      sum += weights.weight[j];
    }
    if (weights.count > 0) {
      EXPECT_GE(sum, TexelLookUp::kWhole - 1e-5f) << i;
    }
    EXPECT_LE(sum, 1.0f + 1e-5f) << i;
  }
}

}  // namespace
}  // namespace nlg
