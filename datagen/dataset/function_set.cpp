#include "datagen/dataset/function_set.h"

#include <algorithm>
#include <unordered_set>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

void addCounts(const ShardCounts& from, ShardCounts& to) {
  to.grid_probes += from.grid_probes;
  to.visited_probes += from.visited_probes;
  to.functions += from.functions;
  to.free_space += from.free_space;
  to.in_solid += from.in_solid;
  to.duplicates += from.duplicates;
  to.empty += from.empty;
}

void appendRow(const std::vector<uint8_t>& from, uint64_t row, size_t width, std::vector<uint8_t>& to) {
  to.insert(to.end(), from.begin() + row * width, from.begin() + (row + 1) * width);
}

// What makes two functions the same: samples and validity. 256 bits stand for them.
std::string functionKey(const Shard& shard, uint64_t n) {
  const size_t points = shard.point_count;
  std::string bytes(reinterpret_cast<const char*>(&shard.phi[n * points]), points);
  bytes.append(reinterpret_cast<const char*>(&shard.validity[n * points / 8]), points / 8);
  return sha256(bytes);
}

void checkSameKind(const std::string& path, const Shard& shard, const FunctionSet& set) {
  if (shard.unseen_point_count == set.unseen_point_count) return;
  throw InputError(path, "attribute unseen_point_count", std::to_string(set.unseen_point_count) + " as in the shards before it",
                   std::to_string(shard.unseen_point_count));
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

void appendShard(const Shard& shard, std::unordered_set<std::string>& known, FunctionSet& set) {
  const size_t points = set.point_count, unseen = set.unseen_point_count;
  const uint32_t scene = sceneIndex(shard, set);
  addCounts(shard.counts, set.counts);
  for (uint64_t n = 0; n < shard.functionCount(); ++n) {
    if (!known.insert(functionKey(shard, n)).second) {
      --set.counts.functions;
      ++set.counts.duplicates;
      continue;
    }
    set.scene_idx.push_back(scene);
    appendRow(shard.phi, n, points, set.phi);
    appendRow(shard.validity, n, points / 8, set.validity);
    appendRow(shard.seen, n, points / 8, set.seen);
    appendRow(shard.phi_unseen, n, unseen, set.phi_unseen);
    appendRow(shard.validity_unseen, n, unseen / 8, set.validity_unseen);
    appendRow(shard.seen_unseen, n, unseen / 8, set.seen_unseen);
  }
}

// One growth of the arrays to their final size instead of many copies.
void reserveRows(const std::vector<std::string>& paths, uint64_t pattern_hash, FunctionSet& set) {
  uint64_t count = 0;
  for (const std::string& path : paths) {
    const Shard header = readShardHeader(path, pattern_hash);
    if (set.point_count == 0) set.point_count = header.point_count, set.unseen_point_count = header.unseen_point_count;
    count += header.counts.functions;
  }
  set.phi.reserve(count * set.point_count);
  set.validity.reserve(count * set.point_count / 8);
  set.seen.reserve(count * set.point_count / 8);
  set.phi_unseen.reserve(count * set.unseen_point_count);
}

}  // namespace

FunctionSet readFunctionSet(const std::vector<std::string>& paths, uint64_t pattern_hash) {
  if (paths.empty()) throw UsageError("shards", "at least one file", "none");
  FunctionSet set;
  set.pattern_hash = pattern_hash;
  reserveRows(paths, pattern_hash, set);
  std::unordered_set<std::string> known;
  std::string hashes;
  for (const std::string& path : paths) {
    const Shard shard = readShard(path, pattern_hash);
    checkSameKind(path, shard, set);
    appendShard(shard, known, set);
    hashes += fileSha256(path);
  }
  set.sha256 = sha256(hashes);
  return set;
}

}  // namespace nlg
