#include "runtime_eval/fit/loss/loss_kernel.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/fit/reference_loss.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

const PointSet& points() { return stratifiedSupportPoints(); }

// Forward 24 roundings, backward 16, sums over a block of 256 points in 4 or more lanes 64 + 2, over 32 blocks 32 more.
constexpr double kRoundings = 24 + 16 + 64 + 2 + 32;

struct Gradient {
  double sum = 0.0;
  std::vector<double> values;
};

// phi and points of their own: `magnitude` is a network of magnitudes
Gradient magnitude(const Representation& r, const PointSet& set, int first, int count, const float* phi, const float* mask,
                   const Theta& theta) {
  Gradient result{0.0, std::vector<double>(r.thetaCount())};
  result.sum = networkLossAndGradientReference(magnitudeNetwork(r), r.slope, set, first, count, phi, mask,
                                               magnitudes(r, theta).data(), result.values.data());
  return result;
}

Gradient reference(const Representation& r, const PointSet& set, int first, int count, const float* phi, const float* mask,
                   const std::vector<double>& theta) {
  Gradient result{0.0, std::vector<double>(r.thetaCount())};
  result.sum = networkLossAndGradientReference(r, set, first, count, phi, mask, theta.data(), result.values.data());
  return result;
}

Gradient vectorised(const Representation& r, int first, int count, const float* phi, const float* mask, const Theta& theta) {
  std::vector<float> values(r.thetaCount());
  Gradient result;
  result.sum = networkLossAndGradient(r, points(), first, count, phi, mask, theta.data(), values.data());
  result.values.assign(values.begin(), values.end());
  return result;
}

TEST(LossReference, HasTheGradientOfCentralDifferences) {
  // A linear output is affine in each single parameter between kinks, so the loss is a parabola there and central differences are
  // exact but for rounding, 1e-16 of a loss of some hundreds divided by the step. With a sigmoid differences of two steps that
  // cancel the third derivative are off by step^4 of the fifth: 1e-16 of some thousands. Two steps of 1e-4 move no unit by 2e-2
  // (hidden values and weights stay below 100).
  const double step = 1e-4;
  for (const Representation& representation : kNetworkRepresentations) {
    const Theta start = randomTheta(representation, 11);
    WeightingFunction function = decoded(wallSample(1).view());
    maskKinks(representation, points(), start, 2e-2, &function.mask);
    weigh(&function.mask);
    std::vector<double> theta = toDouble(start);
    const auto at = [&] {
      return reference(representation, points(), 1024, 512, &function.phi[1024], &function.mask[1024], theta);
    };
    const Gradient gradient = at();
    ASSERT_GT(gradient.sum, 0.1);
    for (int k = 0; k < representation.thetaCount(); ++k) {
      const double middle = theta[k];
      const auto difference = [&](double by) {
        theta[k] = middle + by;
        const double above = at().sum;
        theta[k] = middle - by;
        const double below = at().sum;
        theta[k] = middle;
        return above - below;
      };
      ASSERT_NEAR(gradient.values[k], (8 * difference(step) - difference(2 * step)) / (12 * step), 1e-14 * gradient.sum / step)
          << representationName(representation) << ", slope " << representation.slope << ", theta " << k;
    }
  }
}

