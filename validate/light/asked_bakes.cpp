#include "validate/light/asked_bakes.h"

#include <cctype>
#include <memory>
#include <sstream>

#include "bake/light_bake.h"
#include "bake/load_generators.h"
#include "bake/scene_functions.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/policy/stage_runner.h"
#include "runtime_eval/support/weighting_function.h"
#include "tool/atomic_file.h"

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

std::string fileWord(std::string text) {
  for (char& sign : text) {
    if (!std::isalnum(static_cast<unsigned char>(sign)) && sign != '_') sign = '-';
  }
  return text;
}

std::vector<WordGrid> wordGrids(const PreparedScene& scene, const Generator& generator, const BakeOptions& options,
                                int thread_count) {
  // the bake's policy, its thetas kept at each stage
  ThetaTrace all;  // of all functions; each takes a theta, because those that the bare tent is enough for are none of the scene's
  SceneFunctions functions(scene, options, thread_count, temporaryFolder());
  functions.makeAll([&](int) {
    const auto policy = std::make_shared<ThetaPolicy>(std::vector<const Generator*>{&generator}, options.policy);
    return [&all, policy](const FunctionRows& chunk) -> std::function<void()> {
      std::vector<StoredFunction> stored;
      for (uint64_t n = 0; n < chunk.functionCount(); ++n) stored.push_back(storedFunction(chunk, n));
      std::vector<MadeTheta> made(stored.size());
      auto trace = std::make_shared<ThetaTrace>();
      policy->bake(stored.data(), static_cast<int>(stored.size()), made.data(), trace.get());
      // threads make thetas, and what they return appends them
      return [&all, trace] {
        for (const auto word : {&ThetaTrace::network, &ThetaTrace::corrected, &ThetaTrace::fitted})
          (all.*word).insert((all.*word).end(), ((*trace).*word).begin(), ((*trace).*word).end());
      };
    };
  });

  // one grid a stage on the same tree: they differ in theta alone
  LightGrid bare;
  bare.tree = scene.treeInWorld();
  bare.probe_function = functions.probeFunction();
  bare.representations = {generator.representation()};
  const auto theta_count = static_cast<size_t>(generator.representation().thetaCount());
  std::vector<WordGrid> grids;
  for (const auto& [word, theta] :
       {std::pair(ThetaWord::network, &all.network), {ThetaWord::corrected, &all.corrected}, {ThetaWord::fitted, &all.fitted}}) {
    LightGrid& grid = grids.emplace_back(WordGrid{word, bare}).grid;
    for (size_t at = 0; at < theta->size(); at += theta_count) grid.addFunction(0, &(*theta)[at]);
  }
  return grids;
}

}  // namespace nlg
