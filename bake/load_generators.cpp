#include "bake/load_generators.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <fmt/ranges.h>

#include "nlg/representation.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

std::string joined(const std::vector<std::string>& texts) { return fmt::format("{}", fmt::join(texts, ", ")); }

}  // namespace

LoadedGenerators loadGenerators(const std::vector<std::string>& paths) {
  LoadedGenerators loaded;
  OneFileEach given("--weights", "representation");
  for (const std::string& path : paths) {
    Generator generator;
    noteInput(path);
    requireRead(path, Generator::load(path, &generator), "the weights of a generator");
    given.add(path, representationName(generator.representation()));
    const int parameters = generator.representation().thetaCount();
    // the smallest first: larger ones run where it is not enough
    const auto after = std::find_if(loaded.generators.begin(), loaded.generators.end(),
                                    [&](const Generator& other) { return other.representation().thetaCount() > parameters; });
    loaded.paths.insert(loaded.paths.begin() + (after - loaded.generators.begin()), path);
    loaded.generators.insert(after, std::move(generator));
  }
  return loaded;
}

std::vector<std::string> weightsFolders() {
  const char* chosen = std::getenv("NLG_WEIGHTS");
  fs::path folder = chosen != nullptr ? chosen : "";
  if (folder.empty()) {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (error) return {};  // without /proc
    folder = (program.parent_path() / NLG_INSTALLED_WEIGHTS).lexically_normal();
  }
  return {folder.string()};
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
  // all from one folder, so that weights of two versions do not mix
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
