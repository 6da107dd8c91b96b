#include "train/generator/network/theta_stages.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "runtime_eval/fit/last_layer.h"
#include "tests/runtime_eval/fit/reference_loss.h"
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
    set.blend_sum.resize(set.phi.size(), 255);
    return TrainingData(std::move(set), sampleBasis(kSampleClasses, 1), sampleBasis(kSampleClasses, 1));
  }();
  return training;
}

// Judged on one batch of points, on some neighbours, on all of them.
const std::vector<Sample> kSamples = {{0, 0, 0, 1}, {1, 3, 7, 1}, {2, 7, 2, 2}, {3, 1, 4, 4}, {4, 4, 0, 8}, {0, 2, 6, 1}};

torch::Tensor randomThetaBatch(size_t count) {
  torch::Tensor batch = torch::empty({static_cast<int64_t>(count), ThetaLayout::count});
  for (size_t b = 0; b < count; ++b) {
    const Theta theta = randomTheta({}, 60 + b);
    std::copy(theta.begin(), theta.end(), batch.data_ptr<float>() + b * ThetaLayout::count);
  }
  return batch;
}

constexpr LossOptions kLoss{64.0, 0.2};

// The points of a sample: places [first, first + count) of the order.
struct SamplePoints {
  int first, count, valid_count = 0;
  AlignedFloats phi, mask;

  explicit SamplePoints(const Sample& sample)
      : first(sample.batch * kStratumPointCount), count(sample.batch_count * kStratumPointCount), phi(count), mask(count) {
    for (int b = 0; b < sample.batch_count; ++b) {
      valid_count += decodeBatch(stratumOrder(), sample.batch + b, data().function(sample.function), sample.mirror,
                                 LossWeights(kLoss), &phi[b * kStratumPointCount], &mask[b * kStratumPointCount]);
    }
  }
};

// Mean squared error of one sample in double.
double meanSquare(const Representation& representation, const Sample& sample, const std::vector<double>& theta) {
  const SamplePoints points(sample);
  std::vector<double> gradient(ThetaLayout::count);
  return networkLossAndGradientReference(representation, stratifiedSupportPoints(), points.first, points.count, points.phi.data(),
                                         points.mask.data(), theta.data(), gradient.data()) /
         points.valid_count;
}

torch::Tensor functionLoss(const torch::Tensor& theta, const Representation& representation, const std::vector<Sample>& samples) {
  return differentiable(measureTheta(theta, {representation, data(), samples, kLoss}), theta);
}

