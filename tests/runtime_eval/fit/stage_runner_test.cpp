
#include <gtest/gtest.h>

#include <cstring>

#include "runtime_eval/fit/fit_result.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss_kernel.h"
#include "runtime_eval/fit/theta_policy.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

// Learned steps and nothing else, for any theta.
constexpr StageOptions kStepsAlone{
    .good_rmse = 0.0, .learned_steps = 8, .mirror_images = 1, .lm_iterations = 0, .lm_theta0_iterations = 0, .adam_steps = 0};

// Stages from a theta that stands in the network's place. Nothing passes the check, so that every function takes them and no theta
// is put back for its leaks.
class Improver {
 public:
  explicit Improver(const Generator& generator, const StageOptions& stages = {}, double tau_rmse = 1e-9)
      : theta_count_(static_cast<size_t>(generator.representation().thetaCount())),
        runner_(generator, optionsOf(stages, tau_rmse)) {}

  // How many theta changed.
  int improve(const StoredFunction* functions, int count, float* theta) {
    const std::vector<float> before(theta, theta + count * theta_count_);
    records_.resize(count);
    runner_.improve(functions, count, theta, records_.data());
    int changed = 0;
    for (int i = 0; i < count; ++i) {
      const bool same = std::memcmp(&before[i * theta_count_], theta + i * theta_count_, theta_count_ * sizeof(float)) == 0;
      // the record tells as much
      EXPECT_EQ(records_[i].ended == ThetaStage::network, same) << "function " << i;
      changed += !same;
    }
    return changed;
  }
  const ThetaRecord& record(int i) const { return records_[i]; }

 private:
  static PolicyOptions optionsOf(const StageOptions& stages, double tau_rmse) {
    PolicyOptions options;
    options.stages = stages;
    options.refinement.check = {tau_rmse, 1e9, 1.0};  // leaks do not count
    return options;
  }

  size_t theta_count_;
  StageRunner runner_;
  std::vector<ThetaRecord> records_;
};

const Representation kRepresentations[] = {Representation::mlp(), Representation::tentMlp(), Representation::productField(3)};

// A correction that takes `length` along the negative gradient, whatever the theta.
GeneratorData steepestDescent(const Representation& representation, double length, int step_count) {
  GeneratorData data = sampleGenerator(representation, 48, 3, 1);
  const CorrectionFeatures places{data.basis.coefficientCount(), representation.thetaCount()};
  const int D = representation.thetaCount();
  GeneratorLayer layer{places.count(), D, std::vector<float>(size_t(D) * places.count()), std::vector<float>(D)};
  for (int d = 0; d < D; ++d) {
    layer.weight[size_t(d) * places.count() + places.gradient() + d] =
        static_cast<float>(-length / (std::sqrt(D) * data.output_scale[d]));
  }
  data.correction.step_count = step_count;
  data.correction.layers = {layer};
  return data;
}

double rmseOf(const Representation& representation, const StoredSample& sample, const float* theta) {
  return functionRmse(representation, decodeFunction(sample.view(), pointOrder(representation)), theta);
}

TEST(LayerStack, RunsACorrectionAsItsFormulasSayOnEveryTarget) {
  for (const Representation& representation : kRepresentations) {
    // layers with a skip, wider than the inputs too, and one layer alone
    for (const auto& [layer_count, width] : {std::pair{1, 40}, {2, 40}, {4, 40}, {3, 320}}) {
      const GeneratorData data = withCorrection(sampleGenerator(representation, 48, 3, 1), width, layer_count, 2, 7);
      const CorrectionFeatures places{data.basis.coefficientCount(), representation.thetaCount()};
      forEachTarget([&] {
        const Generator generator(data);
        LayerScratch scratch(generator.correctionLayers());
        constexpr int kCount = 5;
        const int D = representation.thetaCount();
        std::vector<float> change(size_t(kCount) * D);
        Random random(3);
        for (int i = 0; i < kCount * places.count(); ++i) scratch.input()[i] = static_cast<float>(random.normal());
        const std::vector<float> features(scratch.input(), scratch.input() + kCount * places.count());
        generator.correctionLayers().run(kCount, change.data(), &scratch);
        for (int n = 0; n < kCount; ++n) {
          const std::vector<double> row(features.begin() + n * places.count(), features.begin() + (n + 1) * places.count());
          const std::vector<double> expected = correctionReference(data, row.data());
          // four layers of at most 283 roundings, or three of 320, of sums of magnitude 20 or less, times a scale of at most .2
          for (int d = 0; d < D; ++d) EXPECT_NEAR(change[size_t(n) * D + d], expected[d], 4 * 283 * 6e-8 * 20 * 0.2) << "d " << d;
        }
      });
    }
  }
}

