#include "validate/light/asked_bakes.h"

#include <cctype>
#include <filesystem>
#include <sstream>

#include "bake/light_bake.h"
#include "bake/load_generators.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

constexpr uint64_t kMethodStream = 0x6d6574686f64;

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

GeneratorSets loadSets(const std::vector<std::string>& weights, std::map<std::string, std::string>* hashes) {
  GeneratorSets sets;
  for (const std::string& listed : weights) {
    auto [generators, paths] = loadGenerators(splitAtCommas(listed));
    std::string name;
    for (size_t g = 0; g < generators.size(); ++g) {
      const std::string representation(representationName(generators[g].representation()));
      name += (g > 0 ? " or " : "") + representation;
      (*hashes)["weights of " + representation] = fileSha256(paths[g]);
    }
    sets.emplace_back(name, std::move(generators));
  }
  return sets;
}

std::vector<std::string> weightsPaths(const std::vector<std::string>& weights) {
  std::vector<std::string> paths;
  for (const std::string& listed : weights) {
    for (const std::string& path : splitAtCommas(listed)) paths.push_back(path);
  }
  return paths;
}

MethodSetOptions methodSetOptions(const BakeOptions& options, const GatherOptions& probe, size_t place_count, int thread_count) {
  MethodSetOptions method_options;
  method_options.probe = probe;
  method_options.solve = probeLightOptions(options, place_count);
  if (options.thin_error > 0.0) method_options.thin_errors = {options.thin_error};
  method_options.light_error = options.light_error;
  method_options.theta = options.policy.theta_precision;
  method_options.thread_count = thread_count;
  method_options.seed = mixSeed(options.seed, kMethodStream);
  return method_options;
}

std::string writePicture(const Image& image, const std::string& folder, const std::string& name, const std::string& result_path,
                         const std::string& command) {
  const std::filesystem::path path = std::filesystem::path(folder) / (name + ".png");
  refuseToReplaceOthers(path.string(), kPictures, "--pictures");
  writePng(path.string(), image, {{"Software", command + " " + sourceRevision()}});
  return std::filesystem::proximate(path, std::filesystem::absolute(result_path).parent_path()).generic_string();
}

std::string fileWord(std::string text) {
  for (char& sign : text) {
    if (!std::isalnum(static_cast<unsigned char>(sign)) && sign != '_') sign = '-';
  }
  return text;
}

}  // namespace nlg
