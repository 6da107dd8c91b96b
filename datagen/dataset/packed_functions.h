// Samples of functions, put aside one by one and looked at again: deflated, in a nameless file. About 1.2 kB a function of levels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/dataset/nameless_file.h"
#include "datagen/dataset/shard.h"

namespace nlg {

class PackedFunctions {
 public:
  // point_count   of each function
  // folder        for the file; throws OutputError as NamelessFile does
  PackedFunctions(int point_count, const std::string& folder);

  // throws OutputError (disk full)
  void append(const StoredFunction& function);
  // The id-th of those appended; good until the next call of either. throws OutputError when the disk fails
  StoredFunction at(uint64_t id);

 private:
  size_t point_count_;
  NamelessFile file_;
  std::vector<uint64_t> ends_;  // of each function's bytes
  std::vector<uint8_t> samples_, packed_;
};

}  // namespace nlg