TEST(StageRunner, FollowsTheGradientWhenItsNetworkSaysSo) {
  for (const Representation& representation : kRepresentations) {
    const double length = 1e-3;
    const Generator generator(steepestDescent(representation, length, 1));
    Improver improver(generator, kStepsAlone);
    for (uint64_t seed = 1; seed < 5; ++seed) {
      const StoredSample sample = wallSample(seed);
      const StoredFunction stored = sample.view();
      const Theta start = randomTheta(representation, seed);
      Theta corrected = start;
      ASSERT_EQ(improver.improve(&stored, 1, corrected.data()), 1) << "seed " << seed;
      const WeightingFunction function = decodeFunction(stored, pointOrder(representation));
      Theta gradient(start.size());
      lossAndGradient(representation, 0, pointOrder(representation).placeCount(), function.phi.data(), function.mask.data(),
                      start.data(), gradient.data());
      double norm = 0.0;
      for (const float value : gradient) norm += static_cast<double>(value) * value;
      norm = std::sqrt(norm);
      // roundings of theta, up to about 3, and of the direction
      for (size_t d = 0; d < start.size(); ++d) {
        EXPECT_NEAR(corrected[d], start[d] - length * gradient[d] / norm, 1e-6) << "d " << d;
      }
      EXPECT_LT(rmseOf(representation, sample, corrected.data()), rmseOf(representation, sample, start.data()));
    }
  }
}

TEST(StageRunner, GoesFurtherWithMoreSteps) {
  const Representation representation = Representation::tentMlp();
  const StoredSample sample = wallSample(2);
  const StoredFunction stored = sample.view();
  double last = INFINITY;
  const Generator generator(steepestDescent(representation, 2e-2, 1));
  for (const int step_count : {1, 2, 4}) {
    StageOptions options = kStepsAlone;
    options.learned_steps = step_count;
    Theta theta = randomTheta(representation, 2);
    Improver(generator, options).improve(&stored, 1, theta.data());
    const double rmse = rmseOf(representation, sample, theta.data());
    EXPECT_LT(rmse, last) << step_count << " steps";
    last = rmse;
  }
}

TEST(StageRunner, NeverMakesAThetaWorse) {
  for (const Representation& representation : kRepresentations) {
    const Generator generator(withCorrection(sampleGenerator(representation, 48, 3, 1), 40, 3, 3, 11));
    Improver improver(generator, kStepsAlone);
    const size_t D = static_cast<size_t>(representation.thetaCount());
    constexpr int kCount = 101;
    std::vector<StoredSample> samples;
    std::vector<StoredFunction> functions;
    std::vector<float> start;
    for (int i = 0; i < kCount; ++i) {
      samples.push_back(i % 3 == 2 ? noiseSample(i) : wallSample(i));
      const Theta theta = randomTheta(representation, i);
      start.insert(start.end(), theta.begin(), theta.end());
    }
    for (const StoredSample& sample : samples) functions.push_back(sample.view());
    std::vector<float> theta = start;
    int changed = 0;
    const int told = improver.improve(functions.data(), kCount, theta.data());
    for (int i = 0; i < kCount; ++i) {
      const double before = rmseOf(representation, samples[i], &start[i * D]),
                   after = rmseOf(representation, samples[i], &theta[i * D]);
      const bool same = std::equal(&start[i * D], &start[i * D] + D, &theta[i * D]);
      EXPECT_TRUE(same || after < before) << "function " << i << ": " << before << " became " << after;
      changed += !same;
      // whatever stands beside it
      std::vector<float> alone(&start[i * D], &start[i * D] + D);
      improver.improve(&functions[i], 1, alone.data());
      EXPECT_TRUE(std::equal(alone.begin(), alone.end(), &theta[i * D])) << "function " << i;
    }
    EXPECT_EQ(told, changed);
  }
}

