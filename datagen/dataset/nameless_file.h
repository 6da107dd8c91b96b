// A file without a name: bytes that are put aside and looked at again, and are gone with the process, however that ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

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

}  // namespace nlg
