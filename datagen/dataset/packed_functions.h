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

  // returns   the function's place in the file. throws OutputError (disk full)
  uint64_t append(const StoredFunction& function);
  // A function by its place; good until the next call of either. throws OutputError when the disk fails
  StoredFunction at(uint64_t place);

 private:
  size_t point_count_;
  NamelessFile file_;
  std::vector<uint8_t> samples_, packed_;
};

}  // namespace nlg
