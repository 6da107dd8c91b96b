// What the generators that ship take a function, with the check, without and with their correction steps: one group a file of weights/.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <vector>

#include "benchmarks/sample_function.h"
#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/function_check.h"

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

// Every function of the batch is corrected, as if all had failed the check.
void runCorrection(benchmark::State& state, const Generator& generator) {
  Batch batch(generator);
  Corrector corrector(generator);
  batch.generate();
  const std::vector<float> generated = batch.theta;
  for (auto _ : state) {
    std::copy(generated.begin(), generated.end(), batch.theta.begin());
    benchmark::DoNotOptimize(corrector.correct(batch.functions.data(), kBatchCount, batch.theta.data()));
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
    benchmark::RegisterBenchmark((name + "/correction").c_str(), runCorrection, loaded);
  }
  return static_cast<int>(generators.size());
}();

}  // namespace
}  // namespace nlg
