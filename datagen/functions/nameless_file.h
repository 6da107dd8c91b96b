// A temporary file without a name, which disappears with the process, however that ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "datagen/functions/duplicate_index.h"
#include "datagen/functions/function_rows.h"

namespace nlg {

// The folder for temporary files: TMPDIR, or /tmp. throws OutputError when there is none
std::string temporaryFolder();

class NamelessFile {
 public:
  // folder    of an existing file system with room
  // purpose   what the bytes are, for messages: "samples of functions, for comparison"
  // throws    OutputError when no file can be made there
  NamelessFile(const std::string& folder, const std::string& purpose);
  ~NamelessFile();
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  // throws OutputError (disk full)
  void append(const void* bytes, size_t count);
  // Bytes [first, first + count), which have been appended. throws OutputError when the disk fails
  void read(uint64_t first, void* bytes, size_t count) const;

  uint64_t byteCount() const { return byte_count_; }

 private:
  [[noreturn]] void fail(int error_number) const;

  std::string place_;
  int file_ = -1;
  uint64_t byte_count_ = 0;
};

// Samples of functions, put aside one by one and looked at again: deflated, in a nameless file. About 1.2 kB a function of levels.
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

// Samples of functions in a file without a name: for looking back at them without holding them in memory.
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
