// All functions of several shards in memory, for training, export and validation.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datagen/dataset/shard.h"
#include "datagen/functions/duplicate_index.h"
#include "datagen/functions/nameless_file.h"

namespace nlg {

struct FunctionSet : FunctionRows {
  uint64_t pattern_hash = 0;
  uint64_t test_pattern_hash = 0;
  ShardCounts counts;                               // sums over the shards; duplicates include those between shards
  std::vector<std::string> scene_ids;               // distinct scenes
  std::vector<std::string> families;                // of each distinct scene
  std::map<std::string, std::string> scene_sha256;  // of each distinct scene, by its id (ShardHeader::sceneSha256)
  std::vector<uint32_t> scene_idx;                  // N, into scene_ids
  std::string sha256;                               // of the shards' hashes in the order of the paths: the data set's identity

  // also of a set made by hand, which may lack arrays that its readers do not ask for
  uint64_t functionCount() const { return scene_idx.size(); }
};

// Drops from shards what other shards hold already, by the rule that the shards themselves were made with (DuplicateRule).
//
// Exact, as DuplicateIndex says: of duplicates the first is kept. Takes 160 bytes of memory for each function that is kept, 160 MB for
// a million of them. Their deflated samples lie in the folder for temporary files (TMPDIR), about 1.2 kB each.
class DuplicateFilter {
 public:
  // earlier   gives the samples of the id-th function kept; without it a copy is kept in a file
  explicit DuplicateFilter(DuplicateIndex::Fetch earlier = nullptr) : earlier_(std::move(earlier)) {}
  DuplicateFilter(const DuplicateFilter&) = delete;
  DuplicateFilter& operator=(const DuplicateFilter&) = delete;

  // Takes the known functions out of the arrays of a shard, or of some rows of one, and moves them from counts.functions to
  // counts.duplicates.
  // throws   InputError when its rule is not that of the first; OutputError when the temporary file refuses
  void removeKnown(Shard* rows);

 private:
  void begin(const Shard& rows);
  StoredFunction samples(uint64_t id);
  bool isDuplicate(const StoredFunction& function);

  DuplicateIndex::Fetch earlier_;
  std::optional<DuplicateIndex> index_;
  std::optional<PackedFunctions> packed_;  // what was kept, where nobody else has it
  std::vector<uint64_t> places_;           // of it there, by id
  DuplicateRule rule_;
  const Shard* current_ = nullptr;
  uint64_t first_of_current_ = 0;
};

// Adds every count of `from` to `to`.
void addCounts(const ShardCounts& from, ShardCounts* to);

// Reads shards one after another; a function that duplicates one of an earlier shard is dropped and counted.
// throws   InputError as readShard does; when shards disagree in pattern or test points; when paths is empty; UsageError when two
//          shards have the same bytes: the set would have another identity than the same functions given once
FunctionSet readFunctionSet(const std::vector<std::string>& paths, uint64_t pattern_hash, int point_count = 0);

// Which held-out functions a training set holds already, as they are or mirrored.
//
// Training takes every function in its 8 mirror images (bits as in SupportPattern: point i of mirror m is index m P / 8 + i), so a
// held-out function that equals an image of a training function has been trained on as well. Exact, as DuplicateIndex says.
//
// One bit a held-out function, in the order of their set.
struct KnownFunctions {
  std::vector<bool> in_training;           // by the rule, a duplicate of a training function
  std::vector<bool> in_training_mirrored;  // of a training function or of one of its mirror images; holds all of in_training

  uint64_t countInTraining() const;
  uint64_t countInTrainingMirrored() const;
};

// Holds the sketches of all held-out functions in 8 images each (about 1.3 kB a function), and lets training functions pass by.
class KnownFunctionSearch {
 public:
  // held_out   must outlive the search; its points a multiple of 64
  KnownFunctionSearch(const DuplicateRule& rule, const FunctionSet& held_out);
  KnownFunctionSearch(const KnownFunctionSearch&) = delete;
  KnownFunctionSearch& operator=(const KnownFunctionSearch&) = delete;

  // A training function, of as many points as the held-out ones.
  void see(const StoredFunction& training);

  const KnownFunctions& known() const { return known_; }

 private:
  StoredFunction image(uint64_t id);

  const FunctionSet& held_out_;
  std::vector<uint8_t> image_;  // samples of the latest one
  DuplicateIndex index_;
  KnownFunctions known_;
};

}  // namespace nlg
