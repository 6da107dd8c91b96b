#include "train/generator/function_loss.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "runtime_eval/fit/network_loss.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/sample_set.h"

namespace nlg {
namespace {

// One function more than the walls: nowhere valid.
const TrainingData& data() {
  static const TrainingData training = [] {
    FunctionSet set = sampleSet(5, 1);
    set.scene_idx.push_back(0);
    set.phi.resize(set.phi.size() + kSupportPointCount, 0);
    set.validity.resize(set.validity.size() + kValidityByteCount, 0);
    set.seen = set.validity;
    return TrainingData(std::move(set), sampleBasis(kSampleClasses, 1));
  }();
  return training;
}

const std::vector<Sample> kSamples = {{0, 0, 0}, {1, 3, 7}, {2, 7, 2}, {3, 1, 5}, {4, 4, 1}, {0, 2, 6}};

torch::Tensor randomThetaBatch(size_t count) {
  torch::Tensor batch = torch::empty({static_cast<int64_t>(count), ThetaLayout::count});
  for (size_t b = 0; b < count; ++b) {
    const Theta theta = randomTheta({}, 60 + b);
    std::copy(theta.begin(), theta.end(), batch.data_ptr<float>() + b * ThetaLayout::count);
  }
  return batch;
}

// Mean squared error of one sample in double; gradient may be null.
double meanSquare(const Representation& representation, const Sample& sample, const std::vector<double>& theta) {
  std::vector<float> phi(kStratumPointCount), mask(kStratumPointCount);
  std::vector<double> gradient(ThetaLayout::count);
  const int count =
      decodeBatch(stratumOrder(), sample.batch, data().function(sample.function), sample.mirror, phi.data(), mask.data());
  return networkLossAndGradientReference(representation, stratifiedSupportPoints(), sample.batch * kStratumPointCount,
                                         kStratumPointCount, phi.data(), mask.data(), theta.data(), gradient.data()) /
         count;
}

TEST(FunctionLoss, HasTheGradientOfFiniteDifferences) {
  // of sum_b w_b loss_b, in double. Float's gradient is off by 138 roundings of its terms (loss_kernel_test), whose sum is within
  // a hundred times the largest entry here; a step of 1e-6 may carry a unit across its kink at one or two of about 700 points.
  const double step = 1e-6;
  for (const Representation& representation : kBothRepresentations) {
    torch::Tensor theta = randomThetaBatch(kSamples.size()).requires_grad_();
    const torch::Tensor weight = torch::linspace(-1, 2, static_cast<int64_t>(kSamples.size()));
    (functionLoss(theta, representation, data(), kSamples) * weight).sum().backward();
    for (size_t b = 0; b < kSamples.size(); ++b) {
      const float* row = theta.data_ptr<float>() + b * ThetaLayout::count;
      const float* gradient = theta.grad().data_ptr<float>() + b * ThetaLayout::count;
      std::vector<double> exact(row, row + ThetaLayout::count);
      float largest = 0.0f;
      for (int k = 0; k < ThetaLayout::count; ++k) largest = std::max(largest, std::fabs(gradient[k]));
      for (int k = 0; k < ThetaLayout::count; ++k) {
        const double middle = exact[k];
        exact[k] = middle + step;
        const double above = meanSquare(representation, kSamples[b], exact);
        exact[k] = middle - step;
        const double below = meanSquare(representation, kSamples[b], exact);
        exact[k] = middle;
        const double expected = weight[static_cast<int64_t>(b)].item<double>() * (above - below) / (2 * step);
        ASSERT_NEAR(gradient[k], expected, (100 * 138 * kFloatRounding + 2.0 / 700) * largest)
            << "sample " << b << ", theta " << k;
      }
    }
  }
}

TEST(FunctionLoss, IsTheMeanSquaredErrorOfEachSample) {
  const torch::Tensor theta = randomThetaBatch(kSamples.size());
  const torch::Tensor losses = functionLoss(theta, Representation::tentMlp(0.01f), data(), kSamples);
  ASSERT_EQ(losses.sizes(), torch::IntArrayRef({static_cast<int64_t>(kSamples.size())}));
  for (size_t b = 0; b < kSamples.size(); ++b) {
    const float* row = theta.data_ptr<float>() + b * ThetaLayout::count;
    const double expected = meanSquare(Representation::tentMlp(0.01f), kSamples[b], {row, row + ThetaLayout::count});
    EXPECT_NEAR(losses[static_cast<int64_t>(b)].item<double>(), expected, 1e-4 * expected + 1e-6) << "sample " << b;
  }
}

TEST(FunctionLoss, IsZeroForAStratumWithoutAnyValidPoint) {
  torch::Tensor theta = randomThetaBatch(2).requires_grad_();
  const torch::Tensor losses = functionLoss(theta, {}, data(), {{5, 0, 3}, {0, 0, 3}});
  EXPECT_EQ(losses[0].item<float>(), 0.0f);
  EXPECT_GT(losses[1].item<float>(), 0.0f);
  losses.sum().backward();
  EXPECT_EQ(theta.grad()[0].abs().max().item<float>(), 0.0f);
  EXPECT_GT(theta.grad()[1].abs().max().item<float>(), 0.0f);
}

TEST(FunctionLoss, DoesNotDependOnTheNumberOfThreads) {
  const auto lossesAndGradient = [](int threads) {
    at::set_num_threads(threads);
    std::vector<Sample> samples;
    for (int b = 0; b < 100; ++b) samples.push_back({b % 5, b % 8, b % 7});
    torch::Tensor theta = randomThetaBatch(samples.size()).requires_grad_();
    const torch::Tensor losses = functionLoss(theta, {}, data(), samples);
    losses.sum().backward();
    return std::pair{losses.detach(), theta.grad()};
  };
  const auto [loss_1, gradient_1] = lossesAndGradient(1);
  const auto [loss_2, gradient_2] = lossesAndGradient(2);
  at::set_num_threads(1);
  EXPECT_TRUE(torch::equal(loss_1, loss_2));
  EXPECT_TRUE(torch::equal(gradient_1, gradient_2));
}

TEST(FunctionLoss, ReadsThetaThatIsNotContiguous) {
  const torch::Tensor theta = randomThetaBatch(3);
  const std::vector<Sample> samples(kSamples.begin(), kSamples.begin() + 3);
  const torch::Tensor transposed = theta.t().contiguous().t();
  ASSERT_FALSE(transposed.is_contiguous());
  EXPECT_TRUE(torch::equal(functionLoss(transposed, {}, data(), samples), functionLoss(theta, {}, data(), samples)));
}

TEST(TrainingData, FlipsTheSignsOfMirroredFunctions) {
  const int K = data().coefficientCount();
  std::vector<float> plain(K), mirrored(K), expected(K);
  const Projection projection(sampleBasis(kSampleClasses, 1));
  ProjectionScratch scratch(GeneratorPrecision::float32);
  for (int64_t n = 0; n < 5; ++n) {
    for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
      std::vector<uint8_t> image(kSupportPointCount);
      for (int p = 0; p < kSupportPointCount; ++p) image[p] = data().function(n).phi[p ^ (mirror * kOctantPointCount)];
      projection.project(image.data(), 1, expected.data(), &scratch);
      data().copyCoefficients(n, mirror, mirrored.data());
      // the mean lies in class 0 alone, which no mirror changes
      for (int k = 0; k < K; ++k) ASSERT_EQ(mirrored[k], expected[k]) << "function " << n << ", mirror " << mirror << ", " << k;
    }
  }
}

TEST(SampleOrder, VisitsEveryFunctionOnceAnEpoch) {
  for (const auto& [functions, batch] : std::vector<std::pair<int64_t, int>>{{10, 5}, {7, 3}, {3, 8}, {1, 4}}) {
    SampleOrder order(functions, batch, 8, 5);
    std::vector<int64_t> visited;
    for (int64_t step = 0; static_cast<int64_t>(visited.size()) < 20 * functions; ++step) {
      const std::vector<Sample> samples = order.samples(step);
      ASSERT_EQ(samples.size(), static_cast<size_t>(batch));
      for (const Sample& sample : samples) {
        visited.push_back(sample.function);
        ASSERT_TRUE(sample.mirror >= 0 && sample.mirror < 8 && sample.batch >= 0 && sample.batch < 8) << "step " << step;
      }
    }
    for (int64_t epoch = 0; epoch < 20; ++epoch) {
      std::vector<int64_t> once(visited.begin() + epoch * functions, visited.begin() + (epoch + 1) * functions);
      std::sort(once.begin(), once.end());
      for (int64_t n = 0; n < functions; ++n)
        ASSERT_EQ(once[n], n) << functions << " functions, batch " << batch << ", epoch " << epoch;
    }
  }
}

TEST(SampleOrder, IsAPureFunctionOfSeedAndStep) {
  const auto same = [](const std::vector<Sample>& a, const std::vector<Sample>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Sample& s, const Sample& t) {
      return s.function == t.function && s.mirror == t.mirror && s.batch == t.batch;
    });
  };
  SampleOrder forwards(11, 4, 8, 9), jumping(11, 4, 8, 9), other(11, 4, 8, 10);
  std::vector<std::vector<Sample>> expected;
  for (int64_t step = 0; step < 40; ++step) expected.push_back(forwards.samples(step));
  int different = 0;
  for (const int64_t step : {39, 0, 17, 17, 3, 38, 2, 20}) {
    EXPECT_TRUE(same(jumping.samples(step), expected[step])) << "step " << step;
    different += !same(other.samples(step), expected[step]);
  }
  EXPECT_EQ(different, 8) << "another seed";
}

}  // namespace
}  // namespace nlg
