#include "datagen/dataset/function_set.h"

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kPattern = 0x1234;
constexpr int kPoints = 32, kTest = 16;

// Functions that are told apart by the number of `first` on.
Shard shardOf(const std::string& scene, int count, int first, int test = kTest) {
  Shard shard;
  shard.scene_id = scene;
  shard.family = "family of " + scene;
  shard.pattern_hash = kPattern;
  shard.test_pattern_hash = 77;
  shard.point_count = kPoints;
  shard.test_point_count = test;
  shard.provenance_json = "{}";
  shard.counts = {100, 50, static_cast<uint64_t>(count), 5, 6, 7, 8};
  for (int n = first; n < first + count; ++n) {
    for (int p = 0; p < kPoints; ++p) shard.phi.push_back(static_cast<uint8_t>(n + p));
    shard.validity.insert(shard.validity.end(), kPoints / 8, 0xff);
    shard.seen.insert(shard.seen.end(), kPoints / 8, static_cast<uint8_t>(n));
    shard.blend_sum.insert(shard.blend_sum.end(), kPoints, 255);
    shard.phi_test.insert(shard.phi_test.end(), test, static_cast<uint8_t>(n));
    shard.validity_test.insert(shard.validity_test.end(), test / 8, 0xff);
    shard.seen_test.insert(shard.seen_test.end(), test / 8, static_cast<uint8_t>(n));
    shard.probe_position_m.insert(shard.probe_position_m.end(), 3, n);
    shard.spacing_m.push_back(1.0f);
    shard.flags.push_back(0);
  }
  return shard;
}

class FunctionSetFiles : public testing::Test {
 protected:
  std::string write(const Shard& shard) {
    const std::string path = folder_ / (std::to_string(file_count_++) + ".h5");
    writeShard(path, shard);
    return path;
  }

  const TemporaryFolder folder_;
  int file_count_ = 0;
};

