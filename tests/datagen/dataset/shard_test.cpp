#include "datagen/dataset/shard.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "datagen/dataset/hdf5_file.h"
#include "datagen/dataset/shard_file.h"
#include "runtime_eval/support/point_order.h"
#include "tests/damage.h"
#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

// HDF5 1.10.8 itself loses some hundred bytes for each damaged file that it refuses.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace nlg {
namespace {

// N functions with every kind of value; phi is 0 wherever validity is.
Shard shardOf(uint64_t N, int P, int U) {
  Shard shard;
  shard.scene_id = "rooms/17";
  shard.family = "rooms";
  shard.jitter = 3;
  shard.pattern_hash = 0x0123456789abcdef;
  shard.test_pattern_hash = 0xfedcba9876543210;
  shard.point_count = P;
  shard.test_point_count = U;
  shard.counts = {1000, 900, N, 5, 6, 7, 8};
  shard.duplicate_rule = {0.75, 12};
  shard.provenance_json = R"({"tool":"nlg-datagen"})";
  const auto fill = [N](int points, std::vector<uint8_t>* phi, std::vector<uint8_t>* validity, std::vector<uint8_t>* seen) {
    const auto count = N * static_cast<uint64_t>(points);
    for (uint64_t b = 0; b < count / 8; ++b) validity->push_back(static_cast<uint8_t>(b * 37 + 11));
    for (const uint8_t bits : *validity) seen->push_back(bits & 0x5a);
    for (uint64_t i = 0; i < count; ++i) {
      const bool valid = ((*validity)[i / 8] >> i % 8 & 1) != 0;
      phi->push_back(valid ? static_cast<uint8_t>(i * 13 + 1) : 0);
    }
  };
  fill(P, &shard.phi, &shard.validity, &shard.seen);
  for (uint64_t i = 0; i < shard.phi.size(); ++i) shard.blend_sum.push_back(static_cast<uint8_t>(i * 7 + 3));
  fill(U, &shard.phi_test, &shard.validity_test, &shard.seen_test);
  for (uint64_t i = 0; i < N; ++i) {
    for (int axis = 0; axis < 3; ++axis) shard.probe_position_m.push_back(1e5 + 0.1 * static_cast<double>(3 * i) + axis);
    shard.spacing_m.push_back(0.25f * static_cast<float>(i + 1));
    shard.flags.push_back(static_cast<uint8_t>(i % 4));
  }
  return shard;
}

void expectEqualHeaders(const Shard& a, const Shard& b) {
  EXPECT_EQ(a.scene_id, b.scene_id);
  EXPECT_EQ(a.family, b.family);
  EXPECT_EQ(a.jitter, b.jitter);
  EXPECT_EQ(a.pattern_hash, b.pattern_hash);
  EXPECT_EQ(a.test_pattern_hash, b.test_pattern_hash);
  EXPECT_EQ(a.point_count, b.point_count);
  EXPECT_EQ(a.test_point_count, b.test_point_count);
  EXPECT_EQ(a.duplicate_rule, b.duplicate_rule);
  EXPECT_EQ(a.provenance_json, b.provenance_json);
  forEachCount([](const char* name, uint64_t of_a, uint64_t of_b) { EXPECT_EQ(of_a, of_b) << name; }, a.counts, b.counts);
}

void expectEqual(const Shard& a, const Shard& b) {
  expectEqualHeaders(a, b);
  forEachArray([](const char* name, const auto&, const auto& of_a, const auto& of_b) { EXPECT_EQ(of_a, of_b) << name; }, a, b);
}

class ShardFile : public testing::Test {
 protected:
  void expectRoundTrip(const Shard& shard) const {
    writeShard(path_, shard);
    expectEqual(readShard(path_, shard.pattern_hash), shard);
    const Shard header = readShardHeader(path_, 0);
    expectEqualHeaders(header, shard);
    EXPECT_EQ(header.functionCount(), 0u);
  }

