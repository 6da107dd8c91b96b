// Look-ups in a light grid: weights of the 8 probes around a position, look-ups/s of one core.
//
// 18,513 probes with a function of their own each: theta is 8 MB for the networks, 19 MB for pf5. "walk" goes along straight
// lines in steps of 5 cm at 1 m between probes, as a moving object does; "scattered" jumps, which measures the memory.

#include <benchmark/benchmark.h>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/light_grid/light_grid.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr int kPositionCount = 1 << 14;

// 32 x 16 x 32 cells of 4 units, 1 m a side.
ProbeTree uniformTree() {
  ProbeTree tree;
  const auto judge = [](const ProbeCell& cell) { return cell.side > 4 ? CellVerdict::too_coarse : CellVerdict::fits; };
  ProbeTree::build({{0.0, 0.0, 0.0}, 0.25, {2, 1, 2}}, judge, kMaxTreeProbes, &tree);
  return tree;
}

LightGrid gridOf(const Representation& representation) {
  LightGrid grid;
  grid.tree = uniformTree();
  grid.representations = {representation};
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe)
    grid.probe_function.push_back(grid.addFunction(0, randomTheta(representation, probe).data()));
  return grid;
}

LightGrid freeGrid() {
  LightGrid grid;
  grid.tree = uniformTree();
  grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  return grid;
}

std::vector<PositionM> scattered() {
  Random random(1);
  std::vector<PositionM> positions;
  for (int i = 0; i < kPositionCount; ++i)
    positions.push_back({random.uniform(0.0, 32.0), random.uniform(0.0, 16.0), random.uniform(0.0, 32.0)});
  return positions;
}

std::vector<PositionM> walk() {
  constexpr int kSteps = 256;  // 12.8 m
  Random random(2);
  std::vector<PositionM> positions;
  for (int i = 0; i < kPositionCount / kSteps; ++i) {
    const PositionM first{random.uniform(0.0, 19.0), random.uniform(0.0, 16.0), random.uniform(0.0, 32.0)};
    for (int step = 0; step < kSteps; ++step) positions.push_back({first[0] + 0.05 * step, first[1], first[2]});
  }
  return positions;
}

void lookUp(benchmark::State& state, const LightGrid& grid, const std::vector<PositionM>& positions) {
  ProbeWeights weights;
  int64_t probes = 0;
  for (auto _ : state) {
    for (const PositionM& position_m : positions) {
      lookUpWeights(grid, position_m, &weights);
      probes += weights.count;
    }
    benchmark::DoNotOptimize(weights);
  }
  state.SetItemsProcessed(state.iterations() * kPositionCount);
  state.counters["probes/look_up"] = static_cast<double>(probes) / static_cast<double>(state.iterations() * kPositionCount);
}

const bool kRegistered = [] {
  for (const char* name : {"mlp", "tent_mlp", "pf5", "free_space"}) {
    for (const bool is_walk : {true, false}) {
      benchmark::RegisterBenchmark(
          ("light_grid/look_up/" + std::string(name) + (is_walk ? "/walk" : "/scattered")).c_str(), [=](benchmark::State& state) {
            Representation representation;
            const bool has_functions = findRepresentation(name, &representation);
            lookUp(state, has_functions ? gridOf(representation) : freeGrid(), is_walk ? walk() : scattered());
          });
    }
  }
  return true;
}();

}  // namespace
}  // namespace nlg