TEST(StageRunner, LeavesWhatItCannotMeasure) {
  const Representation representation = Representation::tentMlp();
  const Generator generator(steepestDescent(representation, 1e-3, 2));
  Improver improver(generator, kStepsAlone);
  const StoredSample sample = wallSample(1);
  StoredSample nowhere = sample;
  std::fill(nowhere.validity.begin(), nowhere.validity.end(), uint8_t{0});
  const StoredFunction functions[] = {sample.view(), nowhere.view(), sample.view(), sample.view()};
  const size_t D = static_cast<size_t>(representation.thetaCount());
  std::vector<float> theta;
  for (int i = 0; i < 4; ++i) {
    const Theta one = randomTheta(representation, 4);
    theta.insert(theta.end(), one.begin(), one.end());
  }
  theta[2 * D + 7] = NAN;
  theta[3 * D + 7] = 1e30f;
  const std::vector<float> before = theta;
  EXPECT_EQ(improver.improve(functions, 4, theta.data()), 1);
  EXPECT_EQ(std::memcmp(&theta[D], &before[D], 3 * D * sizeof(float)), 0);
}

TEST(StageRunner, LeavesThetaThatItsNetworkWouldSendAstray) {
  for (const Representation& representation : kRepresentations) {
    // theta that overflow on their function, changes that are infinite, and changes that are not a number
    for (const auto& [weight, bias] : {std::pair{0.0f, 3e38f}, {3e38f, 0.0f}, {3e38f, -3e38f}}) {
      GeneratorData data = steepestDescent(representation, 1e-3, 3);
      GeneratorLayer& layer = data.correction.layers.front();
      for (size_t i = 0; i < layer.weight.size(); ++i) layer.weight[i] = i % 2 == 0 ? weight : -weight;
      std::fill(layer.bias.begin(), layer.bias.end(), bias);
      data.output_scale.assign(data.output_scale.size(), 1.0f);
      const Generator generator(data);
      const StoredSample sample = wallSample(1);
      const StoredFunction stored = sample.view();
      const Theta start = randomTheta(representation, 1);
      Theta theta = start;
      EXPECT_EQ(Improver(generator, kStepsAlone).improve(&stored, 1, theta.data()), 0) << weight << ' ' << bias;
      EXPECT_EQ(theta, start) << weight << ' ' << bias;
    }
  }
}

TEST(StageRunner, TakesTheSolutionWhereItsNetworkGoesAstray) {
  GeneratorData data = steepestDescent(Representation::tentMlp(), 1e-3, 2);
  data.correction.exact_last_layer = true;
  const StoredSample sample = wallSample(1);
  const StoredFunction stored = sample.view();
  Theta solved = randomTheta(data.representation, 1);
  ASSERT_TRUE(solveLastLayer(data.representation, decodeFunction(stored), solved.data()));
  std::fill(data.correction.layers.front().bias.begin(), data.correction.layers.front().bias.end(), 3e38f);
  const Generator generator(data);
  Improver improver(generator, kStepsAlone);
  Theta theta = randomTheta(data.representation, 1);
  EXPECT_EQ(improver.improve(&stored, 1, theta.data()), 1);
  EXPECT_EQ(theta, solved);
  // one that only its last layer makes infinite
  theta = randomTheta(data.representation, 1);
  theta[data.representation.shape().b3()] = NAN;
  EXPECT_EQ(improver.improve(&stored, 1, theta.data()), 1);
  EXPECT_EQ(theta, solved);
  // nothing to solve for
  StoredSample nowhere = sample;
  std::fill(nowhere.validity.begin(), nowhere.validity.end(), uint8_t{0});
  const StoredFunction empty = nowhere.view();
  theta = randomTheta(data.representation, 1);
  EXPECT_EQ(improver.improve(&empty, 1, theta.data()), 0);
  EXPECT_EQ(theta, randomTheta(data.representation, 1));
}

TEST(StageRunner, SolvesTheLastLayerWhenTheWeightsSaySo) {
  for (const Representation& representation : {Representation::mlp(), Representation::tentMlp()}) {
    GeneratorData data = sampleGenerator(representation, 48, 3, 1);
    data.correction.exact_last_layer = true;
    const Generator generator(data);
    Improver improver(generator, kStepsAlone);
    for (uint64_t seed = 1; seed < 5; ++seed) {
      const StoredSample sample = wallSample(seed);
      const StoredFunction stored = sample.view();
      const Theta start = randomTheta(representation, seed);
      Theta expected = start, theta = start;
      ASSERT_TRUE(solveLastLayer(representation, decodeFunction(stored), expected.data()));
      EXPECT_EQ(improver.improve(&stored, 1, theta.data()), 1);
      EXPECT_EQ(theta, expected) << "seed " << seed;
      // what is solved already stays
      EXPECT_EQ(improver.improve(&stored, 1, theta.data()), 0) << "seed " << seed;
      EXPECT_EQ(theta, expected) << "seed " << seed;
    }
  }
}

