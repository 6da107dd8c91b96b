#include "bake/bake_plan.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_generator.h"
#include "tests/scene/built_scenes.h"

namespace nlg {
namespace {

SceneSource groundOf(float side_m) {
  SceneSource source;
  source.id = "ground";
  source.unit_m = 1.0;
  source.scene = sceneOfMaterial(false);
  addQuad(source.scene, {0, 0, 0}, {0, 0, side_m}, {side_m, 0, 0});
  return source;
}

// A room with a slab in it: probes have functions, and these take a theta.
TEST(BakePlan, SeesWhatFunctionsTake) {
  SceneSource source;
  source.scene = sceneOfMaterial(false);
  addRoom(source.scene, {0, 0, 0}, {6, 2.5f, 6});
  addBox(source.scene, {2, 0, 1}, {2.1f, 2, 5});
  BakeOptions options;
  options.light = "none";
  options.spacing_m = 0.5;
  std::vector<Generator> generators;
  generators.emplace_back(sampleGenerator(Representation::tentMlp(0.01f), 32, 3, 1));
  options.threads = 1;
  const PlacedScene scene(std::move(source), options);
  const double without = planBake(scene, options, {}).seconds, with = planBake(scene, options, generators).seconds;
  // a function takes a tenth of a millisecond at the very least
  EXPECT_GT(with, without + 0.3e-4 * static_cast<double>(scene.full_tree.probeCount()));
  options.policy.refine_rounds = options.policy.adam_steps = 0;
  EXPECT_LT(planBake(scene, options, generators).seconds, with) << "fits take most of it";
}

TEST(PlacedScene, ReachesAsFarAsLamps) {
  SceneSource source = groundOf(20);
  const auto heightOf = [](const SceneSource& of) {
    const ExtentBox extent = PlacedScene(of, {}).extent;
    return extent.high_m.y - extent.low_m.y;
  };
  const double before_m = heightOf(source);
  Lamp lamp;
  lamp.position = {0, 9, 0};
  source.scene.light.lamps.push_back(lamp);
  EXPECT_GT(heightOf(source), before_m + 4.0);
}

// A roof of 2.995 m, over cells that end at 3 m: half a centimetre of air, in which no place is found, would leave it dark.
TEST(PlacedScene, HoldsTheAirOverARoofThatEndsWithItsCells) {
  SceneSource source;
  source.scene = sceneOfMaterial(false);
  Scene& house = source.scene;
  addRoom(house, {0, 0, 0}, {6, 2.5f, 6});
  addBox(house, {0, 2.5f, 0}, {6, 2.995f, 6});
  BakeOptions options;
  options.align_lattice = true;
  const PlacedScene placed(source, options);
  ProbesAround around;
  EXPECT_TRUE(placed.full_tree.lookUp({3, 3.02, 3}, &around));
  const ProbePlacementOptions bounds_alone{.spacing_min_m = 1.0, .spacing_max_m = 1.0, .align_lattice = true};
  EXPECT_FALSE(placeProbes(house, bounds_alone, 1).lookUp({3, 3.02, 3}, &around));
}

}  // namespace
}  // namespace nlg
