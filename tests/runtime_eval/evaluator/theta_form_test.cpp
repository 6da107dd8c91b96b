#include "runtime_eval/evaluator/theta_form.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/evaluator/evaluate_point.h"
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

TEST(ThetaForm, HoldsAllNumbersInTheBytesThatItSays) {
  for (const Representation& representation : sampleRepresentations()) {
    for (const ThetaPrecision precision : {ThetaPrecision::float32, ThetaPrecision::float16, ThetaPrecision::int8}) {
      const ThetaForm form = thetaForm(representation, precision);
      EXPECT_EQ(form.floats + form.halves + form.steps, representation.thetaCount());
    }
  }
  EXPECT_EQ(thetaForm(Representation::tentMlp(), ThetaPrecision::int8).bytes(), 104u + 9 * 2);
  EXPECT_EQ(thetaForm({RepresentationKind::tent_mlp4}, ThetaPrecision::int8).bytes(), 16u + 5 * 2);
  EXPECT_EQ(thetaForm(Representation::productField(3), ThetaPrecision::int8).bytes(), 54u * 2);
  EXPECT_EQ(thetaForm(Representation::code(sampleDictionary(3, 16, 1)), ThetaPrecision::int8).bytes(), 16u);
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

TEST(RoundHiddenLayers, LeavesUnitsOfNothingAndRoundsSmallestNumbersToNothing) {
  const Representation representation = Representation::tentMlp();
  Theta theta = randomThetaOf(representation, 1.0, 5);
  for (int i = 0; i < 3; ++i) theta[i] = 0.0f, theta[3 + i] = 1e-44f;
  theta[ThetaLayout::b1] = 0.0f;
  theta[ThetaLayout::b1 + 1] = -1e-44f;
  roundHiddenLayers(representation, theta.data());
  for (const float value : theta) EXPECT_TRUE(std::isfinite(value));
  for (int i = 0; i < 6; ++i) EXPECT_EQ(theta[i], 0.0f);
}

TEST(RoundTheta, IsWhatAFileGivesBack) {
  for (const Representation& representation : sampleRepresentations()) {
    PackedTheta packed;
    std::vector<Theta> rounded;
    for (uint64_t seed = 0; seed < 5; ++seed) {
      rounded.push_back(randomThetaOf(representation, 0.3 * static_cast<double>(seed + 1), seed));
      ASSERT_TRUE(roundTheta(representation, ThetaPrecision::int8, rounded.back().data()));
      packTheta(representation, rounded.back().data(), &packed);
    }
    const ThetaForm form = thetaForm(representation, ThetaPrecision::int8);
    ASSERT_EQ(packed.steps.size() + 2 * packed.halves.size(), rounded.size() * form.bytes());
    for (size_t n = 0; n < rounded.size(); ++n) {
      Theta read(representation.thetaCount());
      unpackTheta(representation, packed.steps.data() + n * form.steps, packed.halves.data() + n * form.halves, read.data());
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

TEST(RoundTheta, RoundsACodeToWholeNumbersOfAByte) {
  const Representation code = Representation::code(sampleDictionary(3, 16, 1));
  Theta theta = randomThetaOf(code, 40.0, 3);
  theta[0] = 1e6f;
  theta[1] = -127.6f;
  theta[2] = -0.4f;
  const Theta before = theta;
  ASSERT_TRUE(roundTheta(code, ThetaPrecision::int8, theta.data()));
  EXPECT_EQ(theta[0], 127.0f);
  EXPECT_EQ(theta[1], -127.0f);
  for (size_t k = 2; k < theta.size(); ++k) EXPECT_EQ(theta[k], std::nearbyint(before[k])) << k;
}

TEST(RoundTheta, RefusesACodeThatIsNotFiniteAndLeavesIt) {
  const Representation code = Representation::code(sampleDictionary(3, 16, 1));
  for (const ThetaPrecision precision : {ThetaPrecision::float16, ThetaPrecision::int8}) {
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      Theta theta(16, 0.4f);
      theta[9] = bad;
      EXPECT_FALSE(roundTheta(code, precision, theta.data())) << thetaPrecisionName(precision) << ", " << bad;
      EXPECT_EQ(theta[0], 0.4f);
    }
  }
}

TEST(CodeLength, IsOfWholeGroupsUpToTheLastNumberThatIsNot0) {
  Theta z(64, 0.0f);
  EXPECT_EQ(codeLength(64, z.data()), 0);
  for (int last = 0; last < 64; ++last) {
    z[last] = -1.0f;
    EXPECT_EQ(codeLength(64, z.data()), (last / 8 + 1) * 8) << last;
    // a 0 before it is no end
    if (last > 0) z[last - 1] = 0.0f;
    EXPECT_EQ(codeLength(64, z.data()), (last / 8 + 1) * 8) << last;
  }
}

}  // namespace
}  // namespace nlg
