#include "datagen/dataset/shard_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datagen/dataset/shard_check.h"
#include "datagen/functions/chunk_codec.h"
#include "runtime_eval/support/point_order.h"
#include "tool/atomic_file.h"
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
  // kind and version before anything else: a file of another version has other attributes
  const std::string kind = file.readTextAttribute("kind");
  if (kind != kShardKind) throw InputError(path, "attribute kind", kShardKind, kind);
  const uint64_t version = file.readIntegerAttribute("schema_version");
  if (version != kShardVersion)
    throw InputError(path, "attribute schema_version", std::to_string(kShardVersion) + " (make shards of other versions again)",
                     std::to_string(version));
  Shard shard;
  shard.path = path;
  shard.scene_id = file.readTextAttribute("scene_id");
  shard.family = file.readTextAttribute("family");
  shard.jitter = file.readIntegerAttribute("jitter");
  // functions are meaningless on another pattern: its hash must be the reader's
  shard.pattern_hash = file.readIntegerAttribute("pattern_hash");
  requirePattern(path, pattern_hash, shard.pattern_hash);
  shard.test_pattern_hash = file.readIntegerAttribute("test_pattern_hash");
  // refused before anything of their size is allocated
  const uint64_t point_count = file.readIntegerAttribute("point_count");
  const uint64_t test_point_count = file.readIntegerAttribute("test_point_count");
  refuse(path, pointCountFault(point_count, test_point_count));
  if (expected_point_count != 0 && point_count != static_cast<uint64_t>(expected_point_count)) {
    throw InputError(path, "attribute point_count", std::to_string(expected_point_count), std::to_string(point_count));
  }
  shard.point_count = static_cast<int>(point_count);
  shard.test_point_count = static_cast<int>(test_point_count);
  shard.provenance_json = file.readTextAttribute("provenance_json");
  // readers check duplicates by the rule that the writer used
  shard.duplicate_rule.rms = file.readRealAttribute("duplicate_rms");
  shard.duplicate_rule.validity_points = file.readIntegerAttribute("duplicate_validity_points");
  refuse(path, duplicateRuleFault(shard.duplicate_rule));
  // a count that older files lack stays 0
  forEachCount(
      [&](const char* name, uint64_t& count) {
        if (std::string_view(name) != kCountOutside || file.hasAttribute(name)) count = file.readIntegerAttribute(name);
      },
      shard.counts);
  return shard;
}

// What every array and attribute with a unit is in, for readers that have no other source.
constexpr char kUnits[] =
    R"({"phi": "1/255", "blend_sum": "1/255", "phi_test": "1/255", "validity, seen": "bit i % 8 of byte i / 8 is of point i", )"
    R"("points": "probe spacings, relative to the probe", "probe_position_m": "m", "spacing_m": "m", "duplicate_rms": "phi"})";

void writePoints(const char* name, const std::vector<LocalPoint>& points, Hdf5Writer* file) {
  if (!points.empty()) file->write(name, {points.size(), 3}, points.front().data());
}

template <class Values>
using ElementOf = typename std::remove_reference_t<Values>::value_type;

bool isEmptyRow(const std::vector<uint64_t>& columns) { return rowWidth(columns) == 0; }

// The writer's promises: a shard that readShard would refuse is a bug of whoever made it.
void checkOwnPromises(const Shard& shard) {
  forEachArray([&](const char*, const std::vector<uint64_t>& columns,
                   const auto& values) { NLG_CHECK(values.size(), ==, shard.functionCount() * rowWidth(columns)); },
               shard);
  NLG_CHECK(valueFault(shard).place, ==, "");
}

}  // namespace

const OwnFiles kShardFiles = {"a shard", [](std::string_view bytes) { return hold(bytes, kShardKind); }};

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

