#include "validate/light/asked_bakes.h"

#include <gtest/gtest.h>

#include "bake/scene_bake.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

TEST(WordGrids, EndAtWhatABakeStoresBeforeItRounds) {
  // a corner of a house, fitted for next to no time
  BakeOptions options;
  options.spacing_m = 1.5;
  options.extent_m = {"0", "0", "0", "6", "6", "3"};
  options.light = "none";
  options.policy.refine_rounds = 1;
  options.policy.refine_first_steps = 4;
  options.policy.adam_steps = 20;
  options.policy.theta_precision = ThetaPrecision::float32;
  std::vector<Generator> generators;
  generators.emplace_back(sampleGenerator(Representation::tentMlp(), 24, 3, 1));
  const PreparedScene scene("house:1", options);
  const std::vector<WordGrid> words = wordGrids(scene, generators.front(), options, 2);
  // float32 is no rounding
  const LightGrid baked = bakeScene(scene, generators, options, temporaryFolder()).grid;
  ASSERT_EQ(words.size(), 3u);
  ASSERT_GT(baked.functionCount(), 0u);
  for (const WordGrid& at : words) {
    EXPECT_TRUE(checkLightGrid(at.grid).ok());
    EXPECT_EQ(at.grid.probe_function, baked.probe_function);
    EXPECT_EQ(at.grid.theta == baked.theta, at.word == ThetaWord::fitted) << wordName(at.word);
  }
}

}  // namespace
}  // namespace nlg
