#include "runtime_eval/fit/code_fit.h"

#include <gtest/gtest.h>

#include <cstring>

#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/fit/loss/loss_kernel.h"
#include "runtime_eval/numbers/finite.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/fit/code_functions.h"

namespace nlg {
namespace {

constexpr double kDarkWeight = 64.0;

Representation sampleCodeOf(int resolution, int count, uint64_t seed) {
  return Representation::code(sampleDictionary(resolution, count, seed));
}

WeightingFunction functionOf(const Representation& code, const StoredSample& sample, double dark_weight = 1.0) {
  return decoded(sample.view(), pointOrder(code), {dark_weight, 1.0});
}

// Steps from a start, by a workspace of its own; the options' iterations bound them.
FitResult fitted(const Representation& code, const WeightingFunction& function, const Theta& start, const CodeFitOptions& options,
                 int count = 0) {
  CodeFit fit;
  Theta z = start;
  FitResult result = fit.iterate(code, function, options, count > 0 ? count : code.code_count, z.data());
  result.theta = z;
  return result;
}

// --- the loss -------------------------------------------------------------------------------------------------------------------

TEST(CodeLoss, EqualsTheFormulasInDoubleOnEveryTarget) {
  for (const int resolution : {3, 9}) {
    const SharedDictionary dictionary = sampleDictionary(resolution, 16, 1);
    const PointOrder& order = cellOrder(resolution);
    Random random(2);
    const Theta z = sampleCode(*dictionary, 16, random);
    const std::vector<double> exact = toDouble(z);
    const CodeAtPlaces at = atPlaces(*dictionary, order, exact);
    for (const StoredSample& sample : {wallSample(3), noiseSample(4)}) {
      WeightingFunction function = decoded(sample.view(), order);
      weigh(&function.mask);
      double sum = 0.0;
      std::vector<double> gradient(16, 0.0), magnitude(16, 0.0);
      for (int place = 0; place < order.placeCount(); ++place) {
        if (function.mask[place] == 0.0f) continue;
        const double weight = function.mask[place], tent = order.points.tent[place];
        const double value = evaluateCodeReference(*dictionary, placePosition(order, place), exact.data());
        const double residual = weight * (value - function.phi[place]);
        sum += residual * residual;
        for (int k = 0; k < 16; ++k) {
          const double slope = tent > 0.0 ? value * (1.0 - value / tent) : 0.0;
          gradient[k] += 2.0 * weight * residual * slope * at.rows[place][k];
          magnitude[k] += std::fabs(2.0 * weight * slope * at.rows[place][k]);
        }
      }
      forEachTarget([&] {
        float by_z[16];
        // values are off by some 100 roundings of logits of up to 32; a sum of a cell has at most 1024 more
        const double relative = 4096 * kFloatRounding;
        EXPECT_NEAR(codeLossAndGradient(*dictionary, function.phi.data(), function.mask.data(), z.data(), by_z), sum,
                    relative * sum);
        EXPECT_NEAR(codeLoss(*dictionary, function.phi.data(), function.mask.data(), z.data()), sum, relative * sum);
        for (int k = 0; k < 16; ++k) EXPECT_NEAR(by_z[k], gradient[k], relative * magnitude[k]) << k;
      });
    }
  }
}

// --- the normal equations -------------------------------------------------------------------------------------------------------

// Points may be left out where their row is at most so many times b: what the header calls those that the sigmoid still moves.
constexpr double kLeftOutSlope = 0.02;

TEST(CodeEquations, AreThoseOfFiniteDifferencesButForPointsThatTheSigmoidHasShut) {
  constexpr int kCount = 16;
  constexpr double kStep = 1e-4;
  const Representation code = sampleCodeOf(5, kCount, 7);
  const Dictionary& dictionary = *code.dictionary;
  const PointOrder& order = pointOrder(code);
  Random random(8);
  const Theta z = sampleCode(dictionary, kCount, random);
  const WeightingFunction function = functionOf(code, wallSample(9), kDarkWeight);
  const CodeAtPlaces at = atPlaces(dictionary, order, toDouble(z));
  std::vector<double> whole(kCount * kCount, 0.0);  // J^T J of all points
  double left_out = 0.0;                            // the trace of what may be missing of it
  for (int place = 0; place < order.placeCount(); ++place) {
    const double weight = function.mask[place], tent = order.points.tent[place];
    double slope[kCount];
    const auto valueAt = [&](double logit) { return weight * tent / (1.0 + std::exp(-logit)); };
    for (int k = 0; k < kCount; ++k) {
      const double b = at.rows[place][k];
      slope[k] = (valueAt(at.logits[place] + kStep * b) - valueAt(at.logits[place] - kStep * b)) / (2 * kStep);
      if (weight > 0.0) left_out += kLeftOutSlope * kLeftOutSlope * b * b;
    }
    for (int i = 0; i < kCount; ++i) {
      for (int k = 0; k < kCount; ++k) whole[i * kCount + k] += slope[i] * slope[k];
    }
  }
  double trace = 0.0;
  for (int k = 0; k < kCount; ++k) trace += whole[k * (kCount + 1)];
  ASSERT_LT(left_out, 0.2 * trace) << "the bound says something";
  forEachTarget([&] {
    CodeFit fit;
    CodeEquations equations;
    fit.equationsAt(code, function, {}, z.data(), &equations);
    ASSERT_EQ(equations.count, kCount);
    CodeFitOptions without_prior;
    without_prior.prior = 0.0;
    CodeEquations bare;
    fit.equationsAt(code, function, without_prior, z.data(), &bare);
    double missing = 0.0;
    for (int i = 0; i < kCount; ++i) {
      // a row left out is missing on the diagonal, and never adds to it
      EXPECT_LE(bare.matrix[i * (kCount + 1)], whole[i * (kCount + 1)] * (1 + 1e-4)) << i;
      missing += whole[i * (kCount + 1)] - bare.matrix[i * (kCount + 1)];
      for (int k = 0; k < kCount; ++k) {
        EXPECT_EQ(equations.matrix[i * kCount + k], equations.matrix[k * kCount + i]) << i << ", " << k;
        const double prior =
            i == k ? CodeFitOptions{}.prior / (double{dictionary.deviations()[k]} * dictionary.deviations()[k]) : 0.0;
        EXPECT_NEAR(equations.matrix[i * kCount + k], bare.matrix[i * kCount + k] + prior, 1e-6 * whole[i * (kCount + 1)])
            << i << ", " << k;
        EXPECT_NEAR(bare.matrix[i * kCount + k], whole[i * kCount + k], left_out + 1e-4 * trace) << i << ", " << k;
      }
    }
    EXPECT_LE(missing, left_out + 1e-4 * trace);
  });
}

// --- fits -----------------------------------------------------------------------------------------------------------------------

TEST(CodeFit, NeverEndsAboveItsStart) {
  for (const int count : {8, 48}) {
    const Representation code = sampleCodeOf(5, count, 10);
    for (uint64_t seed = 0; seed < 12; ++seed) {
      const StoredSample sample = seed % 3 == 0 ? noiseSample(seed) : wallSample(seed);
      for (const double dark_weight : {1.0, kDarkWeight}) {
        const WeightingFunction function = functionOf(code, sample, dark_weight);
        for (const float size : {0.0f, 1.0f, 30.0f, 1e4f, 1e-42f}) {
          Theta start = randomTheta(code, seed);
          for (float& number : start) number *= size;
          for (const CodeFitOptions& options :
               {CodeFitOptions{}, CodeFitOptions{.iterations = 2}, CodeFitOptions{.is_ramped = false}}) {
            const std::string what = "seed " + std::to_string(seed) + ", size " + std::to_string(size) + ", dark " +
                                     std::to_string(dark_weight) + (options.is_ramped ? "" : ", not ramped");
            const FitResult result = fitted(code, function, start, options);
            EXPECT_TRUE(allFinite(result.theta)) << what;
            EXPECT_LE(result.rmse, functionRmse(code, function, start.data())) << what;
            EXPECT_EQ(result.rmse, functionRmse(code, function, result.theta.data())) << what;
            EXPECT_LE(result.steps, options.iterations) << what;
          }
        }
      }
    }
  }
}

TEST(CodeFit, ReturnsTheStartWhenNumbersAreNotFinite) {
  const Representation code = sampleCodeOf(5, 16, 11);
  const WeightingFunction function = functionOf(code, wallSample(6));
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    for (const int place : {0, 7, 15}) {
      Theta start = randomTheta(code, 6);
      start[static_cast<size_t>(place)] = bad;
      const FitResult result = fitted(code, function, start, {});
      EXPECT_EQ(result.stop, FitStop::not_finite) << bad << " at " << place;
      EXPECT_TRUE(sameBits(result.theta, start)) << bad << " at " << place;
      EXPECT_EQ(result.steps, 0);
    }
  }
  WeightingFunction broken = function;
  for (size_t i = 0; i < broken.phi.size(); ++i) {
    if (broken.mask[i] != 0.0f) broken.phi[i] = NAN;
  }
  const Theta start = randomTheta(code, 6);
  const FitResult result = fitted(code, broken, start, {});
  EXPECT_EQ(result.stop, FitStop::not_finite);
  EXPECT_TRUE(sameBits(result.theta, start));
}

// The code that made a function is a place where the cost is its bytes' rounding and the prior's share. The fit ends no higher, but for the
// rounding of its logits to a brick: half a step times the tent times a slope of 1/4.
TEST(CodeFit, FindsWhatItsOwnDictionaryMade) {
  const Representation code = sampleCodeOf(9, 32, 15);
  const WeightingFunction bare = tentFunction(pointOrder(code));
  double tent_square = 0.0;
  for (size_t i = 0; i < bare.phi.size(); ++i)
    tent_square += double{bare.mask[i]} * bare.phi[i] * bare.phi[i] / kSupportPointCount;
  for (uint64_t seed = 1; seed < 9; ++seed) {
    Random random(seed);
    const Theta made = sampleCode(*code.dictionary, 32, random);
    const StoredSample sample = codeSample(code.dictionary, made);
    const WeightingFunction function = functionOf(code, sample);
    std::vector<int8_t> brick(9 * 9 * 9);
    const double step = packBrick(*code.dictionary, made.data(), brick.data());
    double over = 0.0;
    for (int k = 0; k < 32; ++k) over += std::pow(made[k] / code.dictionary->deviations()[k], 2);
    const double bytes = functionRmse(code, function, made.data()), rounding = step / 2 / 4;
    const double bound =
        std::sqrt(bytes * bytes + 2 * rounding * rounding * tent_square + CodeFitOptions{}.prior * over / kSupportPointCount);
    for (const Theta& start : {Theta(32, 0.0f), randomTheta(code, seed + 50)}) {
      EXPECT_LT(fitted(code, function, start, {.iterations = 40, .progress_tolerance = 1e-6}).rmse, bound) << "seed " << seed;
    }
  }
}

TEST(CodeFit, OfAPrefixIsThatOfADictionaryOfItsNumbers) {
  const DictionaryData whole = sampleDictionaryData(5, 48, 17);
  const Representation code = Representation::code(std::make_shared<const Dictionary>(whole));
  for (const int length : {8, 16, 24, 40}) {
    DictionaryData cut = whole;
    cut.code_count = length;
    cut.nodes.erase(cut.nodes.begin() + length * 125, cut.nodes.begin() + 48 * 125);
    cut.exponents.erase(cut.exponents.begin() + length, cut.exponents.begin() + 48);
    cut.deviations.resize(static_cast<size_t>(length));
    ASSERT_EQ(whatIsWrong(cut), "");
    const Representation shorter = Representation::code(std::make_shared<const Dictionary>(cut));
    const WeightingFunction function = functionOf(code, wallSample(18), kDarkWeight);
    Theta start = randomTheta(code, 19);
    const FitResult prefix = fitted(code, function, start, {}, length);
    for (size_t k = static_cast<size_t>(length); k < 48; ++k) EXPECT_EQ(prefix.theta[k], 0.0f) << k;
    start.resize(static_cast<size_t>(length));
    const FitResult alone = fitted(shorter, function, start, {});
    EXPECT_EQ(prefix.rmse, alone.rmse) << length;
    EXPECT_EQ(prefix.steps, alone.steps) << length;
    EXPECT_TRUE(std::equal(alone.theta.begin(), alone.theta.end(), prefix.theta.begin())) << length;
  }
}

TEST(CodeFit, ComesAsLowOnEveryTarget) {
  const Representation code = sampleCodeOf(9, 48, 20);
  const WeightingFunction function = functionOf(code, wallSample(21), kDarkWeight);
  const Theta start(48, 0.0f);
  const double best = fitted(code, function, start, {.iterations = 60, .progress_tolerance = 1e-6}).rmse;
  // sums in another order: a step that is refused on one target may be taken on another, but both go on until two steps pay less than 1e-6
  forEachTarget([&] {
    EXPECT_NEAR(fitted(code, function, start, {.iterations = 60, .progress_tolerance = 1e-6}).rmse, best, 0.01 * best);
  });
}

// A bake keeps one workspace a thread: what it holds of the function before must not reach the next one.
TEST(CodeFit, GivesTheSameBitsFromAUsedWorkspace) {
  const Representation code = sampleCodeOf(5, 32, 22), larger = sampleCodeOf(9, 48, 23);
  const WeightingFunction function = functionOf(code, wallSample(24), kDarkWeight);
  const FitResult fresh = fitted(code, function, randomTheta(code, 25), {});
  CodeFit used;
  for (const Representation& other : {larger, code}) {
    Theta before = randomTheta(other, 26);
    used.iterate(other, functionOf(other, noiseSample(27)), {}, other.code_count, before.data());
    used.iterate(other, functionOf(other, noiseSample(28)), {}, 8, before.data());
    Theta z = randomTheta(code, 25);
    EXPECT_EQ(used.iterate(code, function, {}, 32, z.data()).rmse, fresh.rmse);
    EXPECT_TRUE(sameBits(z, fresh.theta));
  }
}

}  // namespace
}  // namespace nlg