TEST(StageRunner, TakesNoThetaThatFloat16CannotHold) {
  const Representation representation = Representation::tentMlp();
  GeneratorData data = steepestDescent(representation, 0.0, 1);
  data.correction.exact_last_layer = true;
  // the first layer far beyond float16: it has kinks, where the start has none, and may well fit better
  Random random(5);
  for (int d = ThetaLayout::w1; d < ThetaLayout::w2; ++d) {
    data.correction.layers[0].bias[d] = static_cast<float>(1e7 * random.normal());
  }
  const Generator generator(data);
  Improver improver(generator, kStepsAlone);
  int tempting = 0;
  for (uint64_t seed = 1; seed < 40; ++seed) {
    const StoredSample sample = wallSample(seed);
    const StoredFunction stored = sample.view();
    // a start without kinks: the tent times a number
    Theta theta = randomTheta(representation, seed);
    std::fill(theta.begin() + ThetaLayout::w1, theta.begin() + ThetaLayout::w2, 0.0f);
    Theta beyond = theta;
    improver.improve(&stored, 1, theta.data());
    for (const float value : theta) EXPECT_LE(std::fabs(value), 65504.0f) << "seed " << seed;
    for (int d = ThetaLayout::w1; d < ThetaLayout::w2; ++d) beyond[d] += data.output_scale[d] * data.correction.layers[0].bias[d];
    solveLastLayer(representation, decodeFunction(stored), beyond.data());
    tempting += rmseOf(representation, sample, beyond.data()) < rmseOf(representation, sample, theta.data());
  }
  EXPECT_GT(tempting, 0) << "no function says anything";
}

TEST(StageRunner, DoesNothingWithoutStepsInTheWeights) {
  const Generator generator(sampleGenerator({}, 48, 3, 1));
  Improver improver(generator, kStepsAlone);
  const StoredSample sample = wallSample(1);
  const StoredFunction stored = sample.view();
  const Theta start = randomTheta({}, 1);
  Theta theta = start;
  EXPECT_EQ(improver.improve(&stored, 1, theta.data()), 0);
  EXPECT_EQ(theta, start);
}

// The same function seen in a mirror.
StoredSample mirrored(const StoredSample& sample, int mirror) {
  StoredSample image;
  for (int octant = 0; octant < kMirrorCount; ++octant) {
    const int from = (octant ^ mirror) * kOctantPointCount, to = octant * kOctantPointCount;
    std::copy_n(&sample.phi[from], kOctantPointCount, &image.phi[to]);
    std::copy_n(&sample.validity[from / 8], kOctantPointCount / 8, &image.validity[to / 8]);
  }
  return image;
}

TEST(StageRunner, TakesTheBestOfAllMirrorImages) {
  const Representation representation = Representation::tentMlp();
  GeneratorData data = withCorrection(sampleGenerator(representation, 48, 3, 1), 40, 3, 3, 11);
  data.correction.exact_last_layer = true;
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  Improver alone(generator, kStepsAlone);
  int from_an_image = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const StoredSample sample = wallSample(seed);
    const StoredFunction stored = sample.view();
    Theta theta(representation.thetaCount());
    double least = INFINITY, least_of_three = INFINITY, own = 0.0;
    for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
      const StoredSample image = mirrored(sample, mirror);
      const StoredFunction view = image.view();
      generator.generate(image.phi.data(), 1, theta.data(), &scratch);
      alone.improve(&view, 1, theta.data());
      const double rmse = rmseOf(representation, image, theta.data());
      if (mirror == 0) own = rmse;
      least = std::min(least, rmse);
      if (mirror < 3) least_of_three = least;
    }
    from_an_image += least < 0.99 * own;
    for (const auto& [image_count, expected] : {std::pair{8, least}, {3, least_of_three}, {1, own}}) {
      generator.generate(sample.phi.data(), 1, theta.data(), &scratch);
      StageOptions options = kStepsAlone;
      options.mirror_images = image_count;
      options.retry_rmse = 0.0;
      EXPECT_EQ(Improver(generator, options).improve(&stored, 1, theta.data()), 1) << "seed " << seed;
      // an image has to be better by a two-thousandth to be taken; sums in another order change the steps a little
      EXPECT_NEAR(rmseOf(representation, sample, theta.data()), expected, 2e-3 * expected) << "seed " << seed;
    }
    // good enough: not tried again
    generator.generate(sample.phi.data(), 1, theta.data(), &scratch);
    StageOptions content = kStepsAlone;
    content.mirror_images = 8;
    content.retry_rmse = 1.01 * own;
    Improver(generator, content).improve(&stored, 1, theta.data());
    EXPECT_NEAR(rmseOf(representation, sample, theta.data()), own, 1e-6 * own) << "seed " << seed;
  }
  EXPECT_GT(from_an_image, 5) << "images that say nothing";
}

