#include "train/generator/data/function_cache.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <set>

#include "tests/damage.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/sample_set.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "train/basis/basis_fit.h"
#include "train/generator/data/function_cache_writer.h"
#include "train/generator/data/sample_order.h"
#include "train/generator/data/training_data.h"

namespace {
thread_local bool is_test_thread = false;
std::atomic<bool> refuse_allocations_elsewhere{false};
}  // namespace

// Any thread but the test's own may be refused its memory. Not inlined: where only one of the pair is, GCC warns of a mismatch.
[[gnu::noinline]] void* operator new(size_t size) {
  void* const memory = refuse_allocations_elsewhere && !is_test_thread ? nullptr : std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
// a sanitizer's own would take from its heap what is freed below
[[gnu::noinline]] void* operator new(size_t size, const std::nothrow_t&) noexcept { return std::malloc(size); }
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace nlg {
namespace {

constexpr int kCount = 600;  // two blocks, the second of them not full

// A shard of the sample set's functions [first, first + count).
Shard sampleShard(const std::string& scene, int first, int count) {
  const FunctionSet set = sampleSet(count, static_cast<uint64_t>(first) + 1);
  Shard shard;
  shard.scene_id = scene;
  shard.family = "sample";
  shard.pattern_hash = set.pattern_hash;
  shard.point_count = set.point_count;
  shard.counts.functions = shard.counts.visited_probes = shard.counts.grid_probes = static_cast<uint64_t>(count);
  shard.provenance_json = "{}";
  shard.phi = set.phi;
  shard.validity = set.validity;
  shard.seen = set.seen;
  shard.blend_sum = set.blend_sum;
  shard.probe_position_m.assign(3 * static_cast<size_t>(count), 0.0);
  shard.spacing_m.assign(static_cast<size_t>(count), 1.0f);
  shard.flags.assign(static_cast<size_t>(count), 0);
  return shard;
}

// Two shards that have 40 functions in common, and a cache of both.
class Cache : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::filesystem::temp_directory_path() / ("nlg_cache_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    shards_ = {(folder_ / "a.h5").string(), (folder_ / "b.h5").string()};
    writeShard(shards_[0], sampleShard("a", 0, 400));
    writeShard(shards_[1], sampleShard("b", 360, kCount - 360));
    writeFunctionCache(path(), shards_, basis(), "basis");
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  static std::string path() { return (folder_ / "functions.cache").string(); }
  static BasisData basis() { return sampleBasis(kSampleClasses, 3); }
  static FunctionSet set() { return readFunctionSet(shards_, supportPattern().hash, kSupportPointCount); }

  // What reading everything in a damaged copy says; empty when it was taken.
  static std::string complaint(const std::string& bytes) {
    const std::string damaged = (folder_ / "damaged.cache").string();
    std::ofstream(damaged, std::ios::binary) << bytes;
    const std::string error = inputErrorOf([&] {
      FunctionCache cache(damaged);
      for (int64_t block = 0; block < cache.blockCount(); ++block) cache.loadBlock(block);
    });
    if (error == "no error") return "";
    EXPECT_EQ(error.rfind(damaged, 0), 0u) << error;
    return error;
  }

  static std::filesystem::path folder_;
  static std::vector<std::string> shards_;
};
std::filesystem::path Cache::folder_;
std::vector<std::string> Cache::shards_;

TEST_F(Cache, HoldsWhatTrainingInMemoryHolds) {
  const TrainingData memory(set(), basis(), basis(), FunctionOrder::cache);
  const TrainingData disk(std::make_unique<FunctionCache>(path()), basis(), basis());
  ASSERT_EQ(disk.functionCount(), memory.functionCount());
  ASSERT_LT(disk.functionCount(), 400 + kCount - 360) << "functions that both shards hold come once";
  EXPECT_EQ(disk.sha256(), memory.sha256());
  EXPECT_EQ(disk.scenes(), memory.scenes());
  std::vector<float> a(static_cast<size_t>(disk.inputCount())), b = a;
  for (int64_t i = 0; i < disk.functionCount(); ++i) {
    const StoredFunction x = disk.function(i), y = memory.function(i);
    ASSERT_TRUE(std::equal(x.phi, x.phi + kSupportPointCount, y.phi)) << "function " << i;
    ASSERT_TRUE(std::equal(x.validity, x.validity + kSupportPointCount / 8, y.validity)) << "function " << i;
    disk.copyInput({.function = i, .mirror = 5}, a.data());
    memory.copyInput({.function = i, .mirror = 5}, b.data());
    // batches of another size may sum in another order
    for (size_t k = 0; k < a.size(); ++k) ASSERT_NEAR(a[k], b[k], 1e-5 * (1 + std::fabs(b[k]))) << "function " << i;
  }
  EXPECT_EQ(disk.functionsAbove(0.1), memory.functionsAbove(0.1));
}

TEST_F(Cache, GivesTheCoefficientsOfATruncatedBasis) {
  Basis whole{sampleBasis(kSampleClasses, 3), {}, 0};
  // those of a real basis fall inside a class
  int first = 0;
  for (const int count : kSampleClasses) {
    const auto begin = whole.data.deviation.begin() + first;
    std::sort(begin, begin + count, std::greater<>());
    first += count;
  }
  const std::string file = (folder_ / "falling.cache").string();
  writeFunctionCache(file, shards_, whole.data, "falling");
  for (const int K : {1, 7, 24, 25}) {
    const BasisData used = truncateBasis(whole, K).data;
    ASSERT_EQ(used.coefficientCount(), K);
    const TrainingData projected(set(), used, used, FunctionOrder::cache);
    const TrainingData read(std::make_unique<FunctionCache>(file), whole.data, used);
    ASSERT_EQ(read.inputCount(), K);
    std::vector<float> a(static_cast<size_t>(K)), b = a;
    for (int64_t i = 0; i < read.functionCount(); i += 7) {
      const int mirror = static_cast<int>(i % kMirrorCount);
      read.copyInput({.function = i, .mirror = mirror}, a.data());
      projected.copyInput({.function = i, .mirror = mirror}, b.data());
      // bases of another size may sum in another order
      for (int k = 0; k < K; ++k) ASSERT_NEAR(a[k], b[k], 1e-5 * (1 + std::fabs(b[k]))) << K << " coefficients, function " << i;
    }
  }
}

TEST_F(Cache, ShufflesOverAllShards) {
  const std::vector<uint32_t> order = cacheOrder(kCount);
  EXPECT_EQ(std::set<uint32_t>(order.begin(), order.end()).size(), size_t{kCount});
  // of the first 300 places 150 ± 6 sqrt(300 / 4 / 2) go to functions of the first half
  const auto early = std::count_if(order.begin(), order.begin() + 300, [](uint32_t i) { return i < 300; });
  EXPECT_NEAR(static_cast<double>(early), 150.0, 37.0);
  std::vector<uint32_t> rest;
  for (const uint32_t i : order) {
    if (i < 500) rest.push_back(i);
  }
  EXPECT_EQ(rest, cacheOrder(500)) << "leaving functions out must not move the others";
}

TEST_F(Cache, HasTheSameBytesEveryTime) {
  const std::string first = readFile(path());
  writeFunctionCache((folder_ / "again.cache").string(), shards_, basis(), "basis");
  EXPECT_TRUE(readFile((folder_ / "again.cache").string()) == first);
}

TEST_F(Cache, IsRefusedWhenDamaged) {
  const std::string whole = readFile(path());
  expectDamageIsRefused(whole, complaint, whole.size() / 40);
}

TEST_F(Cache, IsRefusedWhenMissingOrForeign) {
  EXPECT_THROW(FunctionCache((folder_ / "missing").string()), InputError);
  EXPECT_THROW(FunctionCache(folder_.string()), InputError);
  EXPECT_NE(complaint(readFile(shards_[0])), "");
}

TEST(SampleOrder, TakesEveryFunctionOnceAnEpoch) {
  for (const int count : {1, 7, 512, 700, 8192, 8193, 20000}) {
    WindowedOrder order(count, 5);
    std::vector<int64_t> first, second;
    for (int i = 0; i < count; ++i) first.push_back(order.item(i));
    for (int i = 0; i < count; ++i) second.push_back(order.item(count + i));
    if (count > 100) {
      EXPECT_NE(first, second) << count;
    }
    std::sort(first.begin(), first.end());
    std::sort(second.begin(), second.end());
    for (int i = 0; i < count; ++i) {
      ASSERT_EQ(first[i], i) << count;
      ASSERT_EQ(second[i], i) << count;
    }
  }
}

TEST(SampleOrder, DrawsTheSameWhereverItBegins) {
  const SampleOrder::Options options{.batch = 100, .point_batch_count = 8, .part_share = 0.3, .seed = 9};
  std::vector<uint32_t> part;
  for (uint32_t i = 0; i < 20000; i += 3) part.push_back(i);
  SampleOrder whole(20000, part, options);
  for (int64_t draw = 0; draw < 500; ++draw) {
    const std::vector<Sample> expected = whole.samples(draw);
    if (draw % 37 != 0) continue;
    SampleOrder fresh(20000, part, options);
    const std::vector<Sample> got = fresh.samples(draw);
    ASSERT_EQ(got.size(), 100u);
    for (size_t b = 0; b < got.size(); ++b) {
      ASSERT_EQ(got[b].function, expected[b].function) << "draw " << draw;
      ASSERT_EQ(got[b].mirror, expected[b].mirror) << "draw " << draw;
      ASSERT_EQ(got[b].batch, expected[b].batch) << "draw " << draw;
    }
  }
}

TEST(SampleOrder, DrawsMirrorsAndNeighbouringBatchesOfPoints) {
  for (const int point_batches : {1, 2, 4, 8}) {
    SampleOrder order(700, {}, {.batch = 256, .point_batch_count = 8, .point_batches = point_batches, .seed = 4});
    std::set<int> mirrors, batches;
    for (int64_t draw = 0; draw < 4; ++draw) {
      for (const Sample& sample : order.samples(draw)) {
        ASSERT_EQ(sample.batch_count, point_batches);
        mirrors.insert(sample.mirror);
        batches.insert(sample.batch);
      }
    }
    std::set<int> expected;
    for (int batch = 0; batch < 8; batch += point_batches) expected.insert(batch);
    EXPECT_EQ(batches, expected) << "of " << point_batches;
    EXPECT_EQ(mirrors, (std::set<int>{0, 1, 2, 3, 4, 5, 6, 7}));
  }
}

TEST(SampleOrder, TakesItsShareFromTheHardFunctions) {
  const std::vector<uint32_t> part = {3, 5, 900, 15000};
  SampleOrder order(20000, part, {.batch = 20, .part_share = 0.25, .seed = 1});
  EXPECT_EQ(order.partCount(), 5);
  for (int64_t draw = 0; draw < 10; ++draw) {
    const std::vector<Sample> samples = order.samples(draw);
    ASSERT_EQ(samples.size(), 20u);
    for (size_t b = 15; b < 20; ++b)
      EXPECT_TRUE(std::count(part.begin(), part.end(), samples[b].function)) << samples[b].function;
  }
  EXPECT_EQ(SampleOrder(20000, {}, {.batch = 20, .part_share = 0.25}).partCount(), 0);
}

}  // namespace
}  // namespace nlg
