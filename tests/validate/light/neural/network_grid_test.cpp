#include "validate/light/neural/network_grid.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

#include <cmath>

#include "tests/validate/light/neural/learned_places.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

TrainingOptions training(int steps, float rate) {
  TrainingOptions options;
  options.steps = steps;
  options.check_steps = 50;
  options.rate = rate;
  return options;
}

TEST(NetworkGrid, LearnsLightWithoutEdgesBetweenCells) {
  // light is higher on one side of the nodes at the lowest place's x + 4
  const auto level = [](double x) { return static_cast<float>(x < 23.0 ? 0.2 : x > 25.0 ? 1.0 : 0.2 + 0.4 * (x - 23.0)); };
  const LitPlaces lit = placesWithLight(4000, [&](const glm::dvec3& p) { return ambient(glm::vec3(level(p.x))); });
  NetworkGridOptions options;
  options.batch = 1024;
  options.training = training(300, 2e-2f);
  const LearnedLight learned = trainNetworkGrid(lit, splitPlaces(4000, 1), options);
  // 8 x 3 x 5 m, less what places by chance leave at the ends, are 3 x 2 x 3 nodes
  const size_t numbers = 7 * 16 + 17 * 16 + 17 * 3;
  EXPECT_EQ(learned.cost.networks, 18u);
  EXPECT_EQ(learned.bytes.light, 18 * 2 * numbers);
  EXPECT_EQ(learned.bytes.tree, 18u * 4);
  EXPECT_EQ(learned.cost.multiply_adds, 4 * (6u * 16 + 16 * 16 + 16 * 3 + 3));
  double squares = 0.0;
  for (int i = 0; i < 500; ++i) {
    const LightAnswer answer = answerAt(learned.light_at, {lit.position_m[i], {0.0f, 1.0f, 0.0f}});
    EXPECT_EQ(answer.reach, Reach::lit);
    squares += std::pow(answer.irradiance.g / (kPi * level(lit.position_m[i].x)) - 1.0, 2) / 500.0;
  }
  // the mean alone is .9 off
  EXPECT_LT(std::sqrt(squares), 0.1);
  // along a line through cells and their tetrahedra: within a tenth of a millimetre even a slope of the whole light a centimetre is .01
  for (double x = 21.0; x < 27.0; x += 1e-4) {
    const double y = -0.5 + 0.3 * (x - 21.0), z = 4.0 + 0.5 * (x - 21.0);
    const auto at = [&](double moved) {
      return answerAt(learned.light_at, {{x + moved, y, z}, {0.0f, 1.0f, 0.0f}}).irradiance.g;
    };
    ASSERT_NEAR(at(0.0), at(1e-4), 0.01f * kPi) << x;
  }
}

}  // namespace
}  // namespace nlg