// All valid, the bare tent.
StoredSample tentSample() {
  StoredSample sample;
  for (int p = 0; p < kSupportPointCount; ++p) {
    sample.phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
  }
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{0xff});
  return sample;
}

TEST(StageRunner, TriesAgainOnlyWhatIsWorseThanTheTentUpToTwiceTheThreshold) {
  const Representation representation;
  const Generator generator(withCorrection(sampleGenerator(representation, 48, 3, 1), 40, 3, 3, 11));
  GeneratorScratch scratch(generator);
  Theta theta(representation.thetaCount());
  const StoredSample bare = tentSample();
  generator.generate(bare.phi.data(), 1, theta.data(), &scratch);
  const double of_tent = rmseOf(representation, bare, theta.data());
  int tried = 0, content = 0;  // … where it makes a difference
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const StoredSample sample = wallSample(seed);
    const StoredFunction stored = sample.view();
    const auto rmseWith = [&](int images, double retry_rmse) {
      StageOptions options = kStepsAlone;
      options.mirror_images = images, options.retry_rmse = retry_rmse;
      generator.generate(sample.phi.data(), 1, theta.data(), &scratch);
      Improver(generator, options).improve(&stored, 1, theta.data());
      return rmseOf(representation, sample, theta.data());
    };
    const double own = rmseWith(1, 0.0), again = rmseWith(2, 0.0);
    if (again > 0.99 * own) continue;
    for (const double share : {0.3, 0.45, 0.51, 0.6, 0.8, 0.98}) {
      const double retry_rmse = share * own;
      const bool tries_again = own > std::clamp(1.25 * of_tent, retry_rmse, 2.0 * retry_rmse);
      EXPECT_NEAR(rmseWith(2, retry_rmse), tries_again ? again : own, 1e-6 * own) << "seed " << seed << ", share " << share;
      ++(tries_again ? tried : content);
    }
  }
  EXPECT_GT(tried, 0);
  EXPECT_GT(content, 0);
}

TEST(StageRunner, ReplacesAThetaThatIsNoNumberByThatOfAnImage) {
  const Representation representation = Representation::tentMlp();
  const Generator generator(withCorrection(sampleGenerator(representation, 48, 3, 1), 40, 3, 3, 11));
  Improver improver(generator, {.mirror_images = 2});
  const StoredSample sample = wallSample(1);
  const StoredFunction stored = sample.view();
  Theta theta(representation.thetaCount(), NAN);
  EXPECT_EQ(improver.improve(&stored, 1, theta.data()), 1);
  EXPECT_TRUE(std::isfinite(rmseOf(representation, sample, theta.data())));
}

TEST(StageRunner, TakesAnInfiniteThetaForNoThetaEvenWhereItsValuesAreFinite) {
  // the sigmoid of an infinite sum is 0 or 1
  const Representation representation{RepresentationKind::tent_mlp4};
  const Generator generator(withCorrection(sampleGenerator(representation, 48, 3, 1), 40, 3, 3, 11));
  const StoredSample sample = wallSample(1);
  const StoredFunction stored = sample.view();
  Theta theta(representation.thetaCount(), 0.1f);
  theta[representation.shape().b3()] = INFINITY;
  EXPECT_EQ(Improver(generator).improve(&stored, 1, theta.data()), 1);
  for (const float value : theta) EXPECT_TRUE(std::isfinite(value));
}

