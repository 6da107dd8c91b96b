#include "export/engine/quake_light_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/input_error.h"
#include "tests/scene/quake/hand_built_bsp.h"
#include "tests/temporary_folder.h"

namespace nlg {
namespace {

constexpr double kUnitM = 0.0254;
constexpr size_t kX = 5, kY = 3, kZ = 3, kPoints = kX * kY * kZ;  // of the grid, 50 units apart, from the level's origin on

class QuakeLightGrid : public testing::Test {
 protected:
  QuakeLevel levelWith(size_t grid_bytes) const {
    BspParts parts = smallLevel();
    parts.entities = R"({ "classname" "worldspawn" "gridsize" "50 50 50" })";
    parts.models[0].min = {-20.0f, -1.0f, 0.0f};
    parts.models[0].max = {220.0f, 101.0f, 149.0f};
    parts.light_grid = std::string(grid_bytes, '\7');
    std::ofstream(path_, std::ios::binary) << parts.bytes();
    return readQuakeLevel(path_);
  }
  static LightSh uniform(float radiance) {
    LightSh light{};
    light[0] = glm::vec3(radiance / 0.28209479f);
    return light;
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "small.bsp";
};

std::array<float, 3> at(const EngineIrradiance& shown, const PositionM& position_m, const glm::vec3& normal) {
  return shown(position_m, &normal[0]);
}

TEST_F(QuakeLightGrid, StandsWhereTheEngineLooksItUp) {
  const QuakeLevel level = levelWith(8 * kPoints);
  EXPECT_EQ(level.name, "small");
  ASSERT_EQ(level.box.texelCount(), kPoints);
  // one point alone is made anew: the engine finds it at its place
  for (const size_t point : {size_t{0}, size_t{1}, kX, kX * kY, kPoints - 1}) {
    const double x = 50.0 * static_cast<double>(point % kX), y = 50.0 * static_cast<double>(point / kX % kY),
                 z = 50.0 * static_cast<double>(point / (kX * kY));
    const PositionM position_m = {kUnitM * x, kUnitM * z, -kUnitM * y};
    size_t texel = 0;
    for (size_t t = 0; t < kPoints; ++t) {
      const PositionM centre = level.box.texelCentre(t);
      if (std::hypot(centre[0] - position_m[0], centre[1] - position_m[1], centre[2] - position_m[2]) < 1e-6) texel = t;
    }
    std::vector<uint8_t> is_made(kPoints, 0);
    is_made[texel] = 1;
    const QuakeGridBytes bytes = quakeGridBytes(level, std::vector<LightSh>(kPoints, uniform(0.5f)),
                                                std::vector<glm::vec3>(kPoints, {0.0f, 1.0f, 0.0f}), is_made);
    ASSERT_EQ(bytes.raw.size(), 24 * kPoints);
    for (size_t p = 0; p < kPoints; ++p) {
      EXPECT_EQ(bytes.lump.substr(8 * p, 8) != lightGridOf(level).substr(8 * p, 8), p == point) << p;
    }
    // a hair inside the grid: below its first points engines read the second ones
    const PositionM inside_m = {position_m[0] + 1e-6 * (2.0 - position_m[0]), position_m[1] + 1e-6 * (1.0 - position_m[1]),
                                position_m[2] + 1e-6 * (-1.0 - position_m[2])};
    const std::array<float, 3> rgb = at(quakeIrradiance(level, bytes), inside_m, {1.0f, 0.0f, 0.0f});
    EXPECT_NEAR(rgb[1], 0.5f * std::numbers::pi_v<float>, 1e-4f) << point;
  }
}

// Even light is ambient, whatever the direction: of the raw file as it is, of the lump but for its codes, 4 of those on a screen, of
// which ambient light counts .6.
TEST_F(QuakeLightGrid, ShowsEvenLightAsItIs) {
  const QuakeLevel level = levelWith(8 * kPoints);
  const glm::vec3 direction = glm::normalize(glm::vec3(1.0f, 2.0f, -3.0f));
  const LightSh light = meanAndDirected(uniform(0.6f), direction);
  QuakeGridBytes bytes = quakeGridBytes(level, std::vector<LightSh>(kPoints, light), std::vector<glm::vec3>(kPoints, direction),
                                        std::vector<uint8_t>(kPoints, 1));
  const PositionM inside_m = {0.0254 * 60.0, 0.0254 * 33.0, -0.0254 * 71.0};
  constexpr float kShown = 0.6f * std::numbers::pi_v<float>;
  EXPECT_NEAR(at(quakeIrradiance(level, bytes), inside_m, direction)[0], kShown, 1e-3f);
  bytes.raw.clear();
  EXPECT_NEAR(at(quakeIrradiance(level, bytes), inside_m, direction)[0], kShown,
              0.5f * (0.6f + 1.0f) * 4.0f * std::numbers::pi_v<float> / 255.0f + 1e-3f);
}

// No other amounts of ambient and directed light come nearer, over all normals, to light from one side.
TEST_F(QuakeLightGrid, HoldsTheNearestThatItCan) {
  const QuakeLevel level = levelWith(8 * kPoints);
  LightSh light = uniform(0.5f);
  const glm::vec3 direction = glm::normalize(glm::vec3(-1.0f, 2.0f, 0.5f));
  const std::array<float, kShCount> basis = shBasis(direction.x, direction.y, direction.z);
  for (int k = 0; k < kShCount; ++k) light[k] += 0.8f * basis[k];
  EXPECT_NEAR(glm::dot(mainDirection(light), direction), 1.0f, 1e-5f);
  const PositionM inside_m = {0.0254 * 100.0, 0.0254 * 50.0, -0.0254 * 50.0};
  const LightSh best = meanAndDirected(light, direction);
  const auto squares = [&](const LightSh& held) {
    const EngineIrradiance shown =
        quakeIrradiance(level, quakeGridBytes(level, std::vector<LightSh>(kPoints, held),
                                              std::vector<glm::vec3>(kPoints, direction), std::vector<uint8_t>(kPoints, 1)));
    double sum = 0.0;
    const Lattice lattice(1);
    for (int i = 0; i < 2000; ++i) {
      const auto [u, v] = lattice.point(i, 2000);
      const glm::vec3 normal = sphereDirection(u, v);
      sum += std::pow(double{at(shown, inside_m, normal)[0]} - irradiance(light, normal)[0], 2);
    }
    return sum;
  };
  const double least = squares(best);
  for (const int k : {0, 1}) {
    for (const float factor : {0.95f, 1.05f}) {
      LightSh other = best;
      other[k] *= factor;
      EXPECT_GT(squares(other), least) << k << ", " << factor;
    }
  }
}

TEST_F(QuakeLightGrid, GoesIntoTheLevelInPlaceOfItsOwn) {
  const QuakeLevel level = levelWith(8 * kPoints);
  EXPECT_EQ(lightGridOf(level), std::string(8 * kPoints, '\7'));
  const std::string grid(8 * kPoints, '\x2a');
  QuakeLevel with = level;
  with.bytes = withLightGrid(level, grid);
  EXPECT_EQ(lightGridOf(with), grid);
  EXPECT_EQ(withLightGrid(with, lightGridOf(level)), level.bytes);
}

// Models are lit by points on their side of a wall alone, as strong as all of them are.
TEST_F(QuakeLightGrid, HasCompiledLightOfPointsThatAPlaceSees) {
  const QuakeLevel level = levelWith(8 * kPoints);
  // from .31 to .47 m, between points 0 and 1.27 m along x
  const Scene scene = infiniteWall();
  const RayScene rays(scene);
  const CompiledLight compiled(level, rays, glm::dvec3(0.0));
  for (const double x : {10.0, 40.0}) {
    ProbeWeights weights;
    compiled.weightsAt({kUnitM * x, kUnitM * 30.0, -kUnitM * 20.0}, &weights);
    ASSERT_EQ(weights.count, 4);
    float sum = 0.0f;
    for (int i = 0; i < weights.count; ++i) {
      EXPECT_EQ(weights.probe[i] % kX, x < 25.0 ? 0u : 1u);
      sum += weights.weight[i];
    }
    EXPECT_NEAR(sum, 1.0f, 1e-6f);
    // codes of 7 in the file, 28 on a screen; .6 of what is ambient, and 32 more; the rest comes from one side
    const glm::vec3 up(0.0f, 1.0f, 0.0f), shown = irradiance(compiled.grid().light(weights), up);
    EXPECT_NEAR(shown.g, compiled.grid().shown(weights, &up[0])[1], 0.1f);
  }
}

TEST_F(QuakeLightGrid, IsRefusedWhereTheLevelHasNone) {
  expectInputError("lump 15: expected a light grid of 45 points, got 8 bytes", [&] { levelWith(8); });
  expectInputError("scene: expected a level of a Quake III-family game", [] { readQuakeLevel("level.glb"); });
}

}  // namespace
}  // namespace nlg
