
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

}  // namespace
}  // namespace nlg