std::string ShardHeader::sceneSha256() const {
  const auto origin = nlohmann::json::parse(provenance_json, nullptr, false);
  const nlohmann::json::json_pointer place("/inputs/scene");
  return origin.is_object() && origin.contains(place) && origin[place].is_string() ? origin[place].get<std::string>() : "";
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

EncodedFunctions encodeFunctions(const FunctionRows& rows, uint64_t first, uint64_t count) {
  NLG_CHECK(count, >=, 1u);
  NLG_CHECK(count, <=, kChunkFunctions);
  EncodedFunctions encoded{count, {}};
  forEachArray(
      [&](const char*, const std::vector<uint64_t>& columns, const auto& values) {
        if (isEmptyRow(columns)) {
          encoded.arrays.emplace_back();
          return;
        }
        const size_t width = rowWidth(columns), row_bytes = width * sizeof(ElementOf<decltype(values)>);
        const auto* const bytes = reinterpret_cast<const uint8_t*>(values.data() + first * width);
        if (count == kChunkFunctions) {
          encoded.arrays.push_back(encodeChunk(bytes, count * row_bytes));
          return;
        }
        // HDF5 stores whole chunks: zeros behind the last function
        std::vector<uint8_t> padded(bytes, bytes + count * row_bytes);
        padded.resize(kChunkFunctions * row_bytes, 0);
        encoded.arrays.push_back(encodeChunk(padded.data(), padded.size()));
      },
      rows);
  return encoded;
}

ShardWriter::ShardWriter(const std::string& path, const Shard& header) : file_(path), shape_(emptyLike(header)) {
  // a header that readers refuse is our bug
  NLG_CHECK(header.point_count, >=, 0);
  NLG_CHECK(header.test_point_count, >=, 0);
  const Fault fault = pointCountFault(static_cast<uint64_t>(header.point_count), static_cast<uint64_t>(header.test_point_count));
  NLG_CHECK(fault.place, ==, "");
  NLG_CHECK(duplicateRuleFault(header.duplicate_rule).place, ==, "");
  // attributes hold what must be known before any array: of which scene, sampled where, made how
  file_.writeAttribute("kind", std::string(kShardKind));
  file_.writeAttribute("schema_version", kShardVersion);
  file_.writeAttribute("scene_id", header.scene_id);
  file_.writeAttribute("family", header.family);
  file_.writeAttribute("jitter", header.jitter);
  file_.writeAttribute("pattern_hash", header.pattern_hash);
  file_.writeAttribute("test_pattern_hash", header.test_pattern_hash);
  file_.writeAttribute("point_count", static_cast<uint64_t>(header.point_count));
  file_.writeAttribute("test_point_count", static_cast<uint64_t>(header.test_point_count));
  file_.writeAttribute("duplicate_rms", header.duplicate_rule.rms);
  file_.writeAttribute("duplicate_validity_points", header.duplicate_rule.validity_points);
  file_.writeAttribute("provenance_json", header.provenance_json);
  file_.writeAttribute("units", std::string(kUnits));
  // where the functions are known; for other readers, ours go by the hashes
  if (header.pattern_hash == supportPattern().hash) writePoints("points", supportPattern().points, &file_);
  const std::vector<LocalPoint> test = testPoints(header.test_point_count);
  if (header.test_pattern_hash == hashPoints(test)) writePoints("points_test", test, &file_);
  // arrays grow a chunk at a time; those without columns are left out
  forEachArray(
      [&](const char* name, const std::vector<uint64_t>& columns, const auto& values) {
        if (!isEmptyRow(columns)) file_.makeGrowing<ElementOf<decltype(values)>>(name, columns, kChunkFunctions);
      },
      header);
}

void ShardWriter::append(const EncodedFunctions& functions) {
  size_t array = 0;
  forEachArray(
      [&](const char* name, const std::vector<uint64_t>& columns, const auto&) {
        const std::vector<uint8_t>& encoded = functions.arrays.at(array++);
        if (isEmptyRow(columns)) return;
        file_.appendChunk(name, encoded, functions.function_count);
        byte_count_ += encoded.size();
      },
      shape_);
  function_count_ += functions.function_count;
}

void ShardWriter::finish(const ShardCounts& counts) {
  NLG_CHECK(counts.functions, ==, function_count_);
  forEachArray(
      [&](const char* name, const std::vector<uint64_t>& columns, const auto& values) {
        if (isEmptyRow(columns)) file_.write(name, withRows(function_count_, columns), values.data());
      },
      shape_);
  forEachCount([&](const char* name, uint64_t count) { file_.writeAttribute(name, count); }, counts);
  file_.closeWithDigest();
}

void writeShard(const std::string& path, const Shard& shard) {
  NLG_CHECK(shard.counts.functions, ==, shard.functionCount());
  checkOwnPromises(shard);
  writeAtomically(path, [&](const std::string& temporary_path) {
    ShardWriter writer(temporary_path, shard);
    for (uint64_t first = 0; first < shard.functionCount(); first += kChunkFunctions) {
      writer.append(encodeFunctions(shard, first, std::min(kChunkFunctions, shard.functionCount() - first)));
    }
    writer.finish(shard.counts);
  });
}

}  // namespace nlg
