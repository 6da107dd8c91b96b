#include "nlg/simd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "runtime_eval/evaluator/generator/matrix_product.h"
#include "tests/runtime_eval/system_calls.h"

namespace nlg {
namespace {

// Goes back to the best target when a case ends, however it ends.
class SimdTarget : public testing::Test {
 protected:
  ~SimdTarget() override { forceSimdTarget(""); }
};

bool available(std::string_view name) {
  const std::vector<std::string_view> names = availableSimdTargets();
  return std::find(names.begin(), names.end(), name) != names.end();
}

TEST_F(SimdTarget, IsTheBestByItself) {
  ASSERT_FALSE(availableSimdTargets().empty());
  EXPECT_EQ(chosenSimdTarget(), availableSimdTargets().front());
}

TEST_F(SimdTarget, IsWhatWasForcedUntilTheBestIsAskedForAgain) {
  for (const std::string_view name : availableSimdTargets()) {
    EXPECT_EQ(forceSimdTarget(name), SimdStatus::ok);
    EXPECT_EQ(chosenSimdTarget(), name);
  }
  EXPECT_EQ(forceSimdTarget(""), SimdStatus::ok);
  EXPECT_EQ(chosenSimdTarget(), availableSimdTargets().front());
}

TEST_F(SimdTarget, ReachesTheKernels) {
  if (!available("avx2") && !available("neon")) GTEST_SKIP() << "every target here rounds alike";
  // (1 + e)² - (1 + 2e) is e² with a fused multiply-add, 0 where the product is rounded first
  const float e = 0x1p-12f, row = 1.0f + e, bias = -(1.0f + 2 * e);
  const PackedMatrix matrix(&row, 1, 1);
  const auto product = [&] {
    float result = 9.0f;
    multiply({&row, 1}, 1, matrix, &bias, Epilogue::none, 1.0f, &result, 1);
    return result;
  };
  EXPECT_EQ(product(), e * e);
  if (!available("sse4")) return;
  ASSERT_EQ(forceSimdTarget("sse4"), SimdStatus::ok);
  EXPECT_EQ(product(), 0.0f);
}

// The variable is read once a process: each case asks a process of its own, forked before any other test could read it. (Not started anew:
// an emulator of another processor could not.)
[[noreturn]] void exitWithStatus(const char* value, std::string_view expected_target) {
  setEnvironment("NLG_SIMD", value);
  const SimdStatus first = forceSimdTargetFromEnvironment();
  const bool obeyed = chosenSimdTarget() == expected_target;
  setEnvironment("NLG_SIMD", "scalar");
  const bool read_once = forceSimdTargetFromEnvironment() == first && chosenSimdTarget() == expected_target;
  std::_Exit(obeyed && read_once ? 10 + static_cast<int>(first) : 1);
}

int exitCode(SimdStatus status) { return 10 + static_cast<int>(status); }

TEST(SimdTargetDeathTest, ObeysTheEnvironmentOnce) {
  const std::string_view best = availableSimdTargets().front();
  EXPECT_EXIT(exitWithStatus("", best), testing::ExitedWithCode(exitCode(SimdStatus::ok)), "");
  for (const std::string_view name : availableSimdTargets()) {
    EXPECT_EXIT(exitWithStatus(name.data(), name), testing::ExitedWithCode(exitCode(SimdStatus::ok)), "") << name;
  }
}

TEST(SimdTargetDeathTest, RefusesWhatTheEnvironmentCannotHave) {
  const std::string_view best = availableSimdTargets().front();
  EXPECT_EXIT(exitWithStatus("avx9", best), testing::ExitedWithCode(exitCode(SimdStatus::unknown_name)), "");
  const char* foreign = available("neon") ? "sse4" : "neon";
  EXPECT_EXIT(exitWithStatus(foreign, best), testing::ExitedWithCode(exitCode(SimdStatus::unavailable)), "");
}

}  // namespace
}  // namespace nlg
