#include "datagen/dataset/shard_reader.h"

#include <fmt/format.h>

#include "datagen/dataset/shard.h"
#include "datagen/dataset/shard_check.h"
#include "tool/error.h"

namespace nlg {
namespace {

void refuse(const std::string& path, const Fault& fault) {
  if (!fault.place.empty()) throw InputError(path, fault.place, fault.expected, fault.got);
}

void requirePattern(const std::string& path, uint64_t expected, uint64_t got) {
  if (expected == 0 || expected == got) return;
  throw InputError(path, "attribute pattern_hash", fmt::format("{:016x}", expected), fmt::format("{:016x}", got));
}

Shard readAttributes(const std::string& path, const Hdf5Reader& file, uint64_t pattern_hash, int expected_point_count) {
  const std::string kind = file.readTextAttribute("kind");
  if (kind != kShardKind) throw InputError(path, "attribute kind", kShardKind, kind);
  const uint64_t version = file.readIntegerAttribute("schema_version");
  if (version != kShardVersion)
    throw InputError(path, "attribute schema_version", std::to_string(kShardVersion), std::to_string(version));
  Shard shard;
  shard.path = path;
  shard.scene_id = file.readTextAttribute("scene_id");
  shard.family = file.readTextAttribute("family");
  shard.jitter = file.readIntegerAttribute("jitter");
  shard.pattern_hash = file.readIntegerAttribute("pattern_hash");
  requirePattern(path, pattern_hash, shard.pattern_hash);
  shard.test_pattern_hash = file.readIntegerAttribute("test_pattern_hash");
  const uint64_t point_count = file.readIntegerAttribute("point_count");
  const uint64_t test_point_count = file.readIntegerAttribute("test_point_count");
  refuse(path, pointCountFault(point_count, test_point_count));
  if (expected_point_count != 0 && point_count != static_cast<uint64_t>(expected_point_count)) {
    throw InputError(path, "attribute point_count", std::to_string(expected_point_count), std::to_string(point_count));
  }
  shard.point_count = static_cast<int>(point_count);
  shard.test_point_count = static_cast<int>(test_point_count);
  shard.provenance_json = file.readTextAttribute("provenance_json");
  shard.duplicate_rule.rms = file.readRealAttribute("duplicate_rms");
  shard.duplicate_rule.validity_points = file.readIntegerAttribute("duplicate_validity_points");
  refuse(path, duplicateRuleFault(shard.duplicate_rule));
  forEachCount(shard.counts, [&](const char* name, uint64_t& count) {
    if (std::string_view(name) != kCountOutside || file.hasAttribute(name)) count = file.readIntegerAttribute(name);
  });
  return shard;
}

}  // namespace

ShardReader::ShardReader(const std::string& path, uint64_t pattern_hash, int point_count)
    : file_(path), header_(readAttributes(path, file_, pattern_hash, point_count)) {
  forEachArray(
      [&](const char* name, const std::vector<uint64_t>& columns, const auto&) {
        const std::vector<uint64_t> expected = withRows(functionCount(), columns), got = file_.shape(name);
        if (got == expected) return;
        throw InputError(path, fmt::format("dataset {}", name), fmt::format("shape {}", fmt::join(expected, " x ")),
                         fmt::format("{}", fmt::join(got, " x ")));
      },
      header_);
}

Shard ShardReader::read(uint64_t first, uint64_t count) const {
  NLG_CHECK(first + count, <=, functionCount());
  Shard shard = header_;
  forEachArray(
      [&](const char* name, const std::vector<uint64_t>& columns, auto& values) {
        using Element = typename std::remove_reference_t<decltype(values)>::value_type;
        const std::vector<uint64_t> shape = withRows(functionCount(), columns);
        if (count == functionCount()) {
          values = file_.read<Element>(name, shape);
          return;
        }
        values.resize(count * rowWidth(columns));
        file_.readRows<Element>(name, shape, first, count, values.data());
      },
      shard);
  refuse(header_.path, valueFault(shard, first));
  return shard;
}

uint64_t ShardReader::storedBytes() const {
  uint64_t bytes = 0;
  forEachArray([&](const char* name, const auto&, const auto&) { bytes += file_.storedBytes(name); }, header_);
  return bytes;
}

Shard readShard(const std::string& path, uint64_t pattern_hash, int point_count) {
  const ShardReader reader(path, pattern_hash, point_count);
  Shard shard = reader.read(0, reader.functionCount());
  // last: what is wrong with single values is said in words of theirs
  reader.verifyDigest();
  return shard;
}

Shard readShardHeader(const std::string& path, uint64_t pattern_hash, int point_count) {
  return ShardReader(path, pattern_hash, point_count).header();
}

}  // namespace nlg
