#include "datagen/dataset/function_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace nlg {
namespace {

constexpr size_t kKnownPoints = 512, kOctant = kKnownPoints / 8;
constexpr DuplicateRule kRule{0.5, 4};

struct Function {
  std::vector<uint8_t> phi = std::vector<uint8_t>(kKnownPoints), validity = std::vector<uint8_t>(kKnownPoints / 8, 0xff);
  StoredFunction samples() const { return {phi.data(), validity.data()}; }
};

// No two octants alike, some points in solid.
Function randomFunction(std::mt19937& random) {
  Function function;
  for (size_t i = 0; i < kKnownPoints; ++i) function.phi[i] = static_cast<uint8_t>(20 * (i / kOctant) + random() % 60);
  for (int n = 0; n < 20; ++n) {
    const size_t point = random() % kKnownPoints;
    function.phi[point] = 0;
    function.validity[point / 8] = static_cast<uint8_t>(function.validity[point / 8] & ~(1u << point % 8));
  }
  return function;
}

// By the definition, point after point.
Function mirrorImage(const Function& function, size_t mirror) {
  Function image;
  for (size_t m = 0; m < 8; ++m) {
    for (size_t i = 0; i < kOctant; ++i) {
      const size_t to = m * kOctant + i, from = (m ^ mirror) * kOctant + i;
      image.phi[to] = function.phi[from];
      if ((function.validity[from / 8] >> from % 8 & 1) == 0)
        image.validity[to / 8] = static_cast<uint8_t>(image.validity[to / 8] & ~(1u << to % 8));
    }
  }
  return image;
}

// The RMS difference over valid points becomes `step` in the whole, since that many valid samples change by `amount`.
Function changed(Function function, double rms, int amount) {
  size_t valid = 0;
  for (const uint8_t bits : function.validity) valid += static_cast<size_t>(__builtin_popcount(bits));
  auto count = static_cast<size_t>(rms * rms * static_cast<double>(valid) / (amount * amount));
  for (size_t i = 0; i < kKnownPoints && count > 0; ++i) {
    if ((function.validity[i / 8] >> i % 8 & 1) == 0) continue;
    function.phi[i] = static_cast<uint8_t>(function.phi[i] + amount);
    --count;
  }
  return function;
}

FunctionSet setOf(const std::vector<Function>& functions) {
  FunctionSet set;
  set.point_count = static_cast<int>(kKnownPoints);
  for (const Function& function : functions) {
    set.phi.insert(set.phi.end(), function.phi.begin(), function.phi.end());
    set.validity.insert(set.validity.end(), function.validity.begin(), function.validity.end());
    set.scene_idx.push_back(0);
  }
  return set;
}

class KnownFunctionsTest : public testing::Test {
 protected:
  KnownFunctionsTest() {
    for (int n = 0; n < 40; ++n) held_out_.push_back(randomFunction(random_));
  }
  KnownFunctions known(const std::vector<Function>& training) const {
    const FunctionSet set = setOf(held_out_);
    KnownFunctionSearch search(kRule, set);
    for (const Function& function : training) search.see(function.samples());
    return search.known();
  }

  std::mt19937 random_{11};
  std::vector<Function> held_out_;
};

TEST_F(KnownFunctionsTest, HoldNothingThatTrainingLacks) {
  std::vector<Function> training;
  for (int n = 0; n < 200; ++n) training.push_back(randomFunction(random_));
  // just outside the rule: too far in phi, or too many points of other validity
  training.push_back(changed(held_out_[3], 0.55, 1));
  Function other_solid = held_out_[4];
  for (size_t byte = 8; byte < 16; ++byte) {
    other_solid.validity[byte] = 0;
    std::fill_n(other_solid.phi.begin() + static_cast<ptrdiff_t>(8 * byte), 8, uint8_t{0});
  }
  training.push_back(other_solid);
  const KnownFunctions found = known(training);
  EXPECT_EQ(found.in_training.size(), held_out_.size());
  EXPECT_EQ(found.countInTraining(), 0u);
  EXPECT_EQ(found.countInTrainingMirrored(), 0u);
}

TEST_F(KnownFunctionsTest, TellAFunctionFromItsMirrorImages) {
  std::vector<Function> training = {held_out_[2]};
  for (size_t mirror = 1; mirror < 8; ++mirror) training.push_back(mirrorImage(held_out_[10 + mirror], mirror));
  const KnownFunctions found = known(training);
  for (size_t n = 0; n < held_out_.size(); ++n) {
    EXPECT_EQ(found.in_training[n], n == 2) << n;
    EXPECT_EQ(found.in_training_mirrored[n], n == 2 || (n > 10 && n < 18)) << n;
  }
  EXPECT_EQ(found.countInTraining(), 1u);
  EXPECT_EQ(found.countInTrainingMirrored(), 8u);
}

TEST_F(KnownFunctionsTest, AllowWhatTheRuleAllows) {
  const KnownFunctions found = known({changed(held_out_[0], 0.45, 1), mirrorImage(changed(held_out_[1], 0.45, 1), 5)});
  EXPECT_TRUE(found.in_training[0]);
  EXPECT_FALSE(found.in_training[1]);
  EXPECT_TRUE(found.in_training_mirrored[1]);
}

}  // namespace
}  // namespace nlg
