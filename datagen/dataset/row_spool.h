// Samples of functions in a file without a name: for looking back at them without holding them in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/dataset/duplicate_rule.h"
#include "datagen/dataset/nameless_file.h"

namespace nlg {

class RowSpool {
 public:
  // point_count   P: a function takes 2 P + P/8 bytes of disk
  // throws        OutputError when no file can be made in the folder
  RowSpool(const std::string& folder, int point_count);

  // Appends a function; its number is the count of those before. throws OutputError (disk full)
  void append(const StoredFunction& function);
  // The n-th function; `samples` holds it. Any number of threads may read at once. throws OutputError when the disk fails
  StoredFunction read(uint64_t n, std::vector<uint8_t>* samples) const;

  uint64_t byteCount() const { return file_.byteCount(); }

 private:
  NamelessFile file_;
  size_t point_count_;
  std::vector<uint8_t> row_;
};

}  // namespace nlg
