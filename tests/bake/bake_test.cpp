// A whole bake: a wall of which everything is known, and a procedural house.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "bake/report/bake_report.h"
#include "bake/scene_bake.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/policy/refinement.h"
#include "tests/bake/house_corner.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Where the wall of writeWall stands: x of its plane, metres; far from the origin, as the middle of a level may be.
constexpr double kWallX = 1000.25;

class SceneBakeTest : public testing::Test {
 protected:
  // A wall of 80 x 80 metres, seen from both sides.
  std::string writeWall() const {
    const float x = static_cast<float>(kWallX), s = 40.0f;
    const float corners[18] = {x, -s, -s, x, s, -s, x, s, s, x, -s, -s, x, s, s, x, -s, s};
    std::string bytes(sizeof(corners), '\0');
    std::memcpy(bytes.data(), corners, sizeof(corners));
    write("wall.bin", bytes);
    return write("wall.gltf",
                 R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                 R"("materials":[{"doubleSided":true}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],)"
                 R"("accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3","min":[1000.25,-40,-40],)"
                 R"("max":[1000.25,40,40]}],"bufferViews":[{"buffer":0,"byteLength":72}],)"
                 R"("buffers":[{"uri":"wall.bin","byteLength":72}]})");
  }
  std::string write(const std::string& name, const std::string& text) const { return folder_.write(name, text); }

  // Numbers at random, of which the last layer is to be solved: that lowers any error.
  static GeneratorData correctedData(uint64_t seed = 1) {
    GeneratorData data = sampleGenerator(Representation::tentMlp(), 24, 3, seed);
    data.exact_last_layer = true;
    return data;
  }
  // The same numbers without it.
  static GeneratorData plainData() {
    GeneratorData data = correctedData();
    data.exact_last_layer = false;
    return data;
  }
  static std::vector<Generator> only(const GeneratorData& data) {
    std::vector<Generator> result;
    result.emplace_back(data);
    return result;
  }

  // Probes at every metre, 5 metres to each side of the wall and along it.
  static BakeOptions wallOptions() {
    BakeOptions options;
    options.spacing_m = 1.0;
    options.density_growth = 0.0;
    options.extent_m = {"995", "-2", "-2", "1005", "2", "2"};
    options.light = "none";
    options.threads = 2;
    return options;
  }
  // How many functions have a theta that some stage after the network made.
  static uint64_t changed(const Bake& bake) {
    const auto& functions = bake.statistics.functions;
    return static_cast<uint64_t>(std::count_if(functions.begin(), functions.end(),
                                               [](const FunctionOutcome& f) { return f.record.ended != ThetaStage::network; }));
  }
  static uint64_t failing(const Bake& bake, ThetaWord word, const BakeOptions& options) {
    return bake.statistics.failing(word, options.policy.check());
  }

  // A corner of a house, refined for next to no time, its light left out.
  static BakeOptions houseOptions() {
    BakeOptions options = houseCornerOptions(1);
    options.light = "none";
    return options;
  }
  // … of which corrections alone are left.
  static BakeOptions correctedHouseOptions() {
    BakeOptions options = houseOptions();
    options.policy.refine_rounds = 0;
    options.policy.adam_steps = 0;
    return options;
  }

  Bake bake(const std::string& scene, const std::vector<Generator>& generators, const BakeOptions& options) const {
    return bakeScene(PreparedScene(scene, options), generators, options, folder_.string());
  }

  TemporaryFolder folder_;
};

