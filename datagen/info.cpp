#include "datagen/info.h"
#include "datagen/shards/counts_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/shard_reader.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

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
  const uint64_t bytes = std::filesystem::file_size(s.path);
  const Json origin = Json::parse(s.provenance_json, nullptr, false);
  Json json = {
      {"file", s.path}, {"schema_version", s.schema_version}, {"scene", s.scene_id}, {"family", s.family}, {"jitter", s.jitter}};
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
               {"bytes", bytes},
               {"bytes_per_function", static_cast<double>(bytes) / functions},
               {"sha256", fileSha256(s.path)},
               {"verified", s.schema_version >= 2 ? "every byte (SHA-256)" : "checksums of arrays (version 1 has no SHA-256)"},
               {"origin", origin.is_discarded() ? Json(s.provenance_json) : origin}});
  return json;
}

void print(const Json& shard) {
  for (const auto& [key, value] : shard.items()) {
    if (key == "origin" && value.is_object()) {
      for (const auto& [name, part] : value.items())
        std::cout << fmt::format("  {:<26}{}\n", name, part.is_string() ? part.get<std::string>() : part.dump());
    } else if (key == "file") {
      std::cout << fmt::format("{}\n", value.get<std::string>());
    } else {
      std::cout << fmt::format("  {:<26}{}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

void describe(const std::string& path, const InfoRequest& request) {
  const ShardReader reader(path);
  const Statistics statistics = verify(reader);
  if (request.quiet) return;
  const Json shard = shardJson(reader, statistics);
  if (request.json)
    std::cout << shard.dump() << '\n';
  else
    print(shard);
}

// Whether a file that was refused is proven damaged: throws DamagedShard with the refusal's words when its bytes break HDF5's own
// structure, a checksum or the digest, and returns when they do not (a sound file of another kind, version or pattern).
// throws   InputError with the system's reason when the system does not give every byte: that proves nothing
void refuseDamage(const std::string& path, const InputError& refusal) {
  fileSha256(path);
  if (dynamic_cast<const DamageError*>(&refusal) != nullptr) throw DamagedShard(refusal.what());
  try {
    Hdf5Reader(path).verifyDigest();
  } catch (const DamageError&) {
    throw DamagedShard(refusal.what());
  } catch (const InputError&) {
    // no digest: a stranger's file, or a shard of version 1
  }
}

}  // namespace

void describeShards(const InfoRequest& request) {
  for (const std::string& path : request.paths) {
    try {
      describe(path, request);
    } catch (const InputError& refusal) {
      refuseDamage(path, refusal);
      throw;
    }
  }
}

}  // namespace nlg
