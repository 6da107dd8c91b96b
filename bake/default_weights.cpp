#include "bake/default_weights.h"

#include <fmt/ranges.h>

#include <cstdlib>
#include <filesystem>

#include "nlg/representation.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

std::string joined(const std::vector<std::string>& texts) { return fmt::format("{}", fmt::join(texts, ", ")); }

}  // namespace

std::vector<std::string> weightsFolders() {
  const char* chosen = std::getenv("NLG_WEIGHTS");
  if (chosen != nullptr && *chosen != '\0') return {chosen};
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};  // without /proc
  return {(program.parent_path() / NLG_INSTALLED_WEIGHTS).lexically_normal().string()};
}

std::vector<std::string> shippedWeights(const std::vector<std::string>& representations,
                                        const std::vector<std::string>& folders) {
  if (representations.empty()) throw UsageError("representation", "at least one of " + representationNames(), "none");
  std::vector<std::string> names;
  for (const std::string& name : representations) {
    Representation representation;
    if (!findRepresentation(name, &representation)) throw UsageError("representation", representationNames(), "'" + name + "'");
    names.push_back(name + ".safetensors");
  }
  for (const std::string& folder : folders) {
    std::vector<std::string> found, missing;
    for (const std::string& name : names) {
      const std::string path = (fs::path(folder) / name).string();
      std::error_code error;
      noteInput(path);
      (fs::is_regular_file(path, error) ? found : missing).push_back(path);
    }
    if (missing.empty()) return found;
    if (!found.empty()) throw UsageError("--weights", joined(names) + " in " + folder, "no " + joined(missing));
  }
  throw UsageError("--weights", "weights of nlg-export, or the shipped " + joined(names) + " in " + joined(folders), "none");
}

}  // namespace nlg
