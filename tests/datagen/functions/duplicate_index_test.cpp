#include "datagen/functions/duplicate_index.h"

#include <gtest/gtest.h>

#include <random>

namespace nlg {
namespace {

constexpr int kPoints = 1024;

struct Function {
  std::vector<uint8_t> phi, validity;
  StoredFunction samples() const { return {phi.data(), validity.data()}; }
};

Function smoothFunction(std::mt19937& random) {
  Function function{std::vector<uint8_t>(kPoints), std::vector<uint8_t>(kPoints / 8, 0xff)};
  const int slope = static_cast<int>(random() % 40), offset = static_cast<int>(random() % 60);
  for (int i = 0; i < kPoints; ++i) function.phi[static_cast<size_t>(i)] = static_cast<uint8_t>(offset + slope * i / kPoints);
  return function;
}

// Noise of up to `steps` in every sample, and some points that turn invalid.
Function disturbed(Function function, std::mt19937& random, int steps, int invalid) {
  for (uint8_t& sample : function.phi) {
    sample = static_cast<uint8_t>(std::clamp(int{sample} + static_cast<int>(random() % (2 * steps + 1)) - steps, 0, 255));
  }
  for (int i = 0; i < invalid; ++i) {
    const size_t point = random() % kPoints;
    function.phi[point] = 0;
    function.validity[point / 8] = static_cast<uint8_t>(function.validity[point / 8] & ~(1 << point % 8));
  }
  return function;
}

TEST(DuplicateRule, CountsWhatThePointsDifferBy) {
  Function a{std::vector<uint8_t>(16, 10), {0xff, 0xff}}, b = a;
  EXPECT_EQ(duplicateDistance({}, a.samples(), b.samples(), 16), 0.0);
  b.phi[3] = 14;  // 16 / 16
  EXPECT_EQ(duplicateDistance({}, a.samples(), b.samples(), 16), std::nullopt);
  EXPECT_EQ(duplicateDistance({0.99, 0}, a.samples(), b.samples(), 16), std::nullopt);
  EXPECT_EQ(duplicateDistance({1.0, 0}, a.samples(), b.samples(), 16), 1.0);
  EXPECT_EQ(duplicateDistance({1.0, 0}, b.samples(), a.samples(), 16), 1.0);
  // a point valid in one only: all of its value counts, over 15 points
  b = a;
  b.phi[0] = 0;
  b.validity[0] = 0xfe;
  EXPECT_EQ(duplicateDistance({9.0, 0}, a.samples(), b.samples(), 16), std::nullopt);
  EXPECT_EQ(duplicateDistance({9.0, 1}, a.samples(), b.samples(), 16), std::sqrt(100.0 / 15.0));
}

// Against brute force: the index may not miss a single one, near the limit least of all.
TEST(DuplicateIndex, MissesNothingThatBruteForceFinds) {
  for (const DuplicateRule& rule : {DuplicateRule{}, DuplicateRule{0.8, 0}, DuplicateRule{1.2, 4}, DuplicateRule{3.0, 20}}) {
    std::mt19937 random(7);
    std::vector<Function> kept;
    DuplicateIndex index(rule, kPoints, [&](uint64_t id) { return kept[id].samples(); });
    int duplicates = 0;
    std::vector<Function> originals;
    for (int n = 0; n < 2000; ++n) {
      Function function = n % 3 == 0 || originals.empty()
                              ? smoothFunction(random)
                              : disturbed(originals[random() % originals.size()], random, static_cast<int>(random() % 4),
                                          static_cast<int>(random() % 6));
      originals.push_back(function);
      const bool expected = std::any_of(kept.begin(), kept.end(), [&](const Function& other) {
        return duplicateDistance(rule, function.samples(), other.samples(), kPoints).has_value();
      });
      const auto match = index.findOrAdd(function.samples());
      ASSERT_EQ(match.has_value(), expected) << "function " << n << ", rms " << rule.rms;
      if (match) {
        ++duplicates;
        EXPECT_EQ(duplicateDistance(rule, function.samples(), kept[match->id].samples(), kPoints), match->rms_difference);
      } else {
        kept.push_back(function);
      }
    }
    EXPECT_EQ(index.functionCount(), kept.size());
    EXPECT_GT(duplicates, 20) << "rms " << rule.rms;
    EXPECT_GT(kept.size(), 100u) << "rms " << rule.rms;
    // looking at all pairs would be the brute force that it replaces
    EXPECT_LT(index.comparedCount(), 2000u * kept.size() / 4) << "rms " << rule.rms;
  }
}

}  // namespace
}  // namespace nlg
