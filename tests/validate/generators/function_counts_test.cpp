#include "validate/generators/function_counts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "runtime_eval/support/weighting_function.h"
#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kPoints = kSupportPointCount, kOctant = kPoints / 8;

// The n-th function, and its mirror image along x: octants 1, 3, 5, 7 change places with those before.
std::vector<uint8_t> phiOf(int n, bool is_mirrored = false) {
  std::vector<uint8_t> phi(kPoints);
  for (size_t p = 0; p < kPoints; ++p) {
    const size_t from = is_mirrored ? p ^ kOctant : p;
    phi[p] = static_cast<uint8_t>((from / kOctant * 20 + from * static_cast<size_t>(n + 3) / 7) % 256);
  }
  return phi;
}

class FunctionCountsOfShards : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::vector<std::vector<uint8_t>>& functions) {
    Shard shard;
    shard.scene_id = name;
    shard.family = "level";
    shard.pattern_hash = supportPattern().hash;
    shard.point_count = static_cast<int>(kPoints);
    shard.duplicate_rule = {0.5, 16};
    shard.provenance_json = "{}";
    for (const std::vector<uint8_t>& phi : functions) {
      shard.phi.insert(shard.phi.end(), phi.begin(), phi.end());
      shard.validity.insert(shard.validity.end(), kPoints / 8, 0xff);
      shard.seen.insert(shard.seen.end(), kPoints / 8, 0xff);
      shard.blend_sum.insert(shard.blend_sum.end(), kPoints, 255);
      shard.probe_position_m.insert(shard.probe_position_m.end(), 3, 0.0);
      shard.spacing_m.push_back(1.0f);
      shard.flags.push_back(0);
    }
    shard.counts.functions = shard.counts.visited_probes = shard.counts.grid_probes = functions.size();
    std::string path = folder_ / (name + ".h5");
    writeShard(path, shard);
    return path;
  }

  static FunctionSet setOf(const std::vector<std::string>& paths) {
    return readFunctionSet(paths, supportPattern().hash, kSupportPointCount);
  }

  const TemporaryFolder folder_;
};

TEST_F(FunctionCountsOfShards, AreTheSameOnAnyNumberOfThreads) {
  const std::vector<std::string> held_out = {write("h0", {phiOf(1), phiOf(2), phiOf(3)}), write("h1", {phiOf(4)})};
  // neighbours share functions, the last shares one with the first; 2 is trained on as it is, 4 as its mirror image
  const std::vector<std::string> training = {write("t0", {phiOf(10), phiOf(11)}), write("t1", {phiOf(11), phiOf(2)}),
                                             write("t2", {phiOf(12)}), write("t3", {phiOf(4, true), phiOf(12)}),
                                             write("t4", {phiOf(10), phiOf(13)})};
  const FunctionSet set = setOf(held_out);
  struct Expected {
    size_t training_shards;
    uint64_t functions, duplicates, in_training, in_training_mirrored;
  };
  for (const Expected& expected : {Expected{0, 4, 0, 0, 0}, {1, 6, 0, 0, 0}, {2, 6, 2, 1, 1}, {3, 7, 2, 1, 1}, {5, 9, 4, 1, 2}}) {
    for (const int threads : {1, 2, 3, 5}) {
      const std::vector<std::string> some(training.begin(),
                                          training.begin() + static_cast<std::ptrdiff_t>(expected.training_shards));
      const FunctionCounts counts = countFunctions(some, held_out, set, threads);
      SCOPED_TRACE(std::to_string(expected.training_shards) + " shards, " + std::to_string(threads) + " threads");
      EXPECT_EQ(counts.all.functions, expected.functions);
      EXPECT_EQ(counts.all.duplicates, expected.duplicates);
      EXPECT_EQ(counts.known.countInTraining(), expected.in_training);
      EXPECT_EQ(counts.known.countInTrainingMirrored(), expected.in_training_mirrored);
      EXPECT_EQ(counts.known.in_training[1], expected.in_training == 1);
      EXPECT_EQ(counts.known.in_training_mirrored[3], expected.in_training_mirrored == 2);
    }
  }
}

TEST_F(FunctionCountsOfShards, RefuseADamagedShardWhereverItStands) {
  const std::vector<std::string> held_out = {write("h", {phiOf(1)})};
  const FunctionSet set = setOf(held_out);
  for (const size_t damaged : {0u, 2u, 4u}) {
    std::vector<std::string> training;
    for (int n = 0; n < 5; ++n) training.push_back(write("d" + std::to_string(n), {phiOf(20 + n)}));
    std::fstream file(training[damaged], std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-1, std::ios::end);  // of the samples or what follows them: the SHA-256 knows every byte
    file.put('!');
    file.close();
    expectInputError(training[damaged], [&] { countFunctions(training, held_out, set, 3); });
  }
}

}  // namespace
}  // namespace nlg