TEST(StageRunner, LeavesWhatIsGoodEnough) {
  for (const Representation& representation : kRepresentations) {
    const Generator generator(steepestDescent(representation, 1e-3, 2));
    const StoredSample sample = wallSample(1);
    const StoredFunction stored = sample.view();
    const Theta start = randomTheta(representation, 1);
    const double rmse = rmseOf(representation, sample, start.data());
    for (const double factor : {0.999, 1.001}) {
      Theta theta = start;
      StageOptions options = kStepsAlone;
      options.good_rmse = factor * rmse;
      EXPECT_EQ(Improver(generator, options, 1.0).improve(&stored, 1, theta.data()), factor < 1.0);
      EXPECT_EQ(theta == start, factor > 1.0);
    }
  }
}

// Fits as a correction does, where three iterations in a row are worth going on for only above 5 %.
FitResult iterated(const Representation& representation, const StoredSample& sample, const Theta& start, int iterations) {
  LevenbergMarquardtOptions options = refinementLevenbergMarquardt(representation, iterations);
  options.progress_tolerance = 0.05;
  NormalEquationsKernel kernel;
  return fitLevenbergMarquardt(representation, decodeFunction(sample.view(), pointOrder(representation)), start, options,
                               &kernel);
}

const Representation kFields[] = {Representation::productField(3), Representation::productField(5)};

TEST(StageRunner, EndsWithLevenbergMarquardtAfterOneStepForFields) {
  for (const Representation& representation : kFields) {
    const Generator generator(steepestDescent(representation, 1e-3, 1));
    const StoredSample sample = wallSample(4);
    const StoredFunction stored = sample.view();
    StageOptions one_step = kStepsAlone, iterating = kStepsAlone;
    one_step.learned_steps = 1;
    iterating.lm_iterations = 3;
    Theta stepped = randomTheta(representation, 4), theta = stepped;
    Improver(generator, one_step).improve(&stored, 1, stepped.data());
    const FitResult expected = iterated(representation, sample, stepped, 3);
    EXPECT_EQ(Improver(generator, iterating).improve(&stored, 1, theta.data()), 1);
    EXPECT_EQ(theta, expected.theta);
    EXPECT_LT(expected.rmse, 0.8 * rmseOf(representation, sample, stepped.data()));
  }
}

TEST(StageRunner, TakesTheta0ForAnotherStartOfAFunctionThatIsStillWrong) {
  for (const Representation& representation : kFields) {
    const Generator generator(steepestDescent(representation, 1e-3, 1));
    const StoredSample sample = wallSample(4);
    const StoredFunction stored = sample.view();
    StageOptions options = kStepsAlone;
    options.lm_theta0_iterations = 8;
    const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
    const FitResult expected = iterated(representation, sample, theta0, 8);
    const Theta start = randomTheta(representation, 4);
    Theta stepped = start;
    Improver(generator, kStepsAlone).improve(&stored, 1, stepped.data());
    const double before = rmseOf(representation, sample, stepped.data());
    ASSERT_LT(expected.rmse, 0.9 * before) << "a start that theta_0 is not better than says nothing";
    for (const double factor : {0.45, 1.01}) {
      Theta theta = start;
      options.retry_rmse = factor * before;
      EXPECT_EQ(Improver(generator, options).improve(&stored, 1, theta.data()), 1);
      EXPECT_EQ(theta, factor < 1.0 ? expected.theta : stepped);
    }
    // theta_0's fit is no better: kept is what came
    Theta best = iterated(representation, sample, expected.theta, 200).theta;
    const Theta kept = best;
    options.retry_rmse = 0.0;
    Improver(generator, options).improve(&stored, 1, best.data());
    EXPECT_LE(rmseOf(representation, sample, best.data()), rmseOf(representation, sample, kept.data()));
  }
}

// An eighth of the steps from theta and from theta_0 each, the rest from the better.
FitResult racedAdam(const Generator& generator, const WeightingFunction& function, const Theta& start, int steps) {
  const Representation representation = generator.representation();
  const auto fit = [&](const Theta& from, int count) {
    return fitAdam(representation, function, from, refinementAdam(representation, count));
  };
  const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
  const FitResult own = fit(start, steps / 8), other = fit(theta0, steps / 8);
  return fit(other.rmse < own.rmse ? other.theta : own.theta, steps - 2 * (steps / 8));
}

