#include "runtime_eval/policy/stage_runner.h"

#include <gtest/gtest.h>

#include <cstring>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/fit/last_layer.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

// The exact last layer where the weights have one, and nothing else.
constexpr StageOptions kNoFits{.good_rmse = 0.0, .lm_iterations = 0, .lm_theta0_iterations = 0, .adam_steps = 0};

// A generator whose network gives one theta, whatever the function; to the bit where theta0 is 0.
GeneratorData generatorOf(const Representation& representation, const Theta& theta, Theta theta0 = {}) {
  GeneratorData data = sampleGenerator(representation, 48, 3, 1);
  theta0.resize(theta.size(), 0.0f);
  GeneratorLayer& last = data.layers.back();
  std::fill(last.weight.begin(), last.weight.end(), 0.0f);
  for (size_t d = 0; d < theta.size(); ++d) last.bias[d] = theta[d] - theta0[d];
  data.output_scale.assign(theta.size(), 1.0f);
  data.theta0 = std::move(theta0);
  return data;
}

struct Improved {
  Theta start, theta;  // the network's; after all stages
  ThetaRecord record;
  bool changed() const { return std::memcmp(start.data(), theta.data(), theta.size() * sizeof(float)) != 0; }
};

// Nothing passes the check, so that every function takes the stages and no theta is put back.
PolicyOptions optionsOf(const StageOptions& stages, double tau_rmse) {
  PolicyOptions options;
  static_cast<StageOptions&>(options) = stages;
  options.check() = {tau_rmse, 1e9, 1.0, 1.0, 1.0};  // all points count alike
  return options;
}

Improved improve(const GeneratorData& data, const StoredSample& sample, const StageOptions& stages, double tau_rmse = 1e-9) {
  const Generator generator(data);
  StageRunner runner(generator, optionsOf(stages, tau_rmse));
  Improved improved;
  improved.theta.resize(data.representation.thetaCount());
  ThetaTrace trace;
  const StoredFunction stored = sample.view();
  runner.make(&stored, 1, improved.theta.data(), &improved.record, &trace);
  improved.start = trace.network;
  // the record tells as much
  EXPECT_EQ(improved.record.ended != ThetaStage::network, improved.changed());
  return improved;
}

const Representation kRepresentations[] = {Representation::mlp(), Representation::tentMlp(), Representation::productField(3)};
const Representation kExactNetworks[] = {Representation::mlp(), Representation::tentMlp()};
double rmseOf(const Representation& representation, const StoredSample& sample, const Theta& theta) {
  return functionRmse(representation, decoded(sample.view(), pointOrder(representation)), theta.data());
}

TEST(StageRunner, NeverMakesAThetaWorse) {
  constexpr StageOptions kShort{.good_rmse = 0.0, .lm_iterations = 2, .lm_theta0_iterations = 2, .adam_steps = 10};
  for (const Representation& representation : kRepresentations) {
    GeneratorData data = sampleGenerator(representation, 48, 3, 1);
    data.exact_last_layer = !representation.isField();
    const Generator generator(data);
    StageRunner runner(generator, optionsOf(kShort, 1e-9));
    const size_t D = static_cast<size_t>(representation.thetaCount());
    constexpr int kCount = 101;
    std::vector<StoredSample> samples;
    std::vector<StoredFunction> functions;
    for (int i = 0; i < kCount; ++i) samples.push_back(i % 3 == 2 ? noiseSample(i) : wallSample(i));
    for (const StoredSample& sample : samples) functions.push_back(sample.view());
    std::vector<float> theta(kCount * D);
    std::vector<ThetaRecord> records(kCount);
    ThetaTrace trace;
    runner.make(functions.data(), kCount, theta.data(), records.data(), &trace);
    for (int i = 0; i < kCount; ++i) {
      const Theta start(&trace.network[i * D], &trace.network[i * D] + D), end(&theta[i * D], &theta[i * D] + D);
      const double before = rmseOf(representation, samples[i], start), after = rmseOf(representation, samples[i], end);
      EXPECT_TRUE(start == end || after < before) << "function " << i << ": " << before << " became " << after;
      // whatever stands beside it
      Theta alone(D);
      ThetaRecord record;
      runner.make(&functions[i], 1, alone.data(), &record);
      EXPECT_EQ(alone, end) << "function " << i;
    }
  }
}