TEST_F(FunctionSetFiles, AreReadInOrder) {
  const FunctionSet set =
      readFunctionSet({write(shardOf("a", 3, 10)), write(shardOf("b", 2, 40)), write(shardOf("a", 1, 80))}, kPattern);
  ASSERT_EQ(set.functionCount(), 6u);
  EXPECT_EQ(set.scene_ids, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(set.families, (std::vector<std::string>{"family of a", "family of b"}));
  EXPECT_EQ(set.scene_idx, (std::vector<uint32_t>{0, 0, 0, 1, 1, 0}));
  const uint8_t first_values[] = {10, 11, 12, 40, 41, 80};
  ASSERT_EQ(set.phi.size(), 6u * kPoints);
  ASSERT_EQ(set.validity.size(), 6u * kPoints / 8);
  ASSERT_EQ(set.phi_test.size(), 6u * kTest);
  ASSERT_EQ(set.seen_test.size(), 6u * kTest / 8);
  for (int n = 0; n < 6; ++n) {
    EXPECT_EQ(set.phi[n * kPoints], first_values[n]) << "function " << n;
    EXPECT_EQ(set.seen[n * kPoints / 8], first_values[n]) << "function " << n;
    EXPECT_EQ(set.phi_test[n * kTest], first_values[n]) << "function " << n;
    EXPECT_EQ(set.seen_test[n * kTest / 8], first_values[n]) << "function " << n;
  }
  EXPECT_EQ(set.counts.grid_probes, 300u);
  EXPECT_EQ(set.counts.functions, 6u);
  EXPECT_EQ(set.counts.free_space, 15u);
}

TEST_F(FunctionSetFiles, DropAndCountDuplicatesBetweenShards) {
  // 10 11 12 13 | 12 13 14 | 13 14 15: 2 and then 2 of them are there already
  const FunctionSet set =
      readFunctionSet({write(shardOf("a", 4, 10)), write(shardOf("b", 3, 12)), write(shardOf("c", 3, 13))}, kPattern);
  ASSERT_EQ(set.functionCount(), 6u);
  EXPECT_EQ(set.scene_idx, (std::vector<uint32_t>{0, 0, 0, 0, 1, 2}));
  EXPECT_EQ(set.counts.functions, 6u);
  EXPECT_EQ(set.counts.duplicates, 3u * 7u + 4u) << "those inside shards and those between them";
  EXPECT_EQ(set.counts.visited_probes, 150u);
}

TEST_F(FunctionSetFiles, KeepFunctionsThatDifferInValidityAlone) {
  Shard other = shardOf("b", 1, 10);
  // phi is 0 where it is not valid: point 31 of function 10 holds 41
  other.phi[31] = 0;
  Shard third = other;
  third.validity[3] = 0x7f;
  EXPECT_EQ(readFunctionSet({write(shardOf("a", 1, 10)), write(other), write(third)}, kPattern).functionCount(), 3u);
}

// Neighbouring functions differ by 1 in every sample.
TEST_F(FunctionSetFiles, DropDuplicatesByTheRuleOfTheirShards) {
  const auto ruled = [](Shard shard, double rms) {
    shard.duplicate_rule = {rms, 0};
    return shard;
  };
  const std::string a = write(ruled(shardOf("a", 1, 10), 1.5)), b = write(ruled(shardOf("b", 3, 11), 1.5)),
                    c = write(ruled(shardOf("c", 40, 60), 0.5)), d = write(ruled(shardOf("d", 70, 50), 0.5));
  const FunctionSet set = readFunctionSet({a, b}, kPattern);
  ASSERT_EQ(set.functionCount(), 2u) << "10 | 11 is like 10, 12 stays, 13 is like 12";
  EXPECT_EQ(set.phi[kPoints], 12);
  EXPECT_EQ(readFunctionSet({c, d}, kPattern).functionCount(), 70u) << "50 to 119; nothing within half a step";
  EXPECT_THROW(readFunctionSet({a, c}, kPattern), InputError) << "two rules";
  // the filter that reads earlier shards from their files drops the same
  DuplicateFilter filter;
  Shard first = readShard(c, kPattern), second = readShard(d, kPattern);
  filter.removeKnown(&first);
  filter.removeKnown(&second);
  EXPECT_EQ(first.functionCount(), 40u);
  ASSERT_EQ(second.functionCount(), 30u);
  EXPECT_EQ(second.phi[9 * kPoints], 59);
  EXPECT_EQ(second.phi[10 * kPoints], 100);
  EXPECT_EQ(second.counts.duplicates, 7u + 40u);
}

TEST_F(FunctionSetFiles, RefuseShardsThatDoNotBelongTogether) {
  const std::string first = write(shardOf("a", 2, 10));
  EXPECT_THROW(readFunctionSet({first, write(shardOf("b", 2, 40, 8))}, kPattern), InputError) << "another number of test points";
  EXPECT_THROW(readFunctionSet({first, write(shardOf("b", 2, 40, 0))}, kPattern), InputError) << "no test points";
  EXPECT_THROW(readFunctionSet({first}, kPattern + 1), InputError) << "another pattern";
  Shard other_test = shardOf("b", 2, 40);
  other_test.test_pattern_hash = 78;
  EXPECT_THROW(readFunctionSet({first, write(other_test)}, kPattern), InputError) << "other test points";
  Shard other_pattern = shardOf("b", 2, 40);
  other_pattern.pattern_hash = kPattern + 1;
  EXPECT_THROW(readFunctionSet({first, write(other_pattern)}, 0), InputError) << "two patterns, when any is taken";
  // same hash, so the file lies; its rows must not be read at the others' width
  Shard narrow = shardOf("b", 2, 40);
  narrow.point_count = 8;
  narrow.phi.resize(2 * 8);
  narrow.validity.resize(2);
  narrow.seen.resize(2);
  narrow.blend_sum.resize(2 * 8);
  EXPECT_THROW(readFunctionSet({first, write(narrow)}, kPattern), InputError) << "another number of points";
}

}  // namespace
}  // namespace nlg
