#include "tool/output_path.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "tool/error.h"

namespace nlg {

void refuseToReplaceInputs(const std::string& out, const std::vector<std::string>& inputs) {
  if (out.empty()) throw UsageError("--out", "the name of a file", "an empty text");
  for (const std::string& input : inputs) {
    std::error_code error;
    if (std::filesystem::equivalent(out, input, error)) throw UsageError("--out", "a file that is no input", out);
  }
}

void requireOutputFolder(const std::string& out) {
  if (out.empty()) throw UsageError("--out", "the name of a folder", "an empty text");
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path there = fs::absolute(out);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  if (!fs::is_directory(there, error)) throw OutputError(out, std::make_error_code(std::errc::not_a_directory).message());
  if (access(there.c_str(), W_OK | X_OK) != 0) throw OutputError(out, std::error_code(errno, std::generic_category()).message());
}

}  // namespace nlg
