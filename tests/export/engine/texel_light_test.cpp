#include "export/engine/texel_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "light/air.h"
#include "light/directions.h"
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

// A thin wall across x parts even light, 1 and 0.1. A texel behind it lights what faces it by the one, and its own side by the other.
TEST(SolveByNormal, PartsWhatFacesAWallFromWhatIsBehind) {
  const TexelLookUp look_up{{{-4.0, -2.0, -2.0}, {4.0, 2.0, 2.0}, {8, 4, 4}}, 0.5};
  const auto light_at = [](double x) {
    LightSh light{};
    light[0] = glm::vec3(x < 0.3 ? 1.0f : 0.1f);
    return light;
  };
  Random random(3);
  std::vector<PositionM> places_m;
  std::vector<LightSh> place_light, placed;
  for (int i = 0; i < 4000; ++i) {
    places_m.push_back({random.uniform(-4.0, 4.0), random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)});
    place_light.push_back(light_at(places_m.back()[0]));
  }
  for (size_t t = 0; t < look_up.box.texelCount(); ++t) placed.push_back(light_at(look_up.box.texelCentre(t)[0]));
  ProbeLightOptions options;
  options.dark_share = 1.0;
  const auto error = [&](const std::vector<LightSh>& light) {
    Random turns(4);
    double sum = 0.0;
    for (size_t i = 0; i < places_m.size(); ++i) {
      const double u = turns.uniform(), v = turns.uniform();
      const glm::vec3 normal = sphereDirection(u, v);
      ProbeWeights weights;
      look_up.weightsAt(places_m[i], &normal[0], &weights);
      LightSh off = place_light[i];
      for (int j = 0; j < weights.count; ++j) {
        for (int k = 0; k < kShCount; ++k) off[k] -= weights.weight[j] * light[weights.probe[j]][k];
      }
      sum += std::pow(irradiance(off, normal).x, 2);
    }
    return std::sqrt(sum / static_cast<double>(places_m.size()));
  };
  const std::vector<LightSh> solved = solveByNormal(look_up, places_m, place_light, placed, options, 1);
  EXPECT_LT(error(solved), 0.8 * error(placed));
  // behind the wall by 20 cm: places before it read it with normals of x, those behind it with the others
  const LightSh& behind = solved[(2 * 4 + 2) * 8 + 4];
  EXPECT_GT(irradiance(behind, {1.0f, 0.0f, 0.0f}).x, 2.0f * irradiance(behind, {-1.0f, 0.0f, 0.0f}).x);
  EXPECT_EQ(solved, solveByNormal(look_up, places_m, place_light, placed, options, 3));
}

}  // namespace
}  // namespace nlg
