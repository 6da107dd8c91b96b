#include "datagen/dataset/function_set.h"

#include <algorithm>

#include "datagen/dataset/shard_fields.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/one_file_each.h"

namespace nlg {
namespace {

// Every shard must be of the first one's kind: same points, and the same points that no fit sees.
void checkSameKind(const std::string& path, const Shard& shard, const FunctionSet& set) {
  const auto require = [&](const char* attribute, uint64_t expected, uint64_t got) {
    if (expected == got) return;
    throw InputError(path, std::string("attribute ") + attribute, std::to_string(expected) + " as in the first shard",
                     std::to_string(got));
  };
  require("pattern_hash", set.pattern_hash, shard.pattern_hash);
  require("point_count", set.point_count, shard.point_count);
  require("test_point_count", set.test_point_count, shard.test_point_count);
  require("test_pattern_hash", set.test_pattern_hash, shard.test_pattern_hash);
}

uint32_t sceneIndex(const Shard& shard, FunctionSet& set) {
  const auto found = std::find(set.scene_ids.begin(), set.scene_ids.end(), shard.scene_id);
  const auto index = static_cast<uint32_t>(found - set.scene_ids.begin());
  if (found == set.scene_ids.end()) {
    set.scene_ids.push_back(shard.scene_id);
    set.families.push_back(shard.family);
  }
  return index;
}

void appendShard(const Shard& shard, FunctionSet& set) {
  const uint32_t scene = sceneIndex(shard, set);
  addCounts(shard.counts, &set.counts);
  set.scene_idx.insert(set.scene_idx.end(), shard.functionCount(), scene);
  appendRows(shard, 0, shard.functionCount(), &set);
}

// Checks the headers against the first one, and takes the memory of all functions at once.
void prepare(const std::vector<std::string>& paths, uint64_t pattern_hash, int point_count, FunctionSet& set) {
  uint64_t count = 0;
  for (const std::string& path : paths) {
    const Shard header = readShardHeader(path, pattern_hash, point_count);
    if (&path == &paths.front()) {
      set.pattern_hash = header.pattern_hash;
      set.test_pattern_hash = header.test_pattern_hash;
      set.point_count = header.point_count;
      set.test_point_count = header.test_point_count;
    }
    checkSameKind(path, header, set);
    count += header.counts.functions;
  }
  reserveRows(count, &set);
}

}  // namespace

void addCounts(const ShardCounts& from, ShardCounts* to) {
  to->grid_probes += from.grid_probes;
  to->visited_probes += from.visited_probes;
  to->functions += from.functions;
  to->free_space += from.free_space;
  to->in_solid += from.in_solid;
  to->duplicates += from.duplicates;
  to->empty += from.empty;
  to->solid_functions += from.solid_functions;
}

FunctionSet readFunctionSet(const std::vector<std::string>& paths, uint64_t pattern_hash, int point_count) {
  if (paths.empty()) throw InputError("shards", "files", "at least one", "none");
  FunctionSet set;
  prepare(paths, pattern_hash, point_count, set);
  DuplicateFilter filter([&](uint64_t id) { return functionAt(set, id); });
  std::string hashes;
  OneFileEach given("shards", "content");
  for (const std::string& path : paths) {
    Shard shard = readShard(path, pattern_hash, point_count);
    filter.removeKnown(&shard);
    appendShard(shard, set);
    const std::string hash = fileSha256(path);
    given.add(path, "SHA-256 " + hash);
    hashes += hash;
  }
  set.sha256 = sha256(hashes);
  return set;
}

}  // namespace nlg
