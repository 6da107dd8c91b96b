#include "runtime_eval/fit/adam_update.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

TEST(AdamMoments, StepsByTheFormulaOnEveryTarget) {
  constexpr double kBeta1 = 0.8, kBeta2 = 0.99;
  forEachTarget([&] {
    // counts below, at and beside whole vectors
    for (const int count : {1, 7, 16, 113, 250}) {
      Random random(static_cast<uint64_t>(count));
      AdamMoments moments(count);
      std::vector<float> theta(count), gradient(count);
      for (float& value : theta) value = static_cast<float>(random.normal());
      std::vector<double> expected(theta.begin(), theta.end()), mean(count, 0.0), square(count, 0.0);
      for (int step = 1; step <= 20; ++step) {
        const double rate = 0.1 / step;
        for (float& value : gradient) value = static_cast<float>(random.normal() * std::pow(10.0, random.uniform(-4, 4)));
        moments.step(rate, kBeta1, kBeta2, 0.5f, gradient.data(), theta.data());
        for (int i = 0; i < count; ++i) {
          const double g = 0.5 * gradient[i];
          mean[i] = kBeta1 * mean[i] + (1 - kBeta1) * g;
          square[i] = kBeta2 * square[i] + (1 - kBeta2) * g * g;
          expected[i] -=
              rate * mean[i] / (1 - std::pow(kBeta1, step)) / (std::sqrt(square[i] / (1 - std::pow(kBeta2, step))) + 1e-8);
        }
      }
      // Rates add up to .36, and mean / root is at most (1 - .8) / sqrt(1 - .99) = 2 of them. A step is off by 20 roundings of its
      // terms, and by half of what 1 - .99f lost of six bits, 2^-18.4; theta, up to 4, is rounded at each of 20 steps.
      const double bound = 0.36 * 2 * (20 * kFloatRounding + 0.5 * 0x1p-18) + 20 * 4 * kFloatRounding;
      for (int i = 0; i < count; ++i) EXPECT_NEAR(theta[i], expected[i], bound) << count << " parameters, number " << i;
    }
  });
}

}  // namespace
}  // namespace nlg
