#include "tool/output_path.h"

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

}  // namespace nlg
