// Look-ups in a light grid up to irradiance: look-ups/s of one core, one at a time and batched, beside the weights alone.
//
// 18,513 probes with a function and light of their own each: theta is 8 MB for the large networks,
// 19 MB for pf5, light 2 MB. "walk" goes along straight lines in steps of 5 cm at 1 m between probes, as a moving object or a row
// of a texture does; "scattered" jumps. Normals are all different. With NLG_GRID=FILE the same of a level's grid with light, as
// nlg-bake writes it: positions in its cells, each cell as likely as any other.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "nlg/look_up.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/sample_dictionary.h"

namespace nlg {
namespace {

constexpr int kPositionCount = 1 << 14;

// 32 x 16 x 32 cells of 4 units, 1 m a side.
LightGrid gridOf(const Representation& representation) {
  LightGrid grid;
  const auto judge = [](const ProbeCell& cell) { return cell.side > 4 ? CellVerdict::too_coarse : CellVerdict::fits; };
  ProbeTree::build({{0.0, 0.0, 0.0}, 0.25, {2, 1, 2}}, judge, kMaxTreeProbes, &grid.tree);
  grid.representations = {representation};
  Random random(3);
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    grid.probe_function.push_back(grid.addFunction(0, randomTheta(representation, probe).data()));
    for (int i = 0; i < kShFloats; ++i)
      grid.light.push_back(static_cast<float>(random.uniform(i < kShChannels ? 1.0 : -0.3, 1.0)));
  }
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

// In cells of a level; `steps` along a line one after another, as far as cells go.
std::vector<PositionM> inCells(const ProbeTree& tree, int steps) {
  constexpr double kStepM = 0.05;
  std::vector<ProbeCell> cells;
  tree.forEachCell([&](const ProbeCell& cell) { cells.push_back(cell); });
  Random random(5);
  std::vector<PositionM> positions;
  while (positions.size() < kPositionCount) {
    const ProbeCell& cell = cells[random.below(static_cast<uint32_t>(cells.size()))];
    PositionM at;
    for (size_t axis = 0; axis < 3; ++axis)
      at[axis] = tree.frame().first_m[axis] + tree.frame().spacing_m * (cell.low[axis] + cell.side * random.uniform());
    ProbesAround around;
    for (int step = 0; step < steps && positions.size() < kPositionCount && tree.lookUp(at, &around); ++step) {
      positions.push_back(at);
      at[0] += kStepM;
    }
  }
  return positions;
}

std::vector<float> normals() {
  Random random(4);
  std::vector<float> normals;
  for (int i = 0; i < kPositionCount; ++i) {
    const double z = random.uniform(-1.0, 1.0), turn = random.uniform(0.0, 2.0 * std::numbers::pi), r = std::sqrt(1.0 - z * z);
    normals.insert(normals.end(),
                   {static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)), static_cast<float>(z)});
  }
  return normals;
}

enum class Way { weights, single, batched };

void lookUp(benchmark::State& state, const LightGrid& grid, const std::vector<PositionM>& positions, Way way) {
  // outside the loop: only look-ups are timed
  const std::vector<float> directions = normals();
  std::vector<float> rgb(directions.size());
  std::vector<LightStatus> status(positions.size());
  LookUpScratch scratch;
  ProbeWeights weights;
  for (auto _ : state) {
    if (way == Way::batched) {
      lookUpIrradiances(grid, positions.data(), directions.data(), positions.size(), rgb.data(), status.data(), &scratch);
    }
    for (size_t i = 0; i < positions.size() && way != Way::batched; ++i) {
      if (way == Way::weights) lookUpWeights(grid, positions[i], &weights);
      if (way == Way::single) status[i] = lookUpIrradiance(grid, positions[i], &directions[3 * i], &rgb[3 * i]);
    }
    // the compiler must take every result for used
    benchmark::DoNotOptimize(weights);
    benchmark::DoNotOptimize(rgb.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kPositionCount);
  // the share of lit positions: a grid that answers nothing would look fast
  state.counters["lit"] = static_cast<double>(std::count(status.begin(), status.end(), LightStatus::lit)) / kPositionCount;
}

struct NamedWay {
  const char* name;
  Way way;
};
constexpr NamedWay kWays[] = {{"weights", Way::weights}, {"single", Way::single}, {"batched", Way::batched}};

std::string caseName(const NamedWay& way, const std::string& grid, bool is_walk) {
  return std::string("irradiance/") + way.name + "/" + grid + (is_walk ? "/walk" : "/scattered");
}

void registerRepresentation(const char* name, const NamedWay& way, bool is_walk) {
  benchmark::RegisterBenchmark(caseName(way, name, is_walk).c_str(), [=](benchmark::State& state) {
    Representation representation;
    findRepresentation(name, &representation);
    if (representation.isCode())
      representation = Representation::code(sampleDictionary(kMaxBrickResolution, representation.code_count, 1));
    lookUp(state, gridOf(representation), is_walk ? walk() : scattered(), way.way);
  });
}

void registerLevel(const char* path, const NamedWay& way, bool is_walk) {
  benchmark::RegisterBenchmark(caseName(way, "level", is_walk).c_str(), [=](benchmark::State& state) {
    LightGrid grid;
    GridMetadata texts;
    const FileResult result = readLightGridFile(path, &grid, &texts);
    if (!result.ok() || grid.light.empty() || grid.tree.cellCount() == 0) {
      state.SkipWithError((std::string(path) + ": expected a light grid with light. " + result.detail).c_str());
      return;
    }
    lookUp(state, grid, inCells(grid.tree, is_walk ? 256 : 1), way.way);
  });
}

const bool kRegistered = [] {
  const char* level = std::getenv("NLG_GRID");
  for (const bool is_walk : {true, false}) {
    for (const NamedWay& way : kWays) {
      for (const char* name : {"tent_mlp", "tent_mlp4", "mlp", "pf5", "code64"}) registerRepresentation(name, way, is_walk);
      if (level != nullptr) registerLevel(level, way, is_walk);
    }
  }
  return true;
}();

}  // namespace
}  // namespace nlg
