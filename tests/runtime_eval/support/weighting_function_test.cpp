
#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

TEST(DecodeBatch, EqualsTheNaiveDecodeUnderAllMirrors) {
  const StoredSample sample = noiseSample(1);
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
    for (int stratum = 0; stratum < kStratumCount; ++stratum) {
      float phi[kStratumPointCount], mask[kStratumPointCount];
      const int valid_count = decodeBatch(stratumOrder(), stratum, sample.view(), mirror, LossWeights(kUnweighed), phi, mask);
      int expected_count = 0;
      for (int at = 0; at < kStratumPointCount; ++at) {
        // from the definitions: stratum order to pattern order, then the point whose value this one takes
        const int index = (at / 32 % 8) * kOctantPointCount + 32 * (at % 32) + 8 * (at / 256) + stratum;
        const int source = index ^ (mirror * kOctantPointCount);
        ASSERT_EQ(mask[at], sample.valid(source) ? 1.0f : 0.0f) << "mirror " << mirror << ", stratum " << stratum << ", " << at;
        // one product of floats: within half a unit in the last place of the constant and of the product
        ASSERT_NEAR(phi[at], sample.phi[source] / 255.0, 2 * kFloatRounding) << "byte " << int{sample.phi[source]};
        expected_count += sample.valid(source);
      }
      ASSERT_EQ(valid_count, expected_count) << "mirror " << mirror << ", stratum " << stratum;
    }
  }
}

TEST(DecodeFunction, JoinsItsStrata) {
  const StoredSample sample = noiseSample(3);
  const WeightingFunction function = decoded(sample.view(), stratumOrder());
  int total = 0;
  for (int k = 0; k < kStratumCount; ++k) {
    float phi[kStratumPointCount], mask[kStratumPointCount];
    const int count = decodeBatch(stratumOrder(), k, sample.view(), 0, LossWeights(kUnweighed), phi, mask);
    EXPECT_EQ(function.valid_count[k], count) << "stratum " << k;
    EXPECT_TRUE(std::equal(phi, phi + kStratumPointCount, &function.phi[k * kStratumPointCount])) << "stratum " << k;
    EXPECT_TRUE(std::equal(mask, mask + kStratumPointCount, &function.mask[k * kStratumPointCount])) << "stratum " << k;
    total += count;
  }
  EXPECT_EQ(function.validCount(), total);
}

TEST(DecodeFunction, WeighsDarkPointsAndNotTheRimOfTheTent) {
  for (const Representation& representation : {Representation::tentMlp(), Representation::productField(5)}) {
    const PointOrder& order = pointOrder(representation);
    const StoredSample sample = wallSample(5);
    const WeightingFunction plain = decoded(sample.view(), order), weighed = decoded(sample.view(), order, {16.0, 1.0});
    EXPECT_EQ(weighed.phi, plain.phi);
    EXPECT_EQ(weighed.valid_count, plain.valid_count);
    int dark = 0, rim = 0;
    for (int place = 0; place < order.placeCount(); ++place) {
      const int p = order.pattern_index[place];
      if (p < 0 || !sample.valid(p)) {
        EXPECT_EQ(weighed.mask[place], 0.0f) << place;
        continue;
      }
      const bool is_dark = sample.phi[p] == 0, is_rim = std::lround(255.0f * tent(supportPattern().points[p])) == 0;
      EXPECT_EQ(weighed.mask[place], is_dark && !is_rim ? 4.0f : 1.0f) << place;
      dark += is_dark && !is_rim;
      rim += is_dark && is_rim;
    }
    EXPECT_GT(dark, 0);
    EXPECT_GT(rim, 0);
  }
}

TEST(DecodeFunction, WeighsLitPointsByWhatTheBlendHasThere) {
  const LossOptions loss{.dark_weight = 16.0, .blend_floor = 0.25};
  for (const Representation& representation : {Representation::tentMlp(), Representation::productField(5)}) {
    const PointOrder& order = pointOrder(representation);
    const StoredSample sample = crowdedSample(5);
    const WeightingFunction weighed = decoded(sample.view(), order, loss);
    int below_floor = 0, alone = 0;
    for (int place = 0; place < order.placeCount(); ++place) {
      const int p = order.pattern_index[place];
      if (p < 0 || !sample.valid(p) || sample.phi[p] == 0) continue;
      // a quotient of floats: two roundings
      const double sum = sample.blend_sum[p] / 255.0, root = 1.0 / std::max(sum, 0.25);
      EXPECT_NEAR(weighed.mask[place], root, 4 * kFloatRounding * root) << int{sample.blend_sum[p]};
      below_floor += sum < 0.25;
      alone += sum > 0.25 && sum < 1.0;
    }
    EXPECT_GT(below_floor, 0);
    EXPECT_GT(alone, 0);
  }
}

TEST(TentFunction, IsTheTentAndValidEverywhere) {
  const WeightingFunction function = tentFunction();
  EXPECT_EQ(function.validCount(), kSupportPointCount);
  EXPECT_EQ(function.phi, stratifiedSupportPoints().tent);
  for (const float mask : function.mask) ASSERT_EQ(mask, 1.0f);
}

}  // namespace
}  // namespace nlg
