#include "runtime_eval/evaluator/theta_form.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/sample_dictionary.h"

namespace nlg {
namespace {

Theta randomThetaOf(const Representation& representation, double size, uint64_t seed) {
  Random random(seed);
  Theta theta;
  for (int d = 0; d < representation.thetaCount(); ++d) theta.push_back(static_cast<float>(size * random.normal()));
  return theta;
}

// Every unit is multiplied and divided by the same number: without rounding the network would be what it was. Rounding moves each
// number of a unit by at most 1/254 of its largest.
TEST(RoundHiddenLayers, LeavesTheNetworkWhatItIsButForHalfAStep) {
  for (const Representation& representation : sampleRepresentations()) {
    if (!representation.isNetwork()) continue;
    const NetworkShape& shape = representation.shape();
    const Theta theta = randomThetaOf(representation, 1.0, 7);
    Theta rounded = theta;
    roundHiddenLayers(representation, rounded.data());
    const float step = stepOf(shape);
    for (int u = 0; u < shape.first; ++u) {
      // the scale of unit u, from a number of its own that rounding keeps: the largest
      float before = std::fabs(theta[shape.b1() + u]), after = std::fabs(rounded[shape.b1() + u]);
      for (int i = 0; i < 3; ++i) {
        before = std::max(before, std::fabs(theta[3 * u + i]));
        after = std::max(after, std::fabs(rounded[3 * u + i]));
      }
      EXPECT_EQ(after, 127 * step) << representationName(representation) << ", unit " << u;
      for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(rounded[3 * u + i], step * std::nearbyint(rounded[3 * u + i] / step));
        EXPECT_NEAR(rounded[3 * u + i] * before / after, theta[3 * u + i], before / 254 * 1.0001f);
      }
    }
    Theta again = rounded;
    roundHiddenLayers(representation, again.data());
    EXPECT_EQ(again, rounded) << representationName(representation);
  }
}

// Numbers that are whole steps already are not moved, whatever their unit's scale: the network is the same to rounding of floats.
TEST(RoundHiddenLayers, ScalesUnitsWithoutChangingTheNetwork) {
  for (const Representation& representation : sampleRepresentations()) {
    if (!representation.isNetwork()) continue;
    Theta theta = randomThetaOf(representation, 1.0, 3);
    roundHiddenLayers(representation, theta.data());
    const NetworkShape& shape = representation.shape();
    Theta scaled = theta;
    // units 0 of the first layer times 8, 1 times 1/4: exact in float
    for (const auto& [unit, factor] : {std::pair{0, 8.0f}, {1, 0.25f}}) {
      for (int i = 0; i < 3; ++i) scaled[3 * unit + i] *= factor;
      scaled[shape.b1() + unit] *= factor;
      if (shape.second > 0) {
        for (int j = 0; j < shape.second; ++j) scaled[shape.w2() + j * shape.first + unit] /= factor;
      } else {
        scaled[shape.w3() + unit] /= factor;
      }
    }
    roundHiddenLayers(representation, scaled.data());
    for (int d = 0; d < representation.thetaCount(); ++d) {
      EXPECT_NEAR(scaled[d], theta[d], 1e-5f * std::fabs(theta[d])) << representationName(representation) << ", " << d;
    }
  }
}

TEST(RoundTheta, IsWhatAFileGivesBack) {
  for (const Representation& representation : sampleRepresentations()) {
    PackedTheta packed;
    std::vector<Theta> rounded;
    size_t bytes = 0;
    for (uint64_t seed = 0; seed < 5; ++seed) {
      // codes of every length and of several steps
      rounded.push_back(
          randomThetaOf(representation, (representation.isCode() ? 60.0 : 0.3) * static_cast<double>(seed + 1), seed));
      if (representation.isCode())
        std::fill(rounded.back().begin() + static_cast<ptrdiff_t>(3 * seed), rounded.back().end(), 0.0f);
      ASSERT_TRUE(roundTheta(representation, ThetaPrecision::int8, rounded.back().data()));
      packTheta(representation, rounded.back().data(), &packed);
      bytes += storedThetaBytes(representation, ThetaPrecision::int8, rounded.back().data());
    }
    ASSERT_EQ(packed.steps.size() + 2 * packed.halves.size() + packed.groups.size(), bytes);
    const ThetaForm form = thetaForm(representation, ThetaPrecision::int8);
    size_t step = 0;
    for (size_t n = 0; n < rounded.size(); ++n) {
      Theta read(representation.thetaCount());
      if (representation.isCode()) {
        ASSERT_TRUE(unpackCode(representation.code_count, packed.groups[n], packed.steps.data() + step, read.data()));
        step += static_cast<size_t>(codeLength(representation.code_count, rounded[n].data()));
      } else {
        unpackTheta(representation, packed.steps.data() + n * form.steps, packed.halves.data() + n * form.halves, read.data());
      }
      EXPECT_EQ(read, rounded[n]) << representationName(representation) << ", " << n;
    }
  }
}

TEST(RoundTheta, RefusesWhatFloat16CannotHoldAndLeavesIt) {
  for (const ThetaPrecision precision : {ThetaPrecision::float16, ThetaPrecision::int8}) {
    Theta theta = randomThetaOf(Representation::tentMlp(), 1.0, 2);
    theta[ThetaLayout::b3] = 1e5f;
    const Theta before = theta;
    EXPECT_FALSE(roundTheta(Representation::tentMlp(), precision, theta.data())) << thetaPrecisionName(precision);
    EXPECT_EQ(theta, before);
  }
}

TEST(RoundTheta, RoundsACodeToBytesOfTheLeastStepThatHoldsIt) {
  const Representation code = Representation::code(sampleDictionary(3, 16, 1));
  for (const auto& [largest, step] : {std::pair{127.0f, 1.0f},
                                      {127.4f, 2.0f},
                                      {254.0f, 2.0f},
                                      {255.0f, 4.0f},
                                      {-3000.0f, 32.0f},
                                      {16256.0f, 128.0f},
                                      {1e6f, 128.0f}}) {
    Theta theta = randomThetaOf(code, 20.0, 3);
    theta[3] = largest;
    const Theta before = theta;
    ASSERT_TRUE(roundTheta(code, ThetaPrecision::int8, theta.data()));
    EXPECT_EQ(theta[3], std::clamp(step * std::nearbyint(largest / step), -127.0f * step, 127.0f * step)) << largest;
    for (size_t k = 0; k < theta.size(); ++k) {
      if (k != 3) {
        EXPECT_EQ(theta[k], step * std::nearbyint(before[k] / step)) << largest << ", " << k;
      }
    }
    const Theta once = theta;
    ASSERT_TRUE(roundTheta(code, ThetaPrecision::int8, theta.data()));
    EXPECT_EQ(theta, once) << largest;
    EXPECT_EQ(std::ldexp(1.0f, codeExponent(16, theta.data())), step) << largest;
  }
}

// Of small networks: a last layer is rounded to the nearest of four bits behind the highest, and never beyond what a half holds.
TEST(RoundTheta, KeepsOfALastLayerTheBitsThatAreFelt) {
  for (const RepresentationKind kind : {RepresentationKind::tent_mlp4, RepresentationKind::tent_mlp44}) {
    const Representation network{kind};
    Theta theta = randomThetaOf(network, 1.0, 3);
    const auto first = static_cast<size_t>(network.shape().w3());
    theta.back() = kMaxHalf;
    Theta rounded = theta;
    scaleHiddenLayers(network, theta.data());
    ASSERT_TRUE(roundTheta(network, ThetaPrecision::int8, rounded.data()));
    for (size_t d = first; d < theta.size(); ++d) {
      int exponent = 0;
      const float mantissa = std::frexp(rounded[d], &exponent);  // .5 to 1: the highest bit and four
      EXPECT_EQ(std::ldexp(mantissa, 5), std::nearbyint(std::ldexp(mantissa, 5))) << d;
      if (d + 1 < theta.size()) {
        EXPECT_NEAR(rounded[d], theta[d], std::fabs(theta[d]) / 32 + 1e-6f) << d;
      }
    }
    EXPECT_EQ(rounded.back(), 31 * 2048.0f);
    Theta again = rounded;
    ASSERT_TRUE(roundTheta(network, ThetaPrecision::int8, again.data()));
    EXPECT_EQ(again, rounded);
  }
}

}  // namespace
}  // namespace nlg
