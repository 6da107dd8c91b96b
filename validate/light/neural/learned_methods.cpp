#include "validate/light/neural/learned_methods.h"

#include <chrono>
#include <functional>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"
#include "validate/light/neural/network_grid.h"
#include "validate/light/neural/neural_volume.h"

namespace nlg {
namespace {

constexpr uint64_t kPlaceSplitStream = 0x73706c6974, kVolumeStream = 0x766f6c, kGridStream = 0x67726964;
constexpr size_t kFewestPlaces = 64;         // fewer tell nothing
constexpr int kChecks = 40, kPatience = 15;  // of the held-out loss, over all steps
constexpr float kVolumeRate = 5e-3f, kGridRate = 2e-2f;

struct VolumeSize {
  int table_log2, width;
};
constexpr VolumeSize kVolumeSizes[] = {{10, 32}, {12, 64}, {13, 64}, {14, 64}, {15, 64}, {17, 64}};
constexpr int kGridWidths[] = {8, 16, 32};

struct Row {
  std::string name;
  std::function<LearnedLight()> learn;
};

TrainingOptions trainingOf(int steps, float rate, uint64_t seed) {
  TrainingOptions training;
  training.steps = steps;
  training.check_steps = std::max(1, steps / kChecks);
  training.patience = kPatience;
  training.rate = rate;
  training.seed = seed;
  return training;
}

LearnedMethod learnedRow(const Row& row) {
  const auto start = std::chrono::steady_clock::now();
  LearnedLight learned = row.learn();
  LearnedMethod made;
  made.method.weights = row.name;
  made.method.light = "own";
  made.method.light_at = std::move(learned.light_at);
  made.method.bytes = learned.bytes;
  made.method.light_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  made.cost = learned.cost;
  return made;
}

}  // namespace

std::vector<LearnedMethod> learnedMethods(const LitPlaces& lit, const LearnedOptions& options) {
  // held-out places stop training early; the split is the same for all methods
  const PlaceSplit split = splitPlaces(lit.light.size(), mixSeed(options.seed, kPlaceSplitStream));
  if (split.learned.size() < kFewestPlaces)
    throw InputError("the scene", "air", fmt::format("{} sample points to learn light from", kFewestPlaces),
                     std::to_string(split.learned.size()));
  std::vector<Row> rows;  // the longest first
  for (const VolumeSize& size : kVolumeSizes) {
    NeuralVolumeOptions volume;
    volume.table_log2 = size.table_log2;
    volume.width = size.width;
    volume.training = trainingOf(options.steps, kVolumeRate, mixSeed(options.seed, kVolumeStream));
    rows.push_back({fmt::format("neural volume, 2^{}", size.table_log2),
                    [&lit, &split, volume] { return trainNeuralVolume(lit, split, volume); }});
  }
  for (const int width : kGridWidths) {
    NetworkGridOptions grid;
    grid.width = width;
    grid.training = trainingOf(options.steps, kGridRate, mixSeed(options.seed, kGridStream));
    rows.push_back({fmt::format("network grid, {}", width), [&lit, &split, grid] { return trainNetworkGrid(lit, split, grid); }});
  }
  // a network trains on one thread: rows run beside each other
  std::vector<LearnedMethod> methods(rows.size());
  Progress progress("networks of the scene", static_cast<int64_t>(rows.size()));
  parallelFor(rows.size(), options.thread_count, [&](uint64_t r, int) {
    methods[r] = learnedRow(rows[r]);
    progress.advance(1);
  });
  return methods;
}

}  // namespace nlg
