// A shard from its scene to its file: pipeline, collector, damage, full disks.

#include <gtest/gtest.h>

#include <filesystem>

#include "datagen/dataset/shard_file.h"
#include "datagen/shards/shard_job.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

class GeneratedShard : public testing::Test {
 protected:
  GeneratedShard() {
    describe(options_, table_);
    options_.max_functions = 100;
    options_.test_points = 64;
  }

  std::string at(const std::string& name) const { return folder_ / name; }

  // The shard as run with these limits and threads writes it.
  std::string make(const CollectorLimits& limits, int threads, const std::string& scene = "house:1") {
    const ShardJob job({scene, 0, true}, options_, table_);
    FunctionCollector collector = job.collector(limits, folder_.string());
    ShardWriter writer(at("shard.h5"), job.header());
    FunctionPipeline pipeline = job.pipeline();
    pipeline.makeFinisher = appendTo(writer);
    pipeline.run(threads, collector);
    ShardCounts counts = collector.counts();
    counts.grid_probes = job.probeCount();
    writer.finish(counts);
    return at("shard.h5");
  }

  const TemporaryFolder folder_;
  DatagenOptions options_;
  OptionTable table_{"datagen"};
};

TEST_F(GeneratedShard, IsTheSameForAnyNumberOfThreads) {
  const std::string one = readFile(make({100, 100000}, 1));
  EXPECT_EQ(ShardReader(at("shard.h5")).functionCount(), 100u);
  options_.threads = 3;
  EXPECT_TRUE(readFile(make({100, 100000}, 3)) == one);
}

// 64 probes are a block, 32 functions a chunk: the limits lie inside and at the edges of both.
TEST_F(GeneratedShard, StopsExactlyAtItsLimits) {
  Shard longest = readShard(make({150, 100000}, 2), 0);
  ASSERT_EQ(longest.functionCount(), 150u);
  for (const uint64_t functions : {1u, 32u, 33u}) {
    const Shard shard = readShard(make({functions, 100000}, 2), 0);
    ASSERT_EQ(shard.functionCount(), functions);
    EXPECT_TRUE(std::equal(shard.phi.begin(), shard.phi.end(), longest.phi.begin())) << functions;
    EXPECT_LE(shard.counts.visited_probes, longest.counts.visited_probes);
  }
  for (const uint64_t probes : {1u, 64u, 65u}) {
    const Shard shard = readShard(make({100000, probes}, 2), 0);
    const ShardCounts& c = shard.counts;
    EXPECT_EQ(c.visited_probes, probes);
    EXPECT_EQ(c.functions + c.free_space + c.in_solid + c.duplicates + c.empty, probes);
  }
}

TEST_F(GeneratedShard, HoldsFunctionsOfAsManyProbesInSolidAsAskedFor) {
  const Shard none = readShard(make({100000, 700}, 2), 0);
  EXPECT_EQ(none.counts.solid_functions, 0u);
  options_.in_solid = 1.0;
  const Shard all = readShard(make({100000, 700}, 2), 0);
  EXPECT_GT(all.counts.solid_functions, 20u);
  EXPECT_EQ(all.counts.in_solid + all.counts.solid_functions, none.counts.in_solid);
  const auto flagged = std::count_if(all.flags.begin(), all.flags.end(), [](uint8_t flags) { return flags & kFlagInSolid; });
  EXPECT_GT(flagged, 0);
  EXPECT_LE(static_cast<uint64_t>(flagged), all.counts.solid_functions) << "some are duplicates";
  options_.in_solid = 0.5;
  const Shard half = readShard(make({100000, 700}, 2), 0);
  // a binomial share of the same probes: six deviations
  const double n = static_cast<double>(all.counts.solid_functions);
  EXPECT_NEAR(static_cast<double>(half.counts.solid_functions), 0.5 * n, 6 * 0.5 * std::sqrt(n));
}

// two_rooms is closed, and has viewpoints: probes around it are asked for, too.
TEST_F(GeneratedShard, LeavesOutWhatLiesOutsideOfTheHull) {
  options_.extent_m = {"-3", "-1", "-3", "9", "5", "9"};
  options_.probes.spacing_min_m = options_.probes.spacing_max_m = 0.8;
  const Shard within = readShard(make({100000, 100000}, 2, "two_rooms:0"), 0);
  options_.keep_outside = true;
  const Shard all = readShard(make({100000, 100000}, 1, "two_rooms:0"), 0);
  const auto add_up = [](const ShardCounts& c) {
    return c.functions + c.free_space + c.in_solid + c.duplicates + c.empty + c.outside;
  };
  EXPECT_EQ(all.counts.outside, 0u);
  EXPECT_GT(within.counts.outside, 10u);
  EXPECT_EQ(add_up(within.counts), within.counts.visited_probes);
  EXPECT_EQ(within.counts.functions + within.counts.duplicates + within.counts.outside,
            all.counts.functions + all.counts.duplicates);
  EXPECT_GT(within.functionCount(), 10u) << "what is inside stays";
}

TEST_F(GeneratedShard, HoldsNoTwoFunctionsWithinTheTolerance) {
  const Shard exact = readShard(make({100000, 700}, 2), 0);
  options_.duplicate_rms = 4.0;
  options_.duplicate_validity_points = 200;
  const Shard shard = readShard(make({100000, 700}, 2), 0);
  EXPECT_EQ(shard.duplicate_rule, (DuplicateRule{4.0, 200}));
  EXPECT_LT(shard.functionCount(), exact.functionCount());
  const auto samples = [](const Shard& s, uint64_t n) {
    return StoredFunction{&s.phi[n * kSupportPointCount], &s.validity[n * kSupportPointCount / 8]};
  };
  for (uint64_t a = 0; a < shard.functionCount(); ++a) {
    for (uint64_t b = 0; b < a; ++b) {
      ASSERT_FALSE(duplicateDistance(shard.duplicate_rule, samples(shard, a), samples(shard, b), kSupportPointCount))
          << a << ", " << b;
    }
  }
  // whatever was dropped has its like among the kept
  for (uint64_t n = 0; n < exact.functionCount(); ++n) {
    bool found = false;
    for (uint64_t k = 0; k < shard.functionCount() && !found; ++k) {
      found = duplicateDistance(shard.duplicate_rule, samples(exact, n), samples(shard, k), kSupportPointCount).has_value();
    }
    EXPECT_TRUE(found) << "function " << n;
  }
}

}  // namespace
}  // namespace nlg
