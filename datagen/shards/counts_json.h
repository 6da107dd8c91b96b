// A shard's counts as the tool's results name them.
#pragma once

#include <cstring>

#include <nlohmann/json.hpp>

#include "datagen/dataset/shard_fields.h"

namespace nlg {

// grid_probes, visited_probes, functions, … as docs/reference/formats.md lists them, without their prefix; then functions_per_probe.
inline nlohmann::ordered_json countsJson(const ShardCounts& counts) {
  nlohmann::ordered_json json;
  forEachCount(counts, [&](const char* name, uint64_t count) { json[name + std::strlen("count_")] = count; });
  json["functions_per_probe"] = functionsPerProbe(counts);
  return json;
}

}  // namespace nlg
