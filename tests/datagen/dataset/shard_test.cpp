#include "datagen/dataset/shard.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>

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
  EXPECT_EQ(a.counts.grid_probes, b.counts.grid_probes);
  EXPECT_EQ(a.counts.visited_probes, b.counts.visited_probes);
  EXPECT_EQ(a.counts.functions, b.counts.functions);
  EXPECT_EQ(a.counts.free_space, b.counts.free_space);
  EXPECT_EQ(a.counts.in_solid, b.counts.in_solid);
  EXPECT_EQ(a.counts.duplicates, b.counts.duplicates);
  EXPECT_EQ(a.counts.empty, b.counts.empty);
  EXPECT_EQ(a.counts.outside, b.counts.outside);
}

void expectEqual(const Shard& a, const Shard& b) {
  expectEqualHeaders(a, b);
  EXPECT_EQ(a.phi, b.phi);
  EXPECT_EQ(a.validity, b.validity);
  EXPECT_EQ(a.seen, b.seen);
  EXPECT_EQ(a.probe_position_m, b.probe_position_m);
  EXPECT_EQ(a.spacing_m, b.spacing_m);
  EXPECT_EQ(a.flags, b.flags);
  EXPECT_EQ(a.phi_test, b.phi_test);
  EXPECT_EQ(a.validity_test, b.validity_test);
  EXPECT_EQ(a.seen_test, b.seen_test);
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

// A shard's file written by hand, so that it can hold what writeShard would never write: change alters attributes and values,
// while the arrays keep the shapes that they had before.
template <class Change>
void writeByHand(const std::string& path, Shard shard, uint64_t version, const std::string& kind, const Change& change) {
  Hdf5Writer file(path);
  const Shard told = shard;
  change(&shard);
  file.writeAttribute("kind", kind);
  file.writeAttribute("schema_version", version);
  file.writeAttribute("scene_id", shard.scene_id);
  file.writeAttribute("family", shard.family);
  file.writeAttribute("provenance_json", shard.provenance_json);
  file.writeAttribute("jitter", shard.jitter);
  file.writeAttribute("pattern_hash", shard.pattern_hash);
  file.writeAttribute("test_pattern_hash", shard.test_pattern_hash);
  file.writeAttribute("point_count", static_cast<uint64_t>(shard.point_count));
  file.writeAttribute("test_point_count", static_cast<uint64_t>(shard.test_point_count));
  file.writeAttribute("duplicate_rms", shard.duplicate_rule.rms);
  file.writeAttribute("duplicate_validity_points", shard.duplicate_rule.validity_points);
  file.writeAttribute("count_functions", shard.counts.functions);
  // an older shard, without the count of outside
  for (const char* name : {"grid_probes", "visited_probes", "free_space", "in_solid", "duplicates", "empty", "solid_functions"}) {
    file.writeAttribute(std::string("count_") + name, uint64_t{0});
  }
  const uint64_t N = told.functionCount(), P = static_cast<uint64_t>(told.point_count),
                 U = static_cast<uint64_t>(told.test_point_count);
  file.write("phi", {N, P}, shard.phi.data());
  file.write("validity", {N, P / 8}, shard.validity.data());
  file.write("seen", {N, P / 8}, shard.seen.data());
  file.write("blend_sum", {N, P}, shard.blend_sum.data());
  file.write("probe_position_m", {N, 3}, shard.probe_position_m.data());
  file.write("spacing_m", {N}, shard.spacing_m.data());
  file.write("flags", {N}, shard.flags.data());
  file.write("phi_test", {N, U}, shard.phi_test.data());
  file.write("validity_test", {N, U / 8}, shard.validity_test.data());
  file.write("seen_test", {N, U / 8}, shard.seen_test.data());
  file.closeWithDigest();
}

TEST_F(ShardFile, RoundTrips) {
  expectRoundTrip(shardOf(3, 8192, 0));
  expectRoundTrip(shardOf(40, 8192, 1024));
  expectRoundTrip(shardOf(5, 8, 8));
  expectRoundTrip(shardOf(0, 8192, 64));
}

TEST_F(ShardFile, GivesTheSameBytesForTheSameShard) {
  writeShard(path_, shardOf(20, 8192, 64));
  const std::string first = fileSha256(path_);
  ::usleep(1100000);  // HDF5's own time stamps count seconds
  writeShard(path_, shardOf(20, 8192, 64));
  EXPECT_EQ(fileSha256(path_), first);
}

TEST_F(ShardFile, RefusesAnotherPattern) {
  writeShard(path_, shardOf(2, 8, 8));
  EXPECT_EQ(refusal(0), "taken");
  EXPECT_EQ(refusal(5), "attribute pattern_hash: expected 0000000000000005, got 0123456789abcdef");
  EXPECT_THROW(readShardHeader(path_, 5), InputError);
}

TEST_F(ShardFile, RefusesAMissingFile) {
  EXPECT_NE(refusal().find(kNoSuchFile), std::string::npos);
  EXPECT_THROW(readShardHeader(path_, 0), InputError);
}

TEST_F(ShardFile, RefusesWhatBreaksTheContract) {
  const auto refusalOf = [&](const auto& change) {
    writeByHand(path_, shardOf(4, 16, 8), kShardVersion, "nlg-weighting-functions", change);
    return refusal();
  };
  EXPECT_EQ(refusalOf([](Shard*) {}), "taken");
  EXPECT_EQ(refusalOf([](Shard* s) { s->counts.functions = 5; }), "dataset phi: expected shape 5 x 16, got 4 x 16");
  EXPECT_EQ(refusalOf([](Shard* s) { s->counts.functions = uint64_t{1} << 62; }),
            "dataset phi: expected shape 4611686018427387904 x 16, got 4 x 16");
  const std::string sane = "expected a multiple of 8, at most 65536";
  EXPECT_EQ(refusalOf([](Shard* s) { s->point_count = 0; }), "attribute point_count: " + sane + ", not 0, got 0");
  EXPECT_EQ(refusalOf([](Shard* s) { s->point_count = 12; }), "attribute point_count: " + sane + ", not 0, got 12");
  EXPECT_EQ(refusalOf([](Shard* s) { s->point_count = 65544; }), "attribute point_count: " + sane + ", not 0, got 65544");
  EXPECT_EQ(refusalOf([](Shard* s) { s->point_count = -8; }),
            "attribute point_count: " + sane + ", not 0, got 18446744073709551608");
  EXPECT_EQ(refusalOf([](Shard* s) { s->test_point_count = 9; }), "attribute test_point_count: " + sane + ", got 9");
  EXPECT_EQ(refusalOf([](Shard* s) { s->test_point_count = 16; }), "dataset phi_test: expected shape 4 x 16, got 4 x 8");
  EXPECT_EQ(refusalOf([](Shard* s) { s->spacing_m[2] = 0; }),
            "dataset spacing_m: function 2: expected a finite number above 0, got 0");
  EXPECT_EQ(refusalOf([](Shard* s) { s->spacing_m[3] = std::numeric_limits<float>::infinity(); }),
            "dataset spacing_m: function 3: expected a finite number above 0, got inf");
  EXPECT_EQ(refusalOf([](Shard* s) { s->probe_position_m[5] = std::numeric_limits<double>::quiet_NaN(); }),
            "dataset probe_position_m: function 1: expected finite numbers, got nan");
  EXPECT_EQ(refusalOf([](Shard* s) {
              s->validity[2] = 0xfd;
              s->phi[17] = 9;
            }),
            "dataset phi: function 1, point 1: expected 0 at an invalid point, got 9");
  EXPECT_EQ(refusalOf([](Shard* s) {
              s->validity_test[3] = 0x7f;
              s->phi_test[31] = 255;
            }),
            "dataset phi_test: function 3, point 7: expected 0 at an invalid point, got 255");
  EXPECT_EQ(refusalOf([](Shard* s) { s->duplicate_rule.rms = -1; }),
            "attribute duplicate_rms: expected a number from 0 to 255, got -1");
  EXPECT_EQ(refusalOf([](Shard* s) { s->duplicate_rule.rms = std::numeric_limits<double>::quiet_NaN(); }),
            "attribute duplicate_rms: expected a finite number, got nan");
}

TEST_F(ShardFile, RefusesAnotherKindOrVersion) {
  const auto keep = [](Shard*) {};
  writeByHand(path_, shardOf(1, 8, 0), 1, "nlg-weighting-functions", keep);
  EXPECT_EQ(refusal(), "attribute schema_version: expected 2, got 1") << "without sums of the blend";
  writeByHand(path_, shardOf(1, 8, 0), kShardVersion, "nlg-basis", keep);
  EXPECT_EQ(refusal(), "attribute kind: expected nlg-weighting-functions, got nlg-basis");
  {
    Hdf5Writer file(path_);
    file.close();
  }
  EXPECT_EQ(refusal().rfind("attribute kind: expected an attribute, got ", 0), 0u) << refusal();
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
  expectDamageIsRefused(whole, said, 17);
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

TEST_F(ShardFile, LeavesTheOldShardWhenTheNewOneCannotBeWritten) {
  EXPECT_THROW(writeShard("/proc/nlg/x.h5", shardOf(1, 8, 0)), OutputError);
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

TEST(ShardDeathTest, StopsAWriterThatBreaksTheContract) {
  Shard shard = shardOf(2, 8, 0);
  shard.counts.functions = 3;
  EXPECT_DEATH(writeShard("/tmp/nlg_never", shard), "check failed");
  shard = shardOf(2, 8, 0);
  shard.validity[0] = 0;
  EXPECT_DEATH(writeShard("/tmp/nlg_never", shard), "function 0, point 0");
}

}  // namespace
}  // namespace nlg
