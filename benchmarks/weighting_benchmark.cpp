// Function generation, validity to diffusion: functions/s of one core over the probes of a level.
//
// NLG_LEVELS names a folder of .glb levels; without it two procedural levels stand in.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "datagen/probes/probe_grid.h"
#include "datagen/scene/gltf_reader.h"
#include "datagen/scene/procedural.h"
#include "datagen/weighting/weighting_builder.h"

namespace nlg {
namespace {

constexpr int kFunctionCount = 400;  // an iteration: a fair sample of the level's probes until so many functions are made

void build(benchmark::State& state, const Scene& scene) {
  const LinkTable links = makeLinkTable({});
  const RayScene rays(scene);
  WeightingBuilder builder(rays, links, {});
  const ProbeGrid grid = makeProbeGrid(scene, {1.5, 1.5}, 1);
  GeneratedFunction function;
  double functions = 0.0, probes = 0.0;
  for (auto _ : state) {
    ShuffledOrder order(grid.probeCount(), 1);
    uint64_t index = 0;
    for (int made = 0; made < kFunctionCount && order.next(&index); probes += 1.0) {
      if (builder.build(grid.probePosition(index), grid.spacing_m, &function) != ProbeOutcome::function) continue;
      ++made;
      functions += 1.0;
    }
  }
  state.counters["functions/s"] = benchmark::Counter(functions, benchmark::Counter::kIsRate);
  state.counters["probes/s"] = benchmark::Counter(probes, benchmark::Counter::kIsRate);
  state.counters["rays/function"] = static_cast<double>(builder.visibility().rayCount()) / functions;
}

const bool kRegistered = [] {
  const auto add = [](const std::string& name, const Scene& scene) {
    benchmark::RegisterBenchmark(("weighting/build/" + name).c_str(), [scene](benchmark::State& state) {
      build(state, scene);
    })->Unit(benchmark::kMillisecond);
  };
  add("house_3", makeProceduralScene("house", 3));
  add("cave_2", makeProceduralScene("cave", 2));
  const char* folder = std::getenv("NLG_LEVELS");
  if (folder == nullptr) return true;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".glb") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) add(path.stem(), readGltf(path));
  return true;
}();

}  // namespace
}  // namespace nlg
