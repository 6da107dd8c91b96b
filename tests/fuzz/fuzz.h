// What the fuzz targets share. A target is the three functions below; fuzz_main.cpp makes a program of them:
//
//     X_fuzz OPTIONS FOLDERS      as libFuzzer has it
//     X_fuzz --seeds FOLDER       writes the inputs to start from
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

// Aborts, which libFuzzer takes for a finding.
#define FUZZ_CHECK(condition, text) \
  ((condition) ? void() : (std::fprintf(stderr, "%s does not hold: %s\n", #condition, std::string(text).c_str()), std::abort()))

namespace nlg::fuzz {

// --- what a target defines

// Reads hostile bytes, and checks whatever its reader promises by FUZZ_CHECK. An exception that leaves it is a finding.
void readOne(std::string_view bytes);

// The inputs to start from, by name.
using Seeds = std::vector<std::pair<std::string, std::string>>;
Seeds seeds();

// Another input made of this one, of at most max_size bytes.
std::string mutated(std::string bytes, size_t max_size, Random& random);

// --- what it may use for that

// libFuzzer's own mutations, blind to what the bytes mean.
std::string mutatedBlindly(std::string bytes, size_t max_size);

// A text with one number changed to a neighbour or a limit, or with one number or quoted text in the place of another. Blind
// mutations hardly ever change a number of a text and leave it a text.
std::string mutatedText(const std::string& text, Random& random);

// One of the two, each as often.
std::string mutatedTextOrBlindly(std::string bytes, size_t max_size, Random& random);

// Whether read() takes its input. What it refuses has to be the fault of who made the file. tool_main.cpp makes one short line of it.
template <class Read>
bool isTaken(const Read& read) {
  try {
    read();
    return true;
  } catch (const ToolError& error) {
    const std::string line = error.what();
    FUZZ_CHECK(error.exitCode() == ExitCode::input_error || error.exitCode() == ExitCode::usage_error, line);
    return false;
  }
}

// A file of this process for readers that take no bytes, in the folder for temporary files: run.sh makes that one in memory. Every
// write replaces what it held.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& name);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void write(std::string_view bytes) const;
  void overwrite(uint64_t first, std::string_view bytes) const;
  std::string read() const;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace nlg::fuzz