TEST(StageRunner, EndsWithAdamForNetworks) {
  int below_the_cap = 0;
  for (const Representation& representation : {Representation{}, Representation::tentMlp()}) {
    const Generator generator(withCorrection(sampleGenerator(representation, 48, 3, 1), 40, 3, 3, 11));
    const StoredSample sample = wallSample(1);
    const StoredFunction stored = sample.view();
    StageOptions options = kStepsAlone;
    options.lm_iterations = options.lm_theta0_iterations = 8;  // not there
    const Theta start = randomTheta(representation, 2);
    Theta stepped = start;
    Improver(generator, options).improve(&stored, 1, stepped.data());
    Theta of_steps = start;
    Improver(generator, kStepsAlone).improve(&stored, 1, of_steps.data());
    EXPECT_EQ(stepped, of_steps);
    const WeightingFunction function = decodeFunction(stored, pointOrder(representation));
    const double before = rmseOf(representation, sample, stepped.data());
    ASSERT_GT(before, 0.04) << "such functions take four times the steps";
    FitResult expected = racedAdam(generator, function, stepped, 4 * 60);
    ASSERT_LT(expected.rmse, 0.9 * before);
    // behind the steps the last layer is solved
    ASSERT_TRUE(solveLastLayer(representation, function, expected.theta.data()));
    ASSERT_LT(rmseOf(representation, sample, expected.theta.data()), expected.rmse);
    options.adam_steps = 60;
    options.retry_rmse = 0.0;
    Improver below(generator, [&] {
      auto o = options;
      o.adam_rmse = 0.99 * before;
      return o;
    }());
    Improver above(generator, [&] {
      auto o = options;
      o.adam_rmse = 1.01 * before;
      return o;
    }());
    // twice: what one function leaves in the workspace changes nothing for the next
    for (int run = 0; run < 2; ++run) {
      Theta theta = start;
      EXPECT_EQ(below.improve(&stored, 1, theta.data()), 1);
      EXPECT_EQ(theta, expected.theta);
    }
    Theta theta = start;
    above.improve(&stored, 1, theta.data());
    EXPECT_EQ(theta, stepped);
    // an RMSE below .04 takes steps in proportion
    const double fitted = rmseOf(representation, sample, expected.theta.data());
    const auto share = [&](double rmse) { return static_cast<int>(60 * std::min(4.0, rmse / 0.01)); };
    ASSERT_EQ(share(0.9999 * fitted), share(1.0001 * fitted)) << "a float away from another count";
    Theta again = expected.theta, expected_again = again;
    StageOptions adam_alone = kStepsAlone;
    adam_alone.learned_steps = 0, adam_alone.adam_steps = 60, adam_alone.adam_rmse = 0.0, adam_alone.retry_rmse = 0.0;
    Improver(generator, adam_alone).improve(&stored, 1, again.data());
    FitResult more = racedAdam(generator, function, expected_again, share(fitted));
    ASSERT_TRUE(solveLastLayer(representation, function, more.theta.data()));
    EXPECT_EQ(again, more.rmse < fitted ? more.theta : expected_again);
    below_the_cap += fitted < 0.04;
  }
  EXPECT_GT(below_the_cap, 0);
}

TEST(StageRunner, FitsFromTheta0WhereItsThetaLeadsNowhere) {
  for (const Representation& representation : {Representation{}, Representation::tentMlp()}) {
    GeneratorData data = sampleGenerator(representation, 48, 3, 1);
    data.theta0 = randomTheta(representation, 4);
    const Generator generator(data);
    const StoredSample sample = wallSample(1);
    const StoredFunction stored = sample.view();
    const WeightingFunction function = decodeFunction(stored, pointOrder(representation));
    // no unit of the first layer is open anywhere, and none leads to one that is
    Theta stuck = randomTheta(representation, 2);
    const NetworkShape& shape = representation.shape();
    std::fill_n(stuck.begin() + shape.b1(), shape.first, -100.0f);
    StageOptions options = kStepsAlone;
    options.learned_steps = 0, options.adam_steps = 60, options.adam_rmse = 0.0, options.retry_rmse = 0.0;
    const FitResult alone = fitAdam(representation, function, stuck, refinementAdam(representation, 4 * 60));
    const FitResult raced = racedAdam(generator, function, stuck, 4 * 60);
    ASSERT_LT(raced.rmse, 0.7 * alone.rmse);
    Theta theta = stuck;
    EXPECT_EQ(Improver(generator, options).improve(&stored, 1, theta.data()), 1);
    EXPECT_LE(rmseOf(representation, sample, theta.data()), raced.rmse);
    // too few steps for a race: all of them go from theta
    options.adam_steps = 1;
    theta = stuck;
    Improver(generator, options).improve(&stored, 1, theta.data());
    FitResult few = fitAdam(representation, function, stuck, refinementAdam(representation, 4));
    solveLastLayer(representation, function, few.theta.data());
    EXPECT_EQ(theta, few.theta);
  }
}