TEST(StageRunner, LeavesWhatItCannotMeasure) {
  const Representation representation = Representation::tentMlp();
  const StoredSample sample = wallSample(1);
  StoredSample nowhere = sample;
  std::fill(nowhere.validity.begin(), nowhere.validity.end(), uint8_t{0});
  const Theta start = randomTheta(representation, 4);
  Theta no_number = start, large = start;
  no_number[7] = NAN;
  large[7] = 1e30f;
  GeneratorData data = generatorOf(representation, start);
  data.exact_last_layer = true;
  EXPECT_FALSE(improve(data, nowhere, kNoFits).changed());
  for (const Theta& theta : {no_number, large}) {
    data = generatorOf(representation, theta);
    data.exact_last_layer = true;
    EXPECT_FALSE(improve(data, sample, kNoFits).changed()) << theta[7];
  }
}

TEST(StageRunner, TakesNoThetaThatFloat16CannotHold) {
  const Representation representation = Representation::tentMlp();
  Random random(5);
  int tempting = 0;
  for (uint64_t seed = 1; seed < 40; ++seed) {
    const StoredSample sample = wallSample(seed);
    // the first layer is far beyond float16, and the last one makes nothing of it: solved, it fits better
    Theta start = randomTheta(representation, seed);
    for (int d = ThetaLayout::w1; d < ThetaLayout::w2; ++d) start[d] = static_cast<float>(1e7 * random.normal());
    std::fill(start.begin() + ThetaLayout::w3, start.end(), 0.0f);
    GeneratorData data = generatorOf(representation, start);
    data.exact_last_layer = true;
    EXPECT_FALSE(improve(data, sample, kNoFits).changed()) << "seed " << seed;
    Theta beyond = start;
    solveLastLayer(representation, decoded(sample.view()), beyond.data());
    tempting += rmseOf(representation, sample, beyond) < rmseOf(representation, sample, start);
  }
  EXPECT_GT(tempting, 0) << "no function says anything";
}

TEST(StageRunner, TakesAnInfiniteThetaForNoThetaEvenWhereItsValuesAreFinite) {
  // the sigmoid of an infinite sum is 0 or 1
  const Representation representation{RepresentationKind::tent_mlp4};
  Theta theta(representation.thetaCount(), 0.1f);
  theta[representation.shape().b3()] = INFINITY;
  const GeneratorData data = generatorOf(representation, theta, randomTheta(representation, 3));
  const Improved improved = improve(data, wallSample(1), StageOptions{});
  EXPECT_TRUE(improved.changed());
  for (const float value : improved.theta) EXPECT_TRUE(std::isfinite(value));
}

// four times the steps at most, all of them from theta; then the last layer is solved
TEST(StageRunner, TakesItsStepsOfAdamFromTheta) {
  for (const Representation& representation : kExactNetworks) {
    const StoredSample sample = wallSample(1);
    const WeightingFunction function = decoded(sample.view(), pointOrder(representation));
    const GeneratorData data = generatorOf(representation, randomTheta(representation, 2), randomTheta(representation, 4));
    StageOptions options = kNoFits;
    options.adam_steps = 15, options.adam_rmse = 0.0, options.retry_rmse = 0.0;
    const Improved improved = improve(data, sample, options);
    FitResult alone = fitAdam(representation, function, improved.start, refinementAdam(representation, 4 * 15));
    ASSERT_TRUE(solveLastLayer(representation, function, alone.theta.data()));
    EXPECT_EQ(improved.theta, alone.theta);
  }
}

}  // namespace
}  // namespace nlg