TEST_F(SceneBakeTest, WeightsSumToOneInFreeSpaceAndKeepToTheirSideOfAWall) {
  const Bake wall = bake(writeWall(), sampleGenerators({"tent_mlp"}), wallOptions());
  ASSERT_EQ(failing(wall, ThetaWord::stored, wallOptions()), 0u);  // refined from numbers at random to within the check's limits
  Random random(3);
  LightGrid bare = wall.grid;  // the same probes, as if nothing stood among them
  std::fill(bare.probe_function.begin(), bare.probe_function.end(), kFreeSpace);
  const auto sameSide = [&](uint32_t probe, const PositionM& at) {
    return (wall.grid.tree.probePosition(probe)[0] < kWallX) == (at[0] < kWallX);
  };
  double leak_sum = 0.0, bare_leak_sum = 0.0, weight_sum = 0.0, bare_weight_sum = 0.0;
  int free_count = 0, wall_count = 0;
  for (int i = 0; i < 4000; ++i) {
    const PositionM at = {random.uniform(995.1, 1004.9), random.uniform(-1.9, 1.9), random.uniform(-1.9, 1.9)};
    ProbeWeights weights;
    ASSERT_TRUE(lookUpWeights(wall.grid, at, &weights)) << at[0] << " " << at[1] << " " << at[2];
    const double sum = std::accumulate(weights.weight, weights.weight + weights.count, 0.0);
    if (std::abs(at[0] - kWallX) > 2.0) {
      // all 8 probes are more than 1 m away from the wall: tents, and a sum of 8 floats of at most 1
      EXPECT_NEAR(sum, 1.0, 8 * 1.2e-7) << at[0];
      ++free_count;
      continue;
    }
    for (int c = 0; c < weights.count; ++c) (sameSide(weights.probe[c], at) ? weight_sum : leak_sum) += weights.weight[c];
    ASSERT_TRUE(lookUpWeights(bare, at, &weights));
    for (int c = 0; c < weights.count; ++c)
      (sameSide(weights.probe[c], at) ? bare_weight_sum : bare_leak_sum) += weights.weight[c];
    ++wall_count;
  }
  EXPECT_GT(free_count, 1000);
  EXPECT_GT(wall_count, 1000);
  // a bare tent knows of no wall: it is off by more than .1 RMSE on both functions, a theta that passes by at most .02
  EXPECT_LT(leak_sum, 0.2 * bare_leak_sum);
  // on the probe's own side phi is the tent, 1/8 on average: .02 of it is at most 16 %
  EXPECT_NEAR(weight_sum, bare_weight_sum, 0.16 * bare_weight_sum);
}

