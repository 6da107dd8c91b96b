#include "runtime_eval/numbers/flush_subnormals.h"

#include <limits>

#include <gtest/gtest.h>

namespace nlg {
namespace {

// Out of the compiler's sight, so that it is the processor that multiplies.
float product(float a, float b) {
  const volatile float first = a, second = b;
  return first * second;
}

constexpr float kSmallest = std::numeric_limits<float>::min(), kSubnormal = std::numeric_limits<float>::denorm_min();

#if defined(__SSE__) || defined(__aarch64__)
TEST(FlushSubnormals, TakesThemForNothingAndLeavesAllAsItWas) {
  ASSERT_GT(product(kSmallest, 0.5f), 0.0f);
  {
    const FlushSubnormals flush;
    EXPECT_EQ(product(kSmallest, 0.5f), 0.0f) << "a result";
    EXPECT_EQ(product(kSubnormal, 1e38f), 0.0f) << "an operand";
    EXPECT_EQ(product(kSmallest, 1.0f), kSmallest) << "what is no smaller than a normal number stays";
    {
      const FlushSubnormals nested;
      EXPECT_EQ(product(kSmallest, 0.5f), 0.0f);
    }
    EXPECT_EQ(product(kSmallest, 0.5f), 0.0f) << "the outer one lives";
  }
  EXPECT_GT(product(kSmallest, 0.5f), 0.0f);
  EXPECT_GT(product(kSubnormal, 1e38f), 0.0f);
}
#endif

}  // namespace
}  // namespace nlg
