#include "datagen/probes/shuffled_order.h"

#include <gtest/gtest.h>

#include <vector>

namespace nlg {
namespace {

TEST(ShuffledOrder, VisitsEverythingOnce) {
  for (const uint64_t count : {0u, 1u, 2u, 3u, 7u, 8u, 9u, 1000u, 1024u, 1025u, 65537u}) {
    ShuffledOrder order(count, 5);
    std::vector<bool> visited(count, false);
    uint64_t index = 0, visits = 0;
    for (; order.next(&index); ++visits) {
      ASSERT_LT(index, count);
      ASSERT_FALSE(visited[index]) << index << " twice of " << count;
      visited[index] = true;
    }
    EXPECT_EQ(visits, count);
    EXPECT_FALSE(order.next(&index)) << "after the end of " << count;
  }
}

TEST(ShuffledOrder, DependsOnItsSeedAlone) {
  const auto prefix = [](uint64_t seed) {
    ShuffledOrder order(100000, seed);
    std::vector<uint64_t> indices(50);
    for (uint64_t& index : indices) order.next(&index);
    return indices;
  };
  EXPECT_EQ(prefix(1), prefix(1));
  EXPECT_NE(prefix(1), prefix(2));
}

TEST(ShuffledOrder, StartsWithAFairSample) {
  // the mean of the first 1000 of 10^6 indices: deviation 10^6 / sqrt(12 * 1000) when they are drawn independently
  for (uint64_t seed = 0; seed < 20; ++seed) {
    ShuffledOrder order(1000000, seed);
    double sum = 0.0;
    uint64_t index = 0;
    for (int i = 0; i < 1000; ++i) order.next(&index), sum += static_cast<double>(index);
    EXPECT_NEAR(sum / 1000, 5e5, 5 * 9130) << "seed " << seed;
  }
}

}  // namespace
}  // namespace nlg
