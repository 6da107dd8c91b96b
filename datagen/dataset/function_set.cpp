#include "datagen/dataset/function_set.h"

#include <algorithm>

#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"

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
    set.scene_sha256[shard.scene_id] = shard.sceneSha256();
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

constexpr uint64_t kImages = kMirrorCount;

uint64_t countOf(const std::vector<bool>& bits) { return static_cast<uint64_t>(std::count(bits.begin(), bits.end(), true)); }

}  // namespace

void addCounts(const ShardCounts& from, ShardCounts* to) {
  forEachCount([](const char*, uint64_t count, uint64_t& sum) { sum += count; }, from, *to);
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

uint64_t KnownFunctions::countInTraining() const { return countOf(in_training); }
uint64_t KnownFunctions::countInTrainingMirrored() const { return countOf(in_training_mirrored); }

KnownFunctionSearch::KnownFunctionSearch(const DuplicateRule& rule, const FunctionSet& held_out)
    : held_out_(held_out), index_(rule, held_out.point_count, [this](uint64_t id) { return image(id); }) {
  NLG_CHECK(held_out.point_count % 64, ==, 0);
  const uint64_t count = held_out.functionCount();
  known_.in_training.assign(count, false);
  known_.in_training_mirrored.assign(count, false);
  for (uint64_t id = 0; id < count * kImages; ++id) index_.add(image(id));
}

// The held-out functions are the indexed ones, since they are the fewer: id = 8 function + mirror. Whole octants change places in
// a mirror image; it is good until the next call.
StoredFunction KnownFunctionSearch::image(uint64_t id) {
  const StoredFunction function = functionAt(held_out_, id / kImages);
  const size_t mirror = id % kImages, point_count = static_cast<size_t>(held_out_.point_count);
  if (mirror == 0) return function;
  image_.resize(point_count + point_count / 8);
  uint8_t* const validity = image_.data() + point_count;
  const size_t points = point_count / kImages, bytes = points / 8;
  for (size_t octant = 0; octant < kImages; ++octant) {
    std::copy_n(function.phi + (octant ^ mirror) * points, points, image_.data() + octant * points);
    std::copy_n(function.validity + (octant ^ mirror) * bytes, bytes, validity + octant * bytes);
  }
  return {image_.data(), validity};
}

void KnownFunctionSearch::see(const StoredFunction& training) {
  // nothing is left to learn about an image of a function that is known already
  const auto isOpen = [this](uint64_t id) {
    return !(id % kImages == 0 ? known_.in_training : known_.in_training_mirrored)[id / kImages];
  };
  // a training function equals an image of a held-out one exactly when that one equals the same image of the training function:
  // every mirror is its own inverse, and the rule does not care in which order points come
  index_.forEachMatch(training, isOpen, [this](const DuplicateIndex::Match& match) {
    const uint64_t n = match.id / kImages;
    if (match.id % kImages == 0) known_.in_training[n] = true;
    known_.in_training_mirrored[n] = true;
  });
}

}  // namespace nlg
