// Samples of functions in a file without a name: for looking back at them without holding them in memory.
//
// The file lies in a folder of the caller's choice and is gone with the process, however that ends.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/dataset/duplicate_rule.h"

namespace nlg {

// The folder for temporary files: TMPDIR, or /tmp. throws OutputError when there is none
std::string temporaryFolder();

class RowSpool {
 public:
  // point_count   P: a function takes P + P/8 bytes of disk
  // throws        OutputError when no file can be made in the folder
  RowSpool(const std::string& folder, int point_count);
  ~RowSpool();
  RowSpool(const RowSpool&) = delete;
  RowSpool& operator=(const RowSpool&) = delete;

  // Appends a function; its number is the count of those before. throws OutputError (disk full)
  void append(const StoredFunction& function);
  // The n-th function; good until the next call. throws OutputError when the disk fails
  StoredFunction read(uint64_t n);

  uint64_t byteCount() const { return count_ * row_.size(); }

 private:
  std::string folder_;
  int file_ = -1;
  uint64_t count_ = 0;
  size_t point_count_;
  std::vector<uint8_t> row_;
};

}  // namespace nlg
