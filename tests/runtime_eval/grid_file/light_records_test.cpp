#include "runtime_eval/grid_file/light_records.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

// Light that falls off along each axis, with what rays leave in it.
std::vector<float> lightOf(const ProbeTree& tree, double noise, uint64_t seed) {
  Random random(seed);
  std::vector<float> light;
  for (size_t probe = 0; probe < tree.probeCount(); ++probe) {
    const LatticePoint at = tree.probeLattice(probe);
    for (size_t i = 0; i < kShFloats; ++i) {
      const double along = at[i % 3] / 64.0, mean = i < kShChannels ? 4.0 : 0.0;
      light.push_back(
          static_cast<float>(mean + std::sin(along + 0.3 * static_cast<double>(i)) + noise * random.uniform(-1.0, 1.0)));
    }
  }
  return light;
}

struct Case {
  ProbeTree tree = smallTree();
  std::vector<uint32_t> probe_function;
  PackedLight packed;

  Case(double noise, bool has_holes) : probe_function(tree.probeCount(), kFreeSpace) {
    for (size_t probe = 0; probe < probe_function.size() && has_holes; ++probe) {
      if (probe % 5 == 2) probe_function[probe] = kNoWeight;
    }
    const std::vector<float> all = lightOf(tree, noise, 3);
    std::vector<float> light;
    for (size_t probe = 0; probe < probe_function.size(); ++probe) {
      if (probe_function[probe] == kNoWeight) continue;
      light.insert(light.end(), &all[probe * kShFloats], &all[probe * kShFloats] + kShFloats);
    }
    packLight(light, 0.02, &packed);
  }
  std::vector<RecordsBefore> before() const { return recordsBefore(tree, probe_function); }
  size_t words() const { return static_cast<size_t>(lightWords(packed)); }
};

TEST(LightRecords, ComeBack) {
  for (const bool has_holes : {false, true}) {
    Case of(0.1, has_holes);
    const std::vector<RecordsBefore> before = of.before();
    // three groups: the second knows darkness here and there, the third nothing else
    const std::vector<uint32_t> one = of.packed.records;
    for (int group = 0; group < 2; ++group) {
      std::vector<uint32_t> other = one;
      for (size_t record = 0; record < before.size(); ++record) {
        if (group == 1 || record % 3 == 1 || record < 4)
          std::fill_n(other.begin() + static_cast<ptrdiff_t>(record * of.words()), of.words(), 0u);
      }
      of.packed.records.insert(of.packed.records.end(), other.begin(), other.end());
    }
    const std::vector<uint8_t> coded = codedRecords(of.packed, before);
    PackedLight read = of.packed;
    read.records.clear();
    const FileResult result = decodeRecords(coded, before, 3, &read);
    ASSERT_TRUE(result.ok()) << result.detail;
    EXPECT_TRUE(read.records == of.packed.records);

    for (const size_t groups : {2u, 4u}) {
      EXPECT_EQ(decodeRecords(coded, before, groups, &read).status, FileStatus::tensor_unexpected);
      EXPECT_TRUE(read.records.empty());
    }
    const std::vector<RecordsBefore> fewer(before.begin(), before.end() - 1);
    EXPECT_EQ(decodeRecords(coded, fewer, 3, &read).status, FileStatus::tensor_unexpected);
    for (const size_t bytes : {size_t{0}, size_t{3}, coded.size() / 2, coded.size() - 1}) {
      EXPECT_EQ(decodeRecords({coded.begin(), coded.begin() + static_cast<ptrdiff_t>(bytes)}, before, 3, &read).status,
                FileStatus::tensor_unexpected);
    }
    std::vector<uint8_t> longer = coded;
    longer.push_back(0);
    EXPECT_EQ(decodeRecords(longer, before, 3, &read).status, FileStatus::tensor_unexpected);
  }
}

}  // namespace
}  // namespace nlg
