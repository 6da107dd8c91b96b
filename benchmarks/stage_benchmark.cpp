// What the generators that ship take a function, stage by stage of the policy: one group a file of weights/.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <vector>

#include "benchmarks/sample_function.h"
#include "runtime_eval/fit/theta_policy.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

// A batch of walls, and theta of the weights under measurement.
struct Batch {
  explicit Batch(const Generator& of)
      : generator(of), scratch(of), theta(size_t(kBatchCount) * of.representation().thetaCount()) {
    appendStoredWalls(kBatchCount, &phi, &validity);
    for (size_t i = 0; i < kBatchCount; ++i) functions.push_back(storedFunction(*this, i));
  }
  void generate() { generator.generate(phi.data(), kBatchCount, theta.data(), &scratch); }

  const Generator& generator;
  GeneratorScratch scratch;
  std::vector<uint8_t> phi, validity;
  std::vector<StoredFunction> functions;
  std::vector<float> theta;
};

void setRate(benchmark::State& state) {
  state.counters["functions/s"] = benchmark::Counter(kBatchCount, benchmark::Counter::kIsIterationInvariantRate);
}

void runGenerator(benchmark::State& state, const Generator& generator) {
  Batch batch(generator);
  for (auto _ : state) batch.generate();
  setRate(state);
}

void runCheck(benchmark::State& state, const Generator& generator) {
  Batch batch(generator);
  batch.generate();
  FunctionChecker checker;
  const size_t D = static_cast<size_t>(generator.representation().thetaCount());
  for (auto _ : state) {
    for (int i = 0; i < kBatchCount; ++i) {
      benchmark::DoNotOptimize(checker.check(generator.representation(), batch.functions[i], &batch.theta[i * D], {}));
    }
  }
  setRate(state);
}

// The network and every stage up to one of them, on functions of which hardly any is right at once.
void runStages(benchmark::State& state, const Generator& generator, ThetaStage last) {
  Batch batch(generator);
  StageRunner runner(generator, PolicyOptions{}, last);
  std::vector<ThetaRecord> records(kBatchCount);
  for (auto _ : state) {
    runner.make(batch.functions.data(), kBatchCount, batch.theta.data(), records.data());
    benchmark::DoNotOptimize(batch.theta.data());
  }
  setRate(state);
}

const int kRegistered = [] {
  static std::vector<Generator> generators;
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(NLG_SOURCE_WEIGHTS)) {
    if (entry.path().extension() == ".safetensors") paths.push_back(entry.path());
  }
  generators.reserve(paths.size());
  for (const fs::path& path : paths) {
    Generator generator;
    if (!Generator::load(path.string(), &generator).ok()) continue;
    generators.push_back(std::move(generator));
    const Generator& loaded = generators.back();
    const std::string name = "shipped/" + std::string(representationName(loaded.representation()));
    benchmark::RegisterBenchmark((name + "/generator").c_str(), runGenerator, loaded);
    benchmark::RegisterBenchmark((name + "/check").c_str(), runCheck, loaded);
    for (const StagePlan& plan : stagesOf(stageFacts(loaded), PolicyOptions{})) {
      if (plan.stage == ThetaStage::network || plan.stage == ThetaStage::refinement) continue;
      benchmark::RegisterBenchmark((name + "/up_to_" + stageName(plan.stage)).c_str(), runStages, loaded, plan.stage);
    }
  }
  return static_cast<int>(generators.size());
}();

}  // namespace
}  // namespace nlg
