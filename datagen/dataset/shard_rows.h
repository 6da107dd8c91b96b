// Samples of single functions out of many shards, read back when they are asked for: nothing of them is kept on the side.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "datagen/dataset/shard_reader.h"

namespace nlg {

class ShardRows {
 public:
  // paths   the shards, by whose place in the list functions are asked for
  explicit ShardRows(std::vector<std::string> paths) : paths_(std::move(paths)) {}

  // A function of a shard; good until the next call. Reads the chunk that holds it, unless that is among those read last.
  // throws   InputError as ShardReader does
  StoredFunction at(uint32_t shard, uint64_t row);

 private:
  static constexpr size_t kOpenShards = 64, kChunks = 256;  // 256 chunks of 8192 points: 90 MB

  // What was used last stands first; what was used longest ago goes.
  template <class Value>
  struct Recent {
    std::list<std::pair<uint64_t, Value>> entries;
    std::unordered_map<uint64_t, typename std::list<std::pair<uint64_t, Value>>::iterator> places;

    template <class Make>
    Value& get(uint64_t key, size_t most, const Make& make) {
      const auto found = places.find(key);
      if (found != places.end()) {
        entries.splice(entries.begin(), entries, found->second);
        return entries.front().second;
      }
      Value made = make();
      if (entries.size() == most) {
        places.erase(entries.back().first);
        entries.pop_back();
      }
      entries.emplace_front(key, std::move(made));
      places[key] = entries.begin();
      return entries.front().second;
    }
  };

  std::vector<std::string> paths_;
  Recent<std::unique_ptr<ShardReader>> open_;
  Recent<Shard> chunks_;
};

}  // namespace nlg
