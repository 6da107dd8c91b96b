#include "datagen/dataset/shard_writer.h"

#include "datagen/dataset/chunk_codec.h"
#include "datagen/dataset/shard.h"
#include "datagen/dataset/shard_check.h"
#include "runtime_eval/support/point_set.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

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
  NLG_CHECK(header.point_count, >=, 0);
  NLG_CHECK(header.test_point_count, >=, 0);
  const Fault fault = pointCountFault(static_cast<uint64_t>(header.point_count), static_cast<uint64_t>(header.test_point_count));
  NLG_CHECK(fault.place, ==, "");
  NLG_CHECK(duplicateRuleFault(header.duplicate_rule).place, ==, "");
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
  forEachCount(counts, [&](const char* name, uint64_t count) { file_.writeAttribute(name, count); });
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
