#include "datagen/info.h"
#include "datagen/shards/counts_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/shard_reader.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/file_info.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kPieceFunctions = 1024;  // about 10 MB at a time

// What only a look at all functions tells.
struct Statistics {
  uint64_t open_shell = 0, few_seen = 0, in_solid = 0;
  float spacing_min_m = std::numeric_limits<float>::infinity(), spacing_max_m = 0.0f;
};

void requireCountsThatAddUp(const ShardHeader& header) {
  const ShardCounts& c = header.counts;
  const uint64_t sum = c.functions + c.free_space + c.in_solid + c.duplicates + c.empty;
  if (sum == c.visited_probes && c.visited_probes <= c.grid_probes) return;
  throw InputError(header.path, "attribute count_visited_probes",
                   fmt::format("{}, what the probes' outcomes add up to, of {} probes", sum, c.grid_probes),
                   std::to_string(c.visited_probes));
}

void addTo(const FunctionRows& piece, Statistics& statistics) {
  for (const uint8_t flags : piece.flags) {
    statistics.open_shell += (flags & kFlagOpenShell) != 0;
    statistics.few_seen += (flags & kFlagFewSeen) != 0;
    statistics.in_solid += (flags & kFlagInSolid) != 0;
  }
  for (const float spacing_m : piece.spacing_m) {
    statistics.spacing_min_m = std::min(statistics.spacing_min_m, spacing_m);
    statistics.spacing_max_m = std::max(statistics.spacing_max_m, spacing_m);
  }
}

Statistics verify(const ShardReader& reader) {
  requireCountsThatAddUp(reader.header());
  reader.verifyDigest();
  Statistics statistics;
  DuplicateFilter filter;
  for (uint64_t first = 0; first < reader.functionCount(); first += kPieceFunctions) {
    Shard piece = reader.read(first, std::min(kPieceFunctions, reader.functionCount() - first));
    addTo(piece, statistics);
    const uint64_t count = piece.functionCount();
    filter.removeKnown(&piece);
    if (piece.functionCount() == count) continue;
    throw InputError(reader.header().path, fmt::format("functions {} to {}", first, first + count - 1),
                     "no duplicates of each other or of earlier ones", fmt::format("{} of them", count - piece.functionCount()));
  }
  return statistics;
}

Json shardJson(const ShardReader& reader, const Statistics& statistics) {
  const Shard& s = reader.header();
  const ShardCounts& c = s.counts;
  const double functions = static_cast<double>(std::max<uint64_t>(c.functions, 1));
  Json json = {{"schema_version", kShardVersion}, {"scene", s.scene_id}, {"family", s.family}, {"jitter", s.jitter}};
  json.update(countsJson(c));
  json.update({{"duplicate_rms", s.duplicate_rule.rms},
               {"duplicate_validity_points", s.duplicate_rule.validity_points},
               {"flagged_open_shell", statistics.open_shell},
               {"flagged_few_seen", statistics.few_seen},
               {"flagged_in_solid", statistics.in_solid},
               {"spacing_min_m", c.functions > 0 ? statistics.spacing_min_m : 0.0f},
               {"spacing_max_m", statistics.spacing_max_m},
               {"points", s.point_count},
               {"test_points", s.test_point_count},
               {"pattern_hash", fmt::format("{:016x}", s.pattern_hash)},
               {"test_pattern_hash", fmt::format("{:016x}", s.test_pattern_hash)},
               {"bytes_per_function", static_cast<double>(std::filesystem::file_size(s.path)) / functions},
               {"verified", kVerifiedByDigest},
               {"origin", parsedOrText(s.provenance_json)}});
  return json;
}

// Whether a file that was refused is proven damaged: throws DamageError when its bytes break HDF5's own structure, a checksum or the
// digest, and returns when they do not (a sound file of another kind, version or pattern).
// throws   InputError with the system's reason when the system does not give every byte: that proves nothing
void refuseDamage(const std::string& path) {
  fileSha256(path);
  try {
    Hdf5Reader(path).verifyDigest();
  } catch (const DamageError&) {
    throw;
  } catch (const InputError&) {
    // no digest: a stranger's file
  }
}

}  // namespace

Json describeShard(const std::string& path) {
  try {
    const ShardReader reader(path);
    return shardJson(reader, verify(reader));
  } catch (const InputError&) {
    refuseDamage(path);
    throw;
  }
}

}  // namespace nlg
