#include "runtime_eval/numbers/range_coder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

struct Coded {
  std::vector<uint32_t> numbers;
  std::vector<uint8_t> bytes;
};

// draw   a number of so many bits
template <class Draw>
Coded coded(int bits, size_t count, const Draw& draw) {
  Coded result;
  NumberModel model(bits);
  RangeEncoder encoder;
  for (size_t i = 0; i < count; ++i) {
    result.numbers.push_back(draw());
    encoder.add(result.numbers.back(), &model);
  }
  result.bytes = encoder.finish();
  return result;
}

void expectBack(int bits, const Coded& from) {
  NumberModel model(bits);
  RangeDecoder decoder(from.bytes.data(), from.bytes.size());
  for (size_t i = 0; i < from.numbers.size(); ++i) ASSERT_EQ(decoder.next(&model), from.numbers[i]) << i;
  EXPECT_TRUE(decoder.isAtEnd());
}

TEST(RangeCoder, GivesBackWhatItTook) {
  Random random(1);
  for (const int bits : {0, 1, 3, 8, 12, 16}) {
    for (const size_t count : {0u, 1u, 2u, 1000u, 30000u})
      expectBack(bits, coded(bits, count, [&] { return random.below(1u << bits); }));
  }
  // long runs, whose intervals end in carries that ripple
  for (const uint32_t often : {0u, 1u}) {
    for (const double share : {0.5, 0.999, 1.0})
      expectBack(1, coded(1, 200000, [&] { return random.uniform() < share ? often : 1 - often; }));
  }
}

TEST(RangeCoder, TakesHardlyMoreThanTheEntropy) {
  Random random(2);
  const size_t count = 50000;
  const auto geometric = [&] {
    return std::min<uint32_t>(255, static_cast<uint32_t>(std::log(random.uniform() + 1e-12) / std::log(0.8)));
  };
  const Coded small = coded(8, count, geometric);
  expectBack(8, small);
  // of a geometric distribution with p = .2: (-.8 log2 .8 - .2 log2 .2) / .2 bits
  const double entropy = (-0.8 * std::log2(0.8) - 0.2 * std::log2(0.2)) / 0.2;
  EXPECT_NEAR(8.0 * static_cast<double>(small.bytes.size()) / count, entropy, 0.03 * entropy);
  EXPECT_LE(coded(8, count, [&] { return random.below(256); }).bytes.size(), 1.03 * count);
  EXPECT_LE(coded(16, count, [] { return 4711u; }).bytes.size(), count / 20);
}

}  // namespace
}  // namespace nlg