  std::string refusal(uint64_t pattern_hash = 0) const {
    const std::string error = inputErrorOf([&] { readShard(path_, pattern_hash); });
    return error == "no error" ? "taken" : error.substr(path_.size() + 2);
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "shard.h5";
};

TEST_F(ShardFile, RoundTrips) {
  expectRoundTrip(shardOf(3, 8192, 0));
  expectRoundTrip(shardOf(40, 8192, 1024));
  expectRoundTrip(shardOf(5, 8, 8));
  expectRoundTrip(shardOf(0, 8192, 64));
}

TEST_F(ShardFile, RefusesAnotherPattern) {
  writeShard(path_, shardOf(2, 8, 8));
  EXPECT_EQ(refusal(0), "taken");
  EXPECT_EQ(refusal(5), "attribute pattern_hash: expected 0000000000000005, got 0123456789abcdef");
  EXPECT_THROW(readShardHeader(path_, 5), InputError);
}

TEST_F(ShardFile, RefusesWhatIsDamaged) {
  writeShard(path_, shardOf(2, 64, 8));
  const std::string whole = readFile(path_);
  const auto said = [&](const std::string& bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    const std::string of_digest = inputErrorOf([&] { ShardReader(path_).verifyDigest(); }), of_shard = refusal();
    EXPECT_EQ(of_digest == "no error", of_shard == "taken") << of_digest << "; " << of_shard;
    return of_shard == "taken" ? "" : of_shard;
  };
  expectDamageIsRefused(whole, said, whole.size() / 60);
  EXPECT_NE(said(whole + whole), "") << "itself once more";
}

TEST_F(ShardFile, IsReadInAnyPieces) {
  const Shard shard = shardOf(100, 64, 8);
  writeShard(path_, shard);
  const ShardReader reader(path_);
  for (const auto& [first, count] : {std::pair{0, 100}, {0, 1}, {31, 2}, {32, 32}, {5, 90}, {99, 1}, {50, 0}}) {
    const Shard piece = reader.read(first, count);
    EXPECT_EQ(piece.phi, std::vector<uint8_t>(shard.phi.begin() + first * 64, shard.phi.begin() + (first + count) * 64))
        << first << " + " << count;
    EXPECT_EQ(piece.spacing_m, std::vector<float>(shard.spacing_m.begin() + first, shard.spacing_m.begin() + first + count));
  }
}

TEST_F(ShardFile, IsTheSameWrittenPieceByPiece) {
  const Shard shard = shardOf(100, 64, 8);
  writeShard(path_, shard);
  const std::string whole = readFile(path_);
  ShardWriter writer(path_, shard);
  for (uint64_t first = 0; first < 100; first += kChunkFunctions) {
    writer.append(encodeFunctions(shard, first, std::min<uint64_t>(kChunkFunctions, 100 - first)));
  }
  writer.finish(shard.counts);
  EXPECT_TRUE(readFile(path_) == whole);
}

TEST_F(ShardFile, SaysWhereItsPointsAre) {
  Shard shard = shardOf(2, kSupportPointCount, 24);
  shard.pattern_hash = supportPattern().hash;
  shard.test_pattern_hash = hashPoints(testPoints(24));
  writeShard(path_, shard);
  const auto flat = [](const std::vector<LocalPoint>& points) {
    std::vector<float> values;
    for (const LocalPoint& point : points) values.insert(values.end(), point.begin(), point.end());
    return values;
  };
  const Hdf5Reader file(path_);
  EXPECT_EQ(file.read<float>("points", {kSupportPointCount, 3}), flat(supportPattern().points));
  EXPECT_EQ(file.read<float>("points_test", {24, 3}), flat(testPoints(24)));
  EXPECT_NE(file.readTextAttribute("units").find("\"spacing_m\": \"m\""), std::string::npos);
}

}  // namespace
}  // namespace nlg
