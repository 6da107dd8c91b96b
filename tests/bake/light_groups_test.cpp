// Groups of light in a bake: they add up to what all light at once gives, and a grid's file brings them back.
#include <gtest/gtest.h>

#include <cmath>

#include "bake/scene_bake.h"
#include "nlg/look_up.h"
#include "tests/bake/house_corner.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

BakeOptions corner(const std::string& groups) {
  BakeOptions options = houseCornerOptions();
  options.extent_m = {"0", "0", "0", "6", "6", "3"};  // where the sun comes in
  options.light_rays = 16;
  options.light_error = kLeastLightError;
  options.scene_light.light_groups = groups;
  takeThetaPrecision(&options);
  return options;
}

Bake bakeOf(const BakeOptions& options) { return bakeOf(PreparedScene("house:3", options), options); }

double rms(const std::vector<float>& light) {
  double sum = 0.0;
  for (const float value : light) sum += double{value} * value;
  return std::sqrt(sum / static_cast<double>(light.size()));
}

TEST(LightGroupsOfABake, AddUpToAsMuchAsTheBakeOfAllLightAtOnce) {
  const Bake whole = bakeOf(corner("one")), grouped = bakeOf(corner("kind"));
  ASSERT_GE(grouped.grid.groups.size(), 3u);
  EXPECT_EQ(grouped.grid.groups[0].name, "sky");
  for (const LightGroup& group : grouped.grid.groups) EXPECT_GT(rms(group.light), 0.0) << group.name;
  EXPECT_EQ(grouped.grid.probe_function, whole.grid.probe_function);
  EXPECT_EQ(grouped.grid.theta, whole.grid.theta);
  // against the same light at the same places
  EXPECT_NEAR(grouped.statistics.light.mean, whole.statistics.light.mean, 1e-3 * whole.statistics.light.mean);
  EXPECT_LT(grouped.statistics.light.error, 1.5 * whole.statistics.light.error);
  EXPECT_LT(grouped.statistics.light.median_error, 1.1 * whole.statistics.light.median_error);
  EXPECT_LT(grouped.statistics.light.p95_error, 1.1 * whole.statistics.light.p95_error);
}

TEST(LightGroupsOfABake, AreWhatEachLightGivesByItself) {
  // a sky and a sun, and each of them alone: the same rays, and places weighed by less light
  BakeOptions both = corner("kind"), sky = corner("one");
  both.scene_light.sky = sky.scene_light.sky = {"0.5", "0.7", "1"};
  both.scene_light.sun = {"120", "50", "5", "4.7", "4.1"};
  sky.scene_light.sun = {"0"};
  const PreparedScene scene_of_both("house:3", both), scene_of_sky("house:3", sky);
  const LightTransport all(scene_of_both.source.scene, scene_of_both.rays), alone(scene_of_sky.source.scene, scene_of_sky.rays);
  ASSERT_GE(all.groupCount(), 2u);
  GatherOptions gather{512, 64};
  gather.direct = DirectLight::no_suns;
  double error = 0.0, light = 0.0;
  for (size_t i = 0; i < scene_of_both.air.places.size(); i += 37) {
    const GatheredLight grouped = all.gather(scene_of_both.air.places[i], gather, 1, i);
    LightSh sum{};
    for (const LightSh& of_group : grouped.groups) {
      for (int k = 0; k < kShCount; ++k) sum[k] += of_group[k];
    }
    for (int k = 0; k < kShCount; ++k) ASSERT_LT(glm::length(sum[k] - grouped.light[k]), 1e-4f * (1.0f + glm::length(sum[0])));
    const LightSh& of_sky = grouped.groups[0];
    const LightSh expected = alone.gather(scene_of_both.air.places[i], gather, 1, i).light;
    error += glm::length(of_sky[0] - expected[0]);
    light += glm::length(expected[0]);
  }
  EXPECT_LT(error, 0.1 * light);
}

TEST(LightGroupsOfABake, ComeBackFromTheFileAndCanBeMixed) {
  const LightGrid grid = bakeOf(corner("kind")).grid;
  std::string bytes;
  ASSERT_TRUE(serializeLightGrid(grid, {ThetaPrecision::int8, kLeastLightError}, {}, &bytes).ok());
  LightGrid read;
  GridMetadata metadata;
  ASSERT_TRUE(parseLightGrid(bytes, &read, &metadata).ok());
  ASSERT_EQ(read.groups.size(), grid.groups.size());
  for (size_t g = 0; g < grid.groups.size(); ++g) {
    EXPECT_EQ(read.groups[g].name, grid.groups[g].name);
    EXPECT_EQ(read.groups[g].light, grid.groups[g].light);
  }
  EXPECT_EQ(read.light, grid.light);
  std::string again;
  ASSERT_TRUE(serializeLightGrid(read, {ThetaPrecision::int8, kLeastLightError}, {}, &again).ok());
  EXPECT_TRUE(again == bytes);

  std::vector<std::array<float, 3>> colours(read.groups.size(), {0.0f, 0.0f, 0.0f});
  colours[0] = {2.0f, 1.0f, 0.5f};
  ASSERT_TRUE(mixLight(colours, &read).ok());
  for (size_t i = 0; i < read.light.size(); ++i) ASSERT_EQ(read.light[i], colours[0][i % 3] * grid.groups[0].light[i]);
  // a mix is no other grid: the file still holds the groups
  ASSERT_TRUE(serializeLightGrid(read, {ThetaPrecision::int8, kLeastLightError}, {}, &again).ok());
  EXPECT_TRUE(again == bytes);
  const std::vector<float> before = read.light;
  colours[0] = {1e30f, 1.0f, 1.0f};
  EXPECT_FALSE(mixLight(colours, &read).ok());
  EXPECT_EQ(read.light, before);
}

}  // namespace
}  // namespace nlg
