// What each representation can say: the error of direct fits on stored functions, beside its size and its evaluation time.
//
//     bench_representations FUNCTION_COUNT ADAM_STEPS all|NAME[,NAME]… SHARD...
//
// Functions are taken evenly over the shards. Every representation gets the same budget: theta0 is fitted to the mean of these
// functions; each function is fitted by ADAM_STEPS steps of Adam from theta0 and from three random starts (product fields: a
// 32nd of them, all points a step; and from coarse to fine), the best of which is polished by Levenberg–Marquardt. Prints
// Markdown. Hard functions are those from which the bare tent is .01 or more away.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/function_check.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kRandomStarts = 3, kPolishIterations = 20;
constexpr double kHardRmse = 0.01;

struct Summary {
  double mean = 0.0, median = 0.0, p95 = 0.0;
};

Summary summary(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  Summary result;
  for (const double value : values) result.mean += value / static_cast<double>(values.size());
  const auto at = [&](double q) {
    return values[std::min(values.size() - 1, static_cast<size_t>(q * static_cast<double>(values.size())))];
  };
  result.median = at(0.5);
  result.p95 = at(0.95);
  return result;
}

struct Samples {
  std::vector<StoredFunction> functions;
  std::vector<bool> hard;
  std::vector<float> mean_phi;  // P: over these functions, where they are valid
  std::vector<bool> ever_valid;
};

Samples takeSamples(const FunctionSet& set, int count) {
  Samples samples;
  FunctionChecker checker;
  std::vector<double> sum(kSupportPointCount, 0.0);
  std::vector<int> valid(kSupportPointCount, 0);
  for (int i = 0; i < count; ++i) {
    const uint64_t n = static_cast<uint64_t>(i) * set.functionCount() / static_cast<uint64_t>(count);
    const StoredFunction stored = storedFunction(set, n);
    samples.functions.push_back(stored);
    samples.hard.push_back(checker.checkBareTent(stored, {}).rmse >= kHardRmse);
    for (int p = 0; p < kSupportPointCount; ++p) {
      if ((stored.validity[p / 8] >> (p % 8) & 1) != 0) sum[p] += stored.phi[p] / 255.0, ++valid[p];
    }
  }
  for (int p = 0; p < kSupportPointCount; ++p) {
    samples.ever_valid.push_back(valid[p] > 0);
    samples.mean_phi.push_back(static_cast<float>(sum[p] / std::max(1, valid[p])));
  }
  return samples;
}

double directRmse(const Representation& representation, const WeightingFunction& function, const Theta& theta0, int adam_steps,
                  uint64_t seed, NormalEquationsKernel* kernel) {
  const int steps = adam_steps * kMinibatchPointCount / std::min(pointOrder(representation).minibatch_places, kSupportPointCount);
  FitResult best = fitAdam(representation, function, theta0, refinementAdam(representation, steps));
  const auto consider = [&](const FitResult& fit) {
    if (fit.rmse < best.rmse) best = fit;
  };
  for (int i = 0; i < kRandomStarts; ++i) {
    const Theta start = randomTheta(representation, mixSeed(seed, static_cast<uint64_t>(i)));
    consider(fitAdam(representation, function, start, randomStartAdam(steps)));
  }
  if (representation.isField()) consider(fitNested(representation, function, kPolishIterations, kernel));
  const LevenbergMarquardtOptions polish = refinementLevenbergMarquardt(representation, kPolishIterations);
  return fitLevenbergMarquardt(representation, function, best.theta, polish, kernel).rmse;
}

// Shortest of several evaluations at all support points.
double evaluationMicroseconds(const Representation& representation, const Theta& theta) {
  const PointOrder& order = pointOrder(representation);
  AlignedFloats values(order.placeCount());
  double shortest = INFINITY;
  for (int i = 0; i < 200; ++i) {
    const auto start = std::chrono::steady_clock::now();
    if (representation.isField()) {
      evaluateFieldCells(order, theta.data(), values.data());
    } else {
      evaluate(representation, order.points, theta.data(), values.data());
    }
    const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;
    shortest = std::min(shortest, elapsed.count());
  }
  return shortest;
}

void measure(const Representation& representation, const Samples& samples, int adam_steps) {
  NormalEquationsKernel kernel;
  const PointOrder& order = pointOrder(representation);
  StartOptions start;
  start.candidates = 48;
  start.candidate_steps = 1200;
  start.finalists = 4;
  start.final_steps = 8000;
  start.levenberg_iterations = 40;
  const WeightingFunction mean = functionFromSamples(samples.mean_phi, samples.ever_valid, order);
  const Theta theta0 = fitStart(representation, mean, start, &kernel).theta;
  std::vector<double> all, hard;
  for (size_t i = 0; i < samples.functions.size(); ++i) {
    const WeightingFunction function = decodeFunction(samples.functions[i], order);
    all.push_back(directRmse(representation, function, theta0, adam_steps, i, &kernel));
    if (samples.hard[i]) hard.push_back(all.back());
  }
  const Summary a = summary(all), h = summary(hard);
  const int numbers = representation.thetaCount();
  std::printf("| %s | %d | %d | %.1f | %.4f | %.4f | %.4f | %.4f | %.4f | %.4f |\n", representationName(representation), numbers,
              2 * numbers, evaluationMicroseconds(representation, theta0), a.mean, a.median, a.p95, h.mean, h.median, h.p95);
  std::fflush(stdout);
}

void run(int function_count, int adam_steps, const std::string& names, const std::vector<std::string>& shards) {
  const FunctionSet set = readFunctionSet(shards, supportPattern().hash, kSupportPointCount);
  const Samples samples = takeSamples(set, std::min(function_count, static_cast<int>(set.functionCount())));
  std::printf("%zu functions, %d of them hard; %d steps of Adam\n\n", samples.functions.size(),
              static_cast<int>(std::count(samples.hard.begin(), samples.hard.end(), true)), adam_steps);
  std::printf("| | numbers | bytes (float16) | µs for 8192 points | mean | median | p95 | hard: mean | median | p95 |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  int measured = 0;
  for (const char* name : kRepresentationNames) {
    if (names != "all" && ("," + names + ",").find("," + std::string(name) + ",") == std::string::npos) continue;
    Representation representation;
    findRepresentation(name, &representation);
    measure(representation, samples, adam_steps);
    ++measured;
  }
  if (measured == 0) throw UsageError("representation", "all or some of " + representationNames(), "'" + names + "'");
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  const int function_count = argc > 4 ? std::atoi(argv[1]) : 0, adam_steps = argc > 4 ? std::atoi(argv[2]) : 0;
  if (function_count < 1 || adam_steps < 1) {
    std::fprintf(stderr, "usage: bench_representations FUNCTION_COUNT ADAM_STEPS all|NAME[,NAME]... SHARD...\n");
    return 2;
  }
  try {
    nlg::run(function_count, adam_steps, argv[3], {argv + 4, argv + argc});
  } catch (const nlg::ToolError& error) {
    std::fprintf(stderr, "bench_representations: error: %s\n", error.what());
    return static_cast<int>(error.exitCode());
  }
}
