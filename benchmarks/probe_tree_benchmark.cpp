// The probe tree: look-ups/s of one core, and the time to place a level's probes.
//
// The level is hilly ground of 100,352 triangles with a finest spacing of 1 m: on 60 m every triangle is smaller than a cell, on
// 300 m there are 1.5 million probes. "walk" looks up along straight lines in steps of 5 cm, as a moving object does; "scattered"
// jumps from cell to cell of the whole tree, which measures the memory.

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "datagen/probes/probe_placement.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr int kPositionCount = 1 << 16;

Scene hillyGround(float side_m) {
  constexpr uint32_t kSteps = 224;
  Scene scene;
  scene.id = "hilly ground";
  for (uint32_t z = 0; z <= kSteps; ++z) {
    for (uint32_t x = 0; x <= kSteps; ++x) {
      const float u = float(x) / kSteps - 0.5f, v = float(z) / kSteps - 0.5f;
      scene.positions.push_back({side_m * u, 0.03f * side_m * std::sin(23.0f * u) * std::cos(29.0f * v), side_m * v});
    }
  }
  for (uint32_t z = 0; z < kSteps; ++z) {
    for (uint32_t x = 0; x < kSteps; ++x) {
      const uint32_t a = z * (kSteps + 1) + x, b = a + kSteps + 1;
      scene.triangles.push_back({a, b, a + 1});
      scene.triangles.push_back({a + 1, b, b + 1});
    }
  }
  return scene;
}

ProbePlacementOptions metreSpacing() { return {.spacing_min_m = 1.0, .spacing_max_m = 1.0}; }

void place(benchmark::State& state) {
  const Scene scene = hillyGround(static_cast<float>(state.range(0)));
  size_t probes = 0, bytes = 0;
  for (auto _ : state) {
    const ProbeTree tree = placeProbes(scene, metreSpacing(), 1);
    probes = tree.probeCount();
    bytes = tree.byteCount();
  }
  state.counters["probes"] = static_cast<double>(probes);
  state.counters["bytes/probe"] = static_cast<double>(bytes) / static_cast<double>(probes);
}
BENCHMARK(place)->Name("probe_tree/place/ground_m")->Arg(60)->Arg(300)->Unit(benchmark::kMillisecond);

PositionM inCell(const ProbeTree& tree, const ProbeCell& cell, Random& random) {
  PositionM position_m;
  for (int axis = 0; axis < 3; ++axis)
    position_m[axis] = tree.frame().first_m[axis] + tree.frame().spacing_m * (cell.low[axis] + cell.side * random.uniform());
  return position_m;
}

std::vector<PositionM> scattered(const ProbeTree& tree) {
  std::vector<ProbeCell> cells;
  tree.forEachCell([&](const ProbeCell& cell) { cells.push_back(cell); });
  Random random(1);
  std::vector<PositionM> positions;
  for (int i = 0; i < kPositionCount; ++i)
    positions.push_back(inCell(tree, cells[random.below(static_cast<uint32_t>(cells.size()))], random));
  return positions;
}

std::vector<PositionM> walk(const ProbeTree& tree) {
  constexpr int kSteps = 256;
  const std::vector<PositionM> starts = scattered(tree);
  std::vector<PositionM> positions;
  for (int i = 0; i < kPositionCount; ++i) {
    PositionM position_m = starts[static_cast<size_t>(i / kSteps)];
    position_m[i / kSteps % 2 == 0 ? 0 : 2] += 0.05 * (i % kSteps);
    positions.push_back(position_m);
  }
  return positions;
}

template <class Positions>
void lookUp(benchmark::State& state, const Positions& positionsFor) {
  const ProbeTree tree = placeProbes(hillyGround(static_cast<float>(state.range(0))), metreSpacing(), 1);
  const std::vector<PositionM> positions = positionsFor(tree);
  ProbesAround around;
  int64_t found = 0;
  for (auto _ : state) {
    for (const PositionM& position_m : positions) found += tree.lookUp(position_m, &around);
    benchmark::DoNotOptimize(around);
  }
  state.SetItemsProcessed(state.iterations() * kPositionCount);
  state.counters["inside"] = static_cast<double>(found) / static_cast<double>(state.iterations() * kPositionCount);
}
BENCHMARK_CAPTURE(lookUp, walk, walk)->Name("probe_tree/look_up_walk/ground_m")->Arg(60)->Arg(300);
BENCHMARK_CAPTURE(lookUp, scattered, scattered)->Name("probe_tree/look_up_scattered/ground_m")->Arg(60)->Arg(300);

}  // namespace
}  // namespace nlg