TEST(FunctionLoss, HasTheGradientOfFiniteDifferences) {
  // of sum_b w_b loss_b, in double. Float's gradient is off by 138 roundings of its terms (loss_kernel_test), whose sum is within
  // a hundred times the largest entry here; a step of 1e-6 may carry a unit across its kink at one or two of about 700 points.
  const double step = 1e-6;
  for (const Representation& representation : kBothRepresentations) {
    torch::Tensor theta = randomThetaBatch(kSamples.size()).requires_grad_();
    const torch::Tensor weight = torch::linspace(-1, 2, static_cast<int64_t>(kSamples.size()));
    (functionLoss(theta, representation, kSamples) * weight).sum().backward();
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
  const torch::Tensor losses = measureTheta(theta, {Representation::tentMlp(0.01f), data(), kSamples, kLoss}).mean_square;
  ASSERT_EQ(losses.sizes(), torch::IntArrayRef({static_cast<int64_t>(kSamples.size())}));
  for (size_t b = 0; b < kSamples.size(); ++b) {
    const float* row = theta.data_ptr<float>() + b * ThetaLayout::count;
    const double expected = meanSquare(Representation::tentMlp(0.01f), kSamples[b], {row, row + ThetaLayout::count});
    EXPECT_NEAR(losses[static_cast<int64_t>(b)].item<double>(), expected, 1e-4 * expected + 1e-6) << "sample " << b;
  }
}

TEST(SolveLastLayers, SolvesEachOnItsOwnPoints) {
  for (const Representation& representation : kBothRepresentations) {
    const torch::Tensor theta = randomThetaBatch(kSamples.size());
    const torch::Tensor solved = solveLastLayers(theta, {representation, data(), kSamples, kLoss});
    for (size_t b = 0; b < kSamples.size(); ++b) {
      const SamplePoints points(kSamples[b]);
      const float* row = theta.data_ptr<float>() + b * ThetaLayout::count;
      Theta expected(row, row + ThetaLayout::count);
      ASSERT_TRUE(
          solveLastLayer(representation, points.first, points.count, points.phi.data(), points.mask.data(), expected.data()));
      const float* got = solved.data_ptr<float>() + b * ThetaLayout::count;
      EXPECT_EQ(Theta(got, got + ThetaLayout::count), expected) << "sample " << b;
    }
    const torch::Tensor before = measureTheta(theta, {representation, data(), kSamples, kLoss}).mean_square;
    const torch::Tensor after = measureTheta(solved, {representation, data(), kSamples, kLoss}).mean_square;
    EXPECT_TRUE((after < before).all().item<bool>()) << before << '\n' << after;
  }
}

TEST(SolveLastLayers, IsAConstantToTheGradientInTheLastLayerAlone) {
  torch::Tensor theta = randomThetaBatch(kSamples.size()).requires_grad_();
  const torch::Tensor weight = torch::linspace(1, 2, theta.numel()).view_as(theta);
  (solveLastLayers(theta, {{}, data(), kSamples, kLoss}) * weight).sum().backward();
  const int64_t last = ThetaLayout::w3;
  EXPECT_TRUE(torch::equal(theta.grad().slice(1, 0, last), weight.slice(1, 0, last)));
  EXPECT_EQ(theta.grad().slice(1, last).abs().max().item<float>(), 0.0f);
}

TEST(TrainingData, FlipsTheSignsOfMirroredFunctions) {
  const int K = data().inputCount();
  std::vector<float> plain(K), mirrored(K), expected(K);
  const Projection projection(sampleBasis(kSampleClasses, 1));
  ProjectionScratch scratch;
  for (int64_t n = 0; n < 5; ++n) {
    for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
      std::vector<uint8_t> image(kSupportPointCount);
      for (int p = 0; p < kSupportPointCount; ++p) image[p] = data().function(n).phi[p ^ (mirror * kOctantPointCount)];
      const StoredFunction function{image.data(), data().function(n).validity};
      projection.project(&function, 1, expected.data(), &scratch);
      data().copyInput({.function = n, .mirror = mirror}, mirrored.data());
      // the mean lies in class 0 alone, which no mirror changes
      for (int k = 0; k < K; ++k) ASSERT_EQ(mirrored[k], expected[k]) << "function " << n << ", mirror " << mirror << ", " << k;
    }
  }
}

// Samples of a mirrored function are those of its mirror image, whole or of visibility alone.
TEST(TrainingData, MirrorsSamples) {
  const BasisData trained{.input = GeneratorInput::samples};
  const TrainingData samples(sampleSet(5, 1), sampleBasis(kSampleClasses, 1), trained);
  ASSERT_EQ(samples.inputCount(), kSampleInputCount);
  std::vector<float> mirrored(kSampleInputCount), expected(kSampleInputCount);
  for (int64_t n = 0; n < 5; ++n) {
    const StoredFunction function = samples.function(n);
    for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
      StoredSample image;
      std::vector<uint8_t> seen(kValidityByteCount, 0);
      for (int p = 0; p < kSupportPointCount; ++p) {
        const int from = p ^ (mirror * kOctantPointCount);
        image.phi[p] = function.phi[from];
        if (function.isValid(from)) image.validity[p / 8] |= 1 << p % 8;
        if (function.seen[from / 8] >> (from % 8) & 1) seen[p / 8] |= 1 << p % 8;
      }
      StoredFunction view = image.view();
      view.seen = seen.data();
      for (const bool visibility_only : {false, true}) {
        visibility_only ? visibilityClasses(view, expected.data()) : sampleClasses(view, expected.data());
        samples.copyInput({.function = n, .mirror = mirror, .visibility_only = visibility_only}, mirrored.data());
        // eight terms in another order
        for (int k = 0; k < kSampleInputCount; ++k)
          ASSERT_NEAR(mirrored[k], expected[k], 1e-6) << n << ", " << mirror << ", " << k;
      }
    }
  }
}

}  // namespace
}  // namespace nlg
