#include "light/light_solve.h"

#include <gtest/gtest.h>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

LightSh uniformLight(float value) {
  LightSh light;
  light.fill(glm::vec3(value));
  return light;
}

LightSh randomLight(Random& random) {
  LightSh light;
  for (glm::vec3& coefficient : light) {
    for (int c = 0; c < 3; ++c) coefficient[c] = static_cast<float>(random.uniform(-1.0, 1.0));
  }
  return light;
}

// Places on a line between probe i and probe i + 1.
std::vector<LightSample> samplesOfLine(const std::vector<LightSh>& truth, int per_gap, Random& random) {
  std::vector<LightSample> samples;
  for (uint32_t i = 0; i + 1 < truth.size(); ++i) {
    for (int s = 0; s < per_gap; ++s) {
      const auto share = static_cast<float>(random.uniform());
      LightSample sample;
      sample.count = 2;
      sample.probe[0] = i;
      sample.probe[1] = i + 1;
      sample.weight[0] = 1.0f - share;
      sample.weight[1] = share;
      for (int k = 0; k < kShCount; ++k) sample.light[k] = truth[i][k] * (1.0f - share) + truth[i + 1][k] * share;
      samples.push_back(sample);
    }
  }
  return samples;
}

TEST(LightSolve, KeepsThePriorWhereNothingReads) {
  const std::vector<LightSh> prior = {uniformLight(1.0f), uniformLight(2.0f)};
  LightSample sample;
  sample.count = 1;
  sample.probe[0] = 0;
  sample.weight[0] = 1.0f;
  sample.light = uniformLight(3.0f);
  const LightSolution solution = solveLight({sample}, prior, {1.0f, 1.0f}, prior);
  // 1 (L - 3)² + 1 (L - 1)² is least at 2
  EXPECT_NEAR(solution.light[0][0].r, 2.0f, 1e-5f);
  EXPECT_EQ(solution.light[1], prior[1]);
  EXPECT_EQ(solveLight({}, prior, {1.0f, 1.0f}, prior).light, prior);
}

TEST(LightSolve, HoldsEachOrderByItsOwnPull) {
  LightSample sample;
  sample.count = 1;
  sample.weight[0] = 1.0f;
  sample.light = uniformLight(3.0f);
  LightSolveOptions options;
  options.order_pull = {1.0f, 2.0f, 5.0f};
  const std::vector<LightSh> prior = {uniformLight(0.0f)};
  const LightSh light = solveLight({sample}, prior, {1.0f}, prior, options).light[0];
  // 1 (L - 3)² + pull L² is least at 3 / (1 + pull)
  EXPECT_NEAR(light[0].r, 1.5f, 1e-5f);
  for (int k = 1; k < 4; ++k) EXPECT_NEAR(light[k].g, 1.0f, 1e-5f) << "coefficient " << k;
  for (int k = 4; k < kShCount; ++k) EXPECT_NEAR(light[k].b, 0.5f, 1e-5f) << "coefficient " << k;
}

TEST(LightSolve, FindsTheLightThatMadeTheSamples) {
  Random random(7);
  std::vector<LightSh> truth;
  for (int i = 0; i < 50; ++i) truth.push_back(randomLight(random));
  const std::vector<LightSample> samples = samplesOfLine(truth, 6, random);
  const std::vector<LightSh> prior(truth.size(), uniformLight(0.0f));
  const LightSolution solution = solveLight(samples, prior, std::vector<float>(truth.size(), 1e-4f), prior, {500, 1e-7});
  for (size_t p = 0; p < truth.size(); ++p) {
    for (int k = 0; k < kShCount; ++k) {
      // the pull of 1e-4 against curvatures of the order of 1 moves the answer by as much
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(solution.light[p][k][c], truth[p][k][c], 3e-3f) << "probe " << p;
    }
  }
  EXPECT_LT(solution.residual, 1e-6);
}

TEST(LightSolve, ComesToTheSameAnswerFromAnyStart) {
  Random random(8);
  std::vector<LightSh> truth, prior, elsewhere;
  for (int i = 0; i < 20; ++i) {
    truth.push_back(randomLight(random));
    prior.push_back(randomLight(random));
    elsewhere.push_back(randomLight(random));
  }
  const std::vector<LightSample> samples = samplesOfLine(truth, 6, random);
  const std::vector<float> pull(truth.size(), 0.1f);
  const LightSolution from_prior = solveLight(samples, prior, pull, prior, {500, 1e-7});
  const LightSolution from_elsewhere = solveLight(samples, prior, pull, elsewhere, {500, 1e-7});
  for (size_t p = 0; p < truth.size(); ++p) EXPECT_NEAR(from_prior.light[p][3].g, from_elsewhere.light[p][3].g, 1e-4f);
  // what is there already is left as it is
  EXPECT_LE(solveLight(samples, prior, pull, from_prior.light, {500, 1e-6}).iterations, 2);
}

TEST(LightSolve, FollowsImportance) {
  LightSample bright, dark;
  for (LightSample* sample : {&bright, &dark}) {
    sample->count = 1;
    sample->weight[0] = 1.0f;
  }
  bright.light = uniformLight(1.0f);
  bright.importance = 3.0f;
  const LightSolution solution = solveLight({bright, dark}, {uniformLight(0.0f)}, {1e-6f}, {uniformLight(0.0f)});
  EXPECT_NEAR(solution.light[0][4].g, 0.75f, 1e-5f);
}

}  // namespace
}  // namespace nlg
