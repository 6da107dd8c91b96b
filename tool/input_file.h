// Reads input files of tools, with errors that name the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "nlg/result.h"

namespace nlg {

class InputError;
// Why a file could not be opened: in plain words where there is none of that name.
// path, place   that the error names; fault: of openRegularFile
InputError notOpened(const std::string& path, const std::string& place, const std::string& fault);

// Whoever asks for a file by other means than InputFile says so here.
void noteInput(const std::string& path);
// The paths of all files that this process has asked for so far, sorted: those that it could not open, too.
std::vector<std::string> inputsSoFar();
// What --inputs and the environment's NLG_INPUTS (tool_main.h) write: names of files, sorted, as a list of JSON in one line. Of a name that is no UTF-8 each byte is a character, behind
// U+0001.
std::string inputsText(const std::vector<std::string>& paths);
// The inverse.
std::vector<std::string> inputsOf(const std::string& text);

// Open from beginning to end of its life. Regular files only: regular_file.h says why.
class InputFile {
 public:
  // place    what the file is to its reader ("open", "buffer \"walls.bin\""), for errors
  // throws   InputError with what stands at the path instead, or the system's reason
  explicit InputFile(const std::string& path, std::string place = "open");
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  // Bytes that the file had when it was opened.
  uint64_t size() const { return size_; }
  int descriptor() const { return descriptor_; }

  // Fills `to` with the next bytes; returns how many: fewer than count at the file's end only.
  // throws   InputError with the system's reason
  size_t read(void* to, size_t count);
  // The same from `offset` bytes behind the beginning; where read() goes on stays.
  size_t readAt(uint64_t offset, void* to, size_t count) const;

 private:
  const std::string path_, place_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
};

// Files that are given together, no two of which may be the same thing: two weights of one representation, one shard twice.
class OneFileEach {
 public:
  // flag   what the files are given with: "--weights"; kind: what each of them is the only one of: "representation"
  OneFileEach(std::string flag, std::string kind);

  // what     the file's own: "tent_mlp"
  // throws   UsageError naming flag, `what` and both files when an earlier file was the same
  void add(const std::string& path, const std::string& what);

 private:
  std::string flag_, kind_;
  std::map<std::string, std::string> path_of_;
};

// Returns when the file was read, weights or a light grid. Of one that names no digest it says so (sayUnchecked).
// expected   what the file should have been: "a light grid"
// throws     InputError with the result's status and detail; DamageError where the file's own bytes prove that it is damaged
void requireRead(const std::string& path, const FileResult& result, const std::string& expected);

// Says on stderr, once a process, that nobody knows whether a file is damaged.
// line   the file's path, and why
void sayUnchecked(const std::string& line);

}  // namespace nlg
