// What validation publishes is what a bake does: the same functions come to the same theta, bit for bit, and to the same verdicts,
// whatever batches and threads either runs in.

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "bake/scene_bake.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/temporary_folder.h"
#include "validate/generators/policy_words.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

// A function's samples.
struct Samples {
  std::vector<uint8_t> bytes;
  StoredFunction view() const {
    const uint8_t* validity = bytes.data() + kSupportPointCount;
    return {bytes.data(), validity, nullptr, validity + kValidityByteCount};
  }
};

class BakeEqualsValidation : public testing::Test {
 protected:
  static Generator generatorOf(const std::string& representation) {
    const std::string path = std::string(NLG_SOURCE_WEIGHTS) + "/" + representation + ".safetensors";
    Generator generator;
    const FileResult result = Generator::load(path, &generator);
    EXPECT_TRUE(result.ok()) << path << ": " << result.detail;
    return generator;
  }

  // A corner of a house. Refinement is short, and so strict a check that some functions take it and some fail it even then.
  static BakeOptions houseOptions(ThetaPrecision precision) {
    BakeOptions options;
    options.spacing_m = 1.5;
    options.extent_m = {"0", "0", "0", "6", "6", "3"};
    // the same bytes: whether a bare tent stands in the list then changes no other function's place
    options.duplicate_rms = 0.0;
    options.duplicate_validity_points = 0;
    options.policy.tau_rmse = 0.008;
    options.policy.refine_rounds = 2;
    options.policy.refine_first_steps = 30;
    options.policy.adam_steps = 40;
    options.policy.theta_precision = precision;
    options.light = "none";
    options.threads = 2;
    return options;
  }

  // Every distinct function of the scene, those that take no theta included, in the bake's order, and each probe's function.
  std::vector<Samples> allFunctions(const PreparedScene& scene, BakeOptions options,
                                    std::vector<uint32_t>* probe_function) const {
    options.policy.bare_tent_rmse = 0.0;
    SceneFunctions functions(scene, options, 1, folder_.string());
    std::vector<Samples> result;
    functions.makeAll([](int) { return [](const FunctionRows&) { return [] {}; }; });
    for (uint64_t n = 0; n < functions.counts().functions; ++n) functions.read(n, &result.emplace_back().bytes);
    *probe_function = functions.probeFunction();
    return result;
  }

  void expectTheSame(const std::vector<std::string>& representations, ThetaPrecision precision) const;

  const TemporaryFolder folder_;
};

void expectSameCheck(const FunctionCheck& baked, const FunctionCheck& validated, const std::string& where) {
  EXPECT_EQ(baked.blend_rmse, validated.blend_rmse) << where;
  EXPECT_EQ(baked.rmse, validated.rmse) << where;
  EXPECT_EQ(baked.leak_mean, validated.leak_mean) << where;
  EXPECT_EQ(baked.leak_share, validated.leak_share) << where;
}

void BakeEqualsValidation::expectTheSame(const std::vector<std::string>& representations, ThetaPrecision precision) const {
  std::vector<Generator> generators;
  for (const std::string& name : representations) generators.push_back(generatorOf(name));
  std::vector<const Generator*> pointers;
  for (const Generator& generator : generators) pointers.push_back(&generator);
  const BakeOptions options = houseOptions(precision);
  const PreparedScene scene("house:3", options);
  const Bake bake = bakeScene(scene, generators, options, folder_.string());
  std::vector<uint32_t> probe_function;
  const std::vector<Samples> samples = allFunctions(scene, options, &probe_function);
  std::vector<StoredFunction> functions;
  for (const Samples& one : samples) functions.push_back(one.view());

  for (const PolicyRunOptions run : {PolicyRunOptions{1, 7}, PolicyRunOptions{3, kBatchCount}}) {
    const std::vector<MadeTheta> made = runPolicy(pointers, functions, options.policy, run);
    const std::string with = std::to_string(run.threads) + " threads, batches of " + std::to_string(run.batch);
    size_t number = 0, refined = 0, failing = 0;
    for (size_t i = 0; i < made.size(); ++i) {
      if (made[i].isBareTent()) continue;
      const std::string where = with + ", function " + std::to_string(i);
      ASSERT_LT(number, bake.statistics.functions.size()) << where;
      const ThetaRecord &baked = bake.statistics.functions[number].record, &validated = made[i].record;
      ASSERT_EQ(bake.statistics.functions[number].generator, made[i].generator) << where;
      const float* theta = bake.grid.functionTheta(number);
      EXPECT_EQ(std::memcmp(theta, made[i].theta.data(), made[i].theta.size() * sizeof(float)), 0) << where;
      for (int w = 0; w < kThetaWordCount; ++w) {
        expectSameCheck(baked.check[w], validated.check[w], where + ", " + wordName(static_cast<ThetaWord>(w)));
      }
      EXPECT_EQ(baked.ended, validated.ended) << where;
      EXPECT_EQ(baked.took_fit, validated.took_fit) << where;
      EXPECT_EQ(baked.refined, validated.refined) << where;
      refined += validated.refined;
      failing += !made[i].check().passes(options.policy.check());
      ++number;
    }
    EXPECT_EQ(number, bake.statistics.functions.size()) << with;
    EXPECT_GT(refined, 0u) << "a case without refinement shows nothing of it";
    EXPECT_EQ(failing, bake.statistics.failing(ThetaWord::stored, options.policy.check())) << with;
    uint64_t bare_probes = 0;
    for (const uint32_t function : probe_function) bare_probes += function < made.size() && made[function].isBareTent();
    EXPECT_EQ(bare_probes, bake.statistics.bare_tents.count) << with;
    EXPECT_GT(bare_probes, 0u) << "a case without bare tents shows nothing of them";
  }
}

TEST_F(BakeEqualsValidation, ForANetwork) { expectTheSame({"mlp"}, ThetaPrecision::float32); }
TEST_F(BakeEqualsValidation, ForANetworkInHalfPrecision) { expectTheSame({"mlp"}, ThetaPrecision::float16); }
TEST_F(BakeEqualsValidation, ForAProductField) { expectTheSame({"pf3"}, ThetaPrecision::float32); }
TEST_F(BakeEqualsValidation, ForTheChoiceBetweenRepresentations) { expectTheSame({"pf3", "pf5"}, ThetaPrecision::float16); }

}  // namespace
}  // namespace nlg
