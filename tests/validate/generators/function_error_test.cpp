#include "validate/generators/measured_word.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace nlg {
namespace {

constexpr int kTestPoints = 64;

using Bits = std::function<bool(int)>;

void appendBits(int count, const Bits& at, std::vector<uint8_t>& bytes) {
  for (int i = 0; i < count; i += 8) {
    uint8_t byte = 0;
    for (int b = 0; b < 8; ++b) byte = static_cast<uint8_t>(byte | (at(i + b) ? 1 << b : 0));
    bytes.push_back(byte);
  }
}

// Appends a function that is `phi` at its support points and `phi_test` elsewhere.
void append(FunctionSet& set, const std::function<uint8_t(int)>& phi, const Bits& valid, const Bits& seen, uint8_t phi_test) {
  set.point_count = kSupportPointCount;
  set.test_point_count = kTestPoints;
  set.scene_idx.push_back(0);
  for (int p = 0; p < kSupportPointCount; ++p) set.phi.push_back(valid(p) ? phi(p) : 0);
  appendBits(kSupportPointCount, valid, set.validity);
  appendBits(kSupportPointCount, seen, set.seen);
  set.phi_test.insert(set.phi_test.end(), kTestPoints, phi_test);
  appendBits(
      kTestPoints, [](int i) { return i % 2 == 0; }, set.validity_test);
  appendBits(
      kTestPoints, [](int) { return true; }, set.seen_test);
}

const Bits kAlways = [](int) { return true; }, kNever = [](int) { return false; };

// A network whose output is the constant `value` everywhere.
std::vector<float> constantTheta(float value) {
  std::vector<float> theta(ThetaLayout::count, 0.0f);
  theta[ThetaLayout::b3] = value;
  return theta;
}

TEST(ErrorMeter, MeasuresAConstantInClosedForm) {
  // phi: 51/255 = 0.2 at every fourth point, 0 elsewhere; the network says 0.5
  FunctionSet set;
  append(
      set, [](int p) { return p % 4 == 0 ? 51 : 0; }, kAlways, [](int p) { return p % 4 == 0; }, 102);
  ErrorMeter meter(set, kUnweighed);
  const FunctionError error = meter.measure({}, constantTheta(0.5f).data(), 0);
  EXPECT_NEAR(error.rmse, std::sqrt(0.25 * 0.3 * 0.3 + 0.75 * 0.25), 1e-12);
  EXPECT_TRUE(error.has_occluded);
  EXPECT_NEAR(error.rmse_occluded, 0.5, 1e-12);
  EXPECT_NEAR(error.rmse_test_points, 0.1, 1e-12);
  EXPECT_EQ(error.leak_mean, 0.5);
  EXPECT_EQ(error.leak_p99, 0.5);
  EXPECT_EQ(meter.leakMagnitudes(), std::vector<double>(3 * kSupportPointCount / 4, 0.5));
}

TEST(ErrorMeter, WeighsLitPointsByTheBlendAndDarkOnesByTheirWeight) {
  // of four points one is 51/255 = 0.2, the next as well but seen by few others; two are dark. The network says 0.5
  FunctionSet set;
  append(
      set, [](int p) { return p % 4 < 2 ? 51 : 0; }, kAlways, [](int p) { return p % 4 < 2; }, 102);
  const LossOptions loss{.dark_weight = 16, .blend_floor = 0.2};
  const auto square = [&](double rmse) { return rmse * rmse * kSupportPointCount; };
  // dark points outside the tent weigh 1: nothing leaks there that the tent lets through
  int dark = 0, rim = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (p % 4 >= 2) (tent(supportPattern().points[static_cast<size_t>(p)]) > kRimTent ? dark : rim) += 1;
  }
  const double lit = kSupportPointCount / 4, zeros = 0.25 * (16.0 * dark + rim);
  const double without = ErrorMeter(set, loss).measure({}, constantTheta(0.5f).data(), 0).blend_rmse;
  EXPECT_NEAR(square(without), 2 * lit * 0.09 + zeros, 1e-6 * zeros) << "where no sum is known it is 1";
  for (int p = 0; p < kSupportPointCount; ++p) set.blend_sum.push_back(p % 4 == 0 ? 102 : p % 4 == 1 ? 10 : 255);
  const FunctionError error = ErrorMeter(set, loss).measure({}, constantTheta(0.5f).data(), 0);
  // sums of 0.4, and of less than the floor
  EXPECT_NEAR(square(error.blend_rmse), lit * 0.09 / 0.16 + lit * 0.09 / 0.04 + zeros, 1e-6 * zeros);
  EXPECT_NEAR(error.rmse, std::sqrt(0.5 * 0.09 + 0.5 * 0.25), 1e-12) << "all points alike";
  // the bake's check says the same, in float
  const FunctionCheck check = FunctionChecker().check({}, storedFunction(set, 0), constantTheta(0.5f).data(),
                                                      {.dark_weight = loss.dark_weight, .blend_floor = loss.blend_floor});
  EXPECT_NEAR(check.blend_rmse, error.blend_rmse, 1e-5);
}

TEST(ErrorMeter, LeavesInvalidPointsOut) {
  FunctionSet set;
  append(
      set, [](int) { return 255; }, [](int p) { return p % 8 == 3; }, kAlways, 255);
  ErrorMeter meter(set, kUnweighed);
  const FunctionError error = meter.measure({}, constantTheta(1.0f).data(), 0);
  EXPECT_EQ(error.rmse, 0.0);
  EXPECT_EQ(error.rmse_test_points, 0.0);
  EXPECT_FALSE(error.has_occluded);
  EXPECT_EQ(error.rmse_occluded, 0.0);
  EXPECT_EQ(error.leak_mean + error.leak_p99, 0.0) << "no valid point has phi 0";
  EXPECT_TRUE(meter.leakMagnitudes().empty());
}

TEST(ErrorMeter, CountsALeakOfEitherSign) {
  FunctionSet set;
  append(
      set, [](int) { return 0; }, kAlways, kNever, 0);
  ErrorMeter meter(set, kUnweighed);
  EXPECT_EQ(meter.measure({}, constantTheta(-0.25f).data(), 0).leak_mean, 0.25);
}

TEST(ErrorMeter, CountsNoLeakWhereTheProbeSees) {
  // phi is 0 everywhere; the probe sees every fourth point, as it does at the rim of the tent
  FunctionSet set;
  append(
      set, [](int) { return 0; }, kAlways, [](int p) { return p % 4 == 0; }, 0);
  ErrorMeter meter(set, kUnweighed);
  EXPECT_EQ(meter.measure({}, constantTheta(0.5f).data(), 0).leak_mean, 0.5);
  EXPECT_EQ(meter.leakMagnitudes().size(), 3u * kSupportPointCount / 4);
  append(
      set, [](int) { return 0; }, kAlways, kAlways, 0);
  const FunctionError all_seen = meter.measure({}, constantTheta(0.5f).data(), 1);
  EXPECT_EQ(all_seen.rmse, 0.5);
  EXPECT_EQ(all_seen.leak_mean, 0.0);
  EXPECT_EQ(all_seen.leak_p99, 0.0);
  EXPECT_TRUE(meter.leakMagnitudes().empty());
}

}  // namespace
}  // namespace nlg