// A probe beside the wall sees the sample points on its own side, and the wall's other side is air: θ is what the network says of that.
TEST_F(SceneBakeTest, ADraftIsTheNetworksWordOnWhatProbesSee) {
  BakeOptions options = wallOptions();
  options.draft = true;
  const Generator generator(sampleGenerator(Representation::tentMlp(), 24, 3, 1, GeneratorInput::samples));
  const Bake draft = bakeScene(PreparedScene(writeWall(), options), {generator}, options, folder_.string());
  EXPECT_EQ(draft.statistics.tookFit(), 0u);
  GeneratorScratch scratch(generator);
  int checked = 0;
  for (size_t probe = 0; probe < draft.grid.tree.probeCount(); ++probe) {
    const uint32_t function = draft.grid.probe_function[probe];
    if (function == kFreeSpace || function == kNoWeight) continue;
    const double side = draft.grid.tree.probePosition(probe)[0] - kWallX;
    std::vector<uint8_t> seen(kSamplePointCount / 8, 0);
    const std::vector<uint8_t> valid(seen.size(), 0xff);
    for (int j = 0; j < kSamplePointCount; ++j) {
      if ((side + supportPattern().points[supportPointOf(j)][0] > 0.0) == (side > 0.0)) seen[j / 8] |= 1 << j % 8;
    }
    const VisibilitySamples samples{seen.data(), valid.data()};
    Theta expected(static_cast<size_t>(generator.representation().thetaCount()));
    generator.generate(&samples, 1, expected.data(), &scratch);
    roundTheta(generator.representation(), options.policy.theta_precision, expected.data());
    const float* theta = draft.grid.functionTheta(function);
    // phi is a byte in a bake: a number of θ may differ by a step of 1/32
    for (size_t k = 0; k < expected.size(); ++k)
      ASSERT_NEAR(theta[k], expected[k], 0.04 * std::max(1.0f, std::fabs(expected[k])));
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST_F(SceneBakeTest, ADraftNeedsAGeneratorOfSamples) {
  BakeOptions options = wallOptions();
  options.draft = true;
  EXPECT_THROW(bake(writeWall(), only(plainData()), options), UsageError);
}

TEST_F(SceneBakeTest, CorrectionsLowerErrorsOfAllThatTheyAreAskedFor) {
  BakeOptions options = correctedHouseOptions();
  const Bake plain = bake("house:3", only(plainData()), options);
  EXPECT_EQ(changed(plain), 0u);
  const uint64_t count = plain.statistics.counts.functions;
  ASSERT_GT(count, 20u);
  // all of them, or those alone that fail the check: here the same, as numbers at random do
  for (const double good_rmse : {0.0, 1e3}) {
    options.policy.good_rmse = good_rmse;
    const Bake corrected = bake("house:3", only(correctedData()), options);
    EXPECT_EQ(changed(corrected), count);
    EXPECT_LT(failing(corrected, ThetaWord::fitted, options), failing(plain, ThetaWord::fitted, options));
    for (size_t f = 0; f < count; ++f) {
      EXPECT_LT(corrected.statistics.functions[f].record.at(ThetaWord::stored).blend_rmse,
                plain.statistics.functions[f].record.at(ThetaWord::stored).blend_rmse)
          << "function " << f;
    }
  }
}

TEST_F(SceneBakeTest, CorrectsWhatFailsTheCheckOrIsAboveGoodRmse) {
  BakeOptions options = correctedHouseOptions();
  // which functions are bare tents goes by the loss: the same one throughout
  options.policy.dark_weight = options.policy.blend_floor = 1.0;
  const auto errorsOf = [](const Bake& bake) {
    std::vector<double> errors;
    for (const FunctionOutcome& function : bake.statistics.functions)
      errors.push_back(function.record.at(ThetaWord::stored).rmse);
    return errors;
  };
  const std::vector<double> plain = errorsOf(bake("house:3", only(plainData()), options));
  std::vector<double> sorted = plain;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  // once nothing fails the check but for its error, once nothing fails it at all
  for (const double tau_rmse : {median, 1e3}) {
    options.policy.check() = {tau_rmse, 1e3, 1.0, 1.0, 1.0};
    options.policy.good_rmse = tau_rmse == median ? 1e3 : median;
    const Bake some = bake("house:3", only(correctedData()), options);
    const std::vector<double> errors = errorsOf(some);
    uint64_t above = 0;
    for (size_t f = 0; f < plain.size(); ++f) {
      above += plain[f] > median;
      EXPECT_TRUE(plain[f] > median ? errors[f] < plain[f] : errors[f] == plain[f]) << "function " << f << ": " << errors[f];
    }
    EXPECT_GT(above, 0u);
    EXPECT_EQ(changed(some), above);
  }
  options.policy.good_rmse = 1e3;
  EXPECT_EQ(changed(bake("house:3", only(correctedData()), options)), 0u);
}

TEST_F(SceneBakeTest, CorrectionsNeverMakeAThetaFailTheCheckThatPassed) {
  // the bare tent everywhere: where nothing weighs but leaks, the last layer shuts them at the price of the rest
  GeneratorData tents = correctedData();
  const int first = tents.representation.shape().w3(), D = tents.representation.thetaCount();
  for (int d = first; d < D; ++d) {
    GeneratorLayer& last = tents.layers.back();
    std::fill_n(&last.weight[static_cast<size_t>(d) * last.input_count], last.input_count, 0.0f);
    last.bias[d] = tents.theta0[d] = d == D - 1 ? 1.0f : 0.0f;
  }
  BakeOptions options = correctedHouseOptions();
  options.policy.good_rmse = 0.0;
  options.policy.check() = {1e3, 1e6, 1.0, 1e6, 1.0};
  const Bake shut = bake("house:3", only(tents), options);
  double most = 0.0;
  for (const FunctionOutcome& f : shut.statistics.functions) most = std::max(most, f.record.at(ThetaWord::network).rmse);
  // all tents pass; some of what was shut would not
  options.policy.tau_rmse = most;
  const Bake house = bake("house:3", only(tents), options);
  EXPECT_EQ(failing(house, ThetaWord::fitted, options), 0u);
  EXPECT_GT(failing(shut, ThetaWord::fitted, options), 0u) << "what the check held back";
  EXPECT_EQ(changed(house) + failing(shut, ThetaWord::fitted, options), changed(shut));
}

// The functions are made once more, by themselves, and each is compared with the theta that the grid has for it.
class StoredThetaTest : public SceneBakeTest, public testing::WithParamInterface<ThetaPrecision> {};

TEST_P(StoredThetaTest, HasTheErrorThatTheBakeReports) {
  BakeOptions options = houseOptions();
  options.policy.theta_precision = GetParam();
  const CheckOptions& limits = options.policy.check();
  const PreparedScene scene("house:3", options);
  const Bake house = bakeScene(scene, sampleGenerators({"tent_mlp", "mlp"}), options, folder_.string());
  SceneFunctions functions(scene, options, 2, folder_.string());
  functions.makeAll([](int) { return [](const FunctionRows&) { return [] {}; }; });
  ASSERT_EQ(functions.counts().functions, house.grid.functionCount());
  EXPECT_EQ(functions.probeFunction(), house.grid.probe_function);
  ASSERT_EQ(house.statistics.functions.size(), house.grid.functionCount());
  FunctionChecker checker;
  std::vector<uint8_t> samples;
  uint64_t failing_count = 0;
  for (size_t f = 0; f < house.grid.functionCount(); ++f) {
    const ThetaRecord& record = house.statistics.functions[f].record;
    const Representation& representation = house.grid.representations[house.grid.function_representation[f]];
    const FunctionCheck check = checker.check(representation, functions.read(f, &samples), house.grid.functionTheta(f), limits);
    EXPECT_EQ(check.rmse, record.at(ThetaWord::stored).rmse) << "function " << f;
    failing_count += !check.passes(limits);
    // what passes at one word passes at the next, but for rounding
    EXPECT_GE(record.at(ThetaWord::fitted).passes(limits), record.at(ThetaWord::corrected).passes(limits)) << f;
    EXPECT_GE(record.at(ThetaWord::corrected).passes(limits), record.at(ThetaWord::network).passes(limits)) << f;
  }
  EXPECT_EQ(failing_count, failing(house, ThetaWord::stored, options));
}
std::string precisionName(const testing::TestParamInfo<ThetaPrecision>& precision) { return thetaPrecisionName(precision.param); }
INSTANTIATE_TEST_SUITE_P(Precisions, StoredThetaTest,
                         testing::Values(ThetaPrecision::float32, ThetaPrecision::float16, ThetaPrecision::int8), precisionName);

TEST_F(SceneBakeTest, LeavesFunctionsThatItHasNoTimeForAndSaysSo) {
  BakeOptions options = houseOptions();
  options.refine_seconds = 1e-9;
  const Bake house = bake("house:3", sampleGenerators({"tent_mlp"}), options);
  const BakeStatistics& s = house.statistics;
  EXPECT_GT(s.left_for_time, 0u);
  EXPECT_EQ(s.refined(), 0u);
  EXPECT_EQ(failing(house, ThetaWord::stored, options), s.left_for_time);
}

TEST_F(SceneBakeTest, CollectsTheFunctionsThatFailWorstFirst) {
  constexpr uint64_t kCollected = 7;
  BakeOptions options = houseOptions();
  options.refine_seconds = 1e-9;
  const PreparedScene scene("house:3", options);
  const Bake house = bakeScene(scene, sampleGenerators({"tent_mlp"}), options, folder_.string(), {}, kCollected);
  std::vector<FunctionCheck> checks;
  for (const FunctionOutcome& function : house.statistics.functions) checks.push_back(function.record.at(ThetaWord::stored));
  const std::vector<uint32_t> worst = worstFirst(checks, options.policy.check());
  ASSERT_GT(worst.size(), kCollected);
  // the functions as a shard would have them, made by somebody else
  SceneFunctions functions(scene, options, 2, folder_.string());
  FunctionRows all = emptyLike(house.failed), expected = emptyLike(house.failed);
  functions.makeAll([&all](int) {
    return [&all](const FunctionRows& chunk) { return [&all, chunk] { appendRows(chunk, 0, chunk.functionCount(), &all); }; };
  });
  for (uint64_t i = 0; i < kCollected; ++i) appendRows(all, worst[i], 1, &expected);
  forEachArray([](const char* name, const auto&, const auto& got, const auto& wanted) { EXPECT_EQ(got, wanted) << name; },
               house.failed, expected);
}

TEST_F(SceneBakeTest, RefusesASceneWithoutATriangle) {
  const std::string path = write("none.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{}]})");
  EXPECT_THROW(PreparedScene(path, wallOptions()), InputError);
  EXPECT_THROW(PreparedScene("castle:3", wallOptions()), InputError);
}

}  // namespace
}  // namespace nlg