TEST(LossKernel, EqualsTheReferenceOnRaggedRangesAndEveryTarget) {
  struct Range {
    int first, count;
  };
  const Range ranges[] = {{0, 16}, {16, 32}, {48, 240}, {0, 256}, {1024, 272}, {2048, 1024}, {8176, 16}, {0, kSupportPointCount}};
  const PointSet absolute_points = magnitudes(points());
  for (const Representation& representation : kNetworkRepresentations) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      const Theta theta = randomTheta(representation, seed);
      WeightingFunction function = decoded(seed == 2 ? noiseSample(seed).view() : wallSample(seed).view());
      maskKinks(representation, points(), theta, 1e-3, &function.mask);
      if (seed == 1) weigh(&function.mask);
      const AlignedFloats minus_phi = negated(function.phi);
      for (const Range& range : ranges) {
        const float* phi = &function.phi[range.first];
        const float* mask = &function.mask[range.first];
        const Gradient expected = reference(representation, points(), range.first, range.count, phi, mask, toDouble(theta));
        const Gradient largest =
            magnitude(representation, absolute_points, range.first, range.count, &minus_phi[range.first], mask, theta);
        forEachTarget([&] {
          const Gradient got = vectorised(representation, range.first, range.count, phi, mask, theta);
          ASSERT_NEAR(got.sum, expected.sum, kRoundings * kFloatRounding * largest.sum) << range.first << " + " << range.count;
          for (int k = 0; k < representation.thetaCount(); ++k) {
            ASSERT_NEAR(got.values[k], expected.values[k], kRoundings * kFloatRounding * largest.values[k])
                << representationName(representation) << ", points " << range.first << " + " << range.count << ", theta " << k;
          }
          EXPECT_NEAR(networkLoss(representation, points(), range.first, range.count, phi, mask, theta.data()), expected.sum,
                      kRoundings * kFloatRounding * largest.sum);
        });
      }
    }
  }
}

TEST(LossKernel, IgnoresWhatStandsAtMaskedPoints) {
  const StoredSample sample = wallSample(4);
  const WeightingFunction function = decoded(sample.view());
  ASSERT_LT(function.validCount(), kSupportPointCount);
  WeightingFunction changed = function;
  Random random(5);
  for (int i = 0; i < kSupportPointCount; ++i) {
    if (changed.mask[i] == 0.0f) changed.phi[i] = static_cast<float>(1e6 * random.normal());
  }
  for (const Representation& representation : kNetworkRepresentations) {
    const Theta theta = randomTheta(representation, 4);
    forEachTarget([&] {
      const Gradient a = vectorised(representation, 0, kSupportPointCount, function.phi.data(), function.mask.data(), theta);
      const Gradient b = vectorised(representation, 0, kSupportPointCount, changed.phi.data(), changed.mask.data(), theta);
      EXPECT_EQ(a.sum, b.sum);
      EXPECT_EQ(a.values, b.values);
    });
  }
}

// phi, mask, theta and the gradient lie where the caller has them, and the gradient holds whatever stood there.
TEST(LossKernel, GivesTheSameBitsWhereverItsArraysLie) {
  const WeightingFunction function = decoded(noiseSample(8).view());
  for (const Representation& representation : kNetworkRepresentations) {
    const Theta theta = randomTheta(representation, 8);
    const int count = representation.thetaCount();
    forEachTarget([&] {
      const Gradient expected =
          vectorised(representation, 0, kSupportPointCount, function.phi.data(), function.mask.data(), theta);
      for (const int shift : {1, 3, 8}) {
        const auto shifted = [shift](const float* first, size_t size) {
          AlignedFloats moved(size + shift, NAN);
          std::copy(first, first + size, moved.begin() + shift);
          return moved;
        };
        const AlignedFloats phi = shifted(function.phi.data(), function.phi.size()),
                            mask = shifted(function.mask.data(), function.mask.size()),
                            moved = shifted(theta.data(), theta.size());
        AlignedFloats gradient(shift + count + 1, NAN);
        const double sum = networkLossAndGradient(representation, points(), 0, kSupportPointCount, &phi[shift], &mask[shift],
                                                  &moved[shift], &gradient[shift]);
        EXPECT_EQ(sum, expected.sum) << representationName(representation) << " at " << shift;
        for (int k = 0; k < count; ++k)
          EXPECT_EQ(gradient[shift + k], static_cast<float>(expected.values[k]))
              << representationName(representation) << " at " << shift << ", theta " << k;
        EXPECT_TRUE(std::isnan(gradient[shift - 1]) && std::isnan(gradient[shift + count])) << "written beyond its ends";
      }
    });
  }
}

}  // namespace
}  // namespace nlg
