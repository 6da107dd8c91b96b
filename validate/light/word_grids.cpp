#include "validate/light/word_grids.h"

#include <memory>

#include "runtime_eval/support/weighting_function.h"
#include "tool/atomic_file.h"

namespace nlg {

std::vector<WordGrid> wordGrids(const BakeScene& scene, const Generator& generator, const BakeOptions& options,
                                int thread_count) {
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
      return [&all, trace] {
        for (const auto word : {&ThetaTrace::network, &ThetaTrace::corrected, &ThetaTrace::fitted})
          (all.*word).insert((all.*word).end(), ((*trace).*word).begin(), ((*trace).*word).end());
      };
    };
  });

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