TEST(GeneratorWeights, KeepCorrectionSteps) {
  const GeneratorData data = withCorrection(sampleGenerator({}, 48, 3, 1), 40, 3, 2, 5);
  const WeightsFile file = weightsFromGenerator(data);
  GeneratorData read;
  ASSERT_TRUE(generatorFromWeights(file, &read).ok());
  EXPECT_EQ(read.correction.step_count, 2);
  ASSERT_EQ(read.correction.layers.size(), data.correction.layers.size());
  for (size_t l = 0; l < data.correction.layers.size(); ++l) {
    EXPECT_EQ(read.correction.layers[l].weight, data.correction.layers[l].weight);
    EXPECT_EQ(read.correction.layers[l].bias, data.correction.layers[l].bias);
  }
  // a file that says that it has steps must have all of them
  for (const char* key : {"correction.steps", "correction.layer_count", "correction.width"}) {
    WeightsFile broken = file;
    broken.metadata.erase(key);
    EXPECT_EQ(generatorFromWeights(broken, &read).status, FileStatus::tensor_missing) << key;
  }
  for (const char* steps : {"0", "-1", "17", "1.5", "two", ""}) {
    WeightsFile broken = file;
    broken.metadata["correction.steps"] = steps;
    EXPECT_EQ(generatorFromWeights(broken, &read).status, FileStatus::value_out_of_range) << steps;
  }
  for (const auto& [representation, is_linear] :
       {std::pair{Representation::tentMlp(), true}, {Representation::productField(3), false}}) {
    GeneratorData exact = sampleGenerator(representation, 48, 3, 1);
    exact.correction.exact_last_layer = true;
    const FileResult result = generatorFromWeights(weightsFromGenerator(exact), &read);
    EXPECT_EQ(result.status, is_linear ? FileStatus::ok : FileStatus::value_out_of_range) << result.detail;
    EXPECT_TRUE(!is_linear || read.correction.exact_last_layer);
  }
  // a correction reads theta in units of output_scale
  for (const float scale : {0.0f, -1e-38f}) {
    WeightsFile flat = file;
    flat.tensors["output_scale"].values[7] = scale;
    EXPECT_EQ(generatorFromWeights(flat, &read).status, FileStatus::value_out_of_range) << scale;
    for (const char* key : {"correction.steps", "correction.layer_count", "correction.width"}) flat.metadata.erase(key);
    flat.tensors.erase("correction.layer.0.weight");
    EXPECT_TRUE(generatorFromWeights(flat, &read).ok()) << scale;
  }
  // … or in one of its own, which files of version 1 have not
  GeneratorData with_unit = withCorrection(sampleGenerator(Representation::tentMlp(), 48, 3, 1), 40, 2, 3, 2);
  with_unit.correction.theta_unit = 0.7f;
  WeightsFile with = weightsFromGenerator(with_unit);
  for (const char* version : {"2", "3"}) {
    with.metadata["version"] = version;
    ASSERT_TRUE(generatorFromWeights(with, &read).ok());
    EXPECT_EQ(read.correction.theta_unit, 0.7f) << version;
  }
  for (const char* unit : {"0", "-1", "1e9"}) {
    with.metadata["correction.theta_unit"] = unit;
    EXPECT_EQ(generatorFromWeights(with, &read).status, FileStatus::value_out_of_range) << unit;
  }
  WeightsFile broken = file;
  broken.tensors.erase("correction.layer.1.bias");
  EXPECT_EQ(generatorFromWeights(broken, &read).status, FileStatus::tensor_missing);
  broken = file;
  broken.tensors["correction.layer.0.weight"].shape = {40, 3};
  EXPECT_EQ(generatorFromWeights(broken, &read).status, FileStatus::tensor_unexpected);
}

}  // namespace
}  // namespace nlg
