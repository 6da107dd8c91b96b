#include "validate/frontier/generator_points.h"

#include <algorithm>
#include <numeric>

#include "runtime_eval/numbers/half.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "validate/frontier/stopwatch.h"

namespace nlg {
namespace {

using Functions = std::vector<FittedFunction>;

// The points so far of one representation.
struct PointList {
  std::string representation;
  std::vector<PlotPoint> points;

  PlotPoint& add(const std::string& family, std::optional<int> budget, const std::string& label,
                 std::function<Functions(const FunctionBlock&)> run) {
    return points.emplace_back(PlotPoint{representation, family, budget, label, true, std::move(run)});
  }
};

std::vector<int> defaultCoefficients(int all) {
  std::vector<int> counts;
  for (int count = 32; count < all; count *= 2) counts.push_back(count);
  counts.push_back(all);
  return counts;
}

// theta as a light grid of float16 holds it.
void roundToHalf(FittedFunction& function) {
  for (float& value : function.theta) {
    Half half;
    if (!halfFromFloat(value, &half)) throw NumericalError("validate", "rounding to float16", "theta", value);
    value = floatFromHalf(half);
  }
}

Functions correctedInHalf(GeneratorRun& run, const FunctionBlock& block) {
  Functions functions = run.generateAndCorrect(block);
  const Stopwatch watch;
  for (FittedFunction& function : functions) roundToHalf(function);
  const double elapsed_us = watch.elapsedUs() / block.count();
  for (FittedFunction& function : functions) function.elapsed_us += elapsed_us;
  return functions;
}

// Every thread runs the whole block on a generator of its own; the time of a function is that of all over their number.
Functions onThreads(const std::vector<std::shared_ptr<GeneratorRun>>& runs, const FunctionBlock& block) {
  std::vector<Functions> of_thread(runs.size());
  const WallStopwatch watch;
  parallelFor(runs.size(), static_cast<int>(runs.size()),
              [&](uint64_t item, int) { of_thread[item] = runs[item]->generateAndCorrect(block); });
  const double elapsed_us = watch.elapsedUs() / (static_cast<double>(runs.size()) * block.count());
  for (FittedFunction& function : of_thread.front()) function.elapsed_us = elapsed_us;
  return std::move(of_thread.front());
}

void addThreads(const std::shared_ptr<const Generator>& generator, const CorrectionOptions& correction, PointList& list) {
  for (const int count : {1, 2}) {
    std::vector<std::shared_ptr<GeneratorRun>> runs;
    for (int t = 0; t < count; ++t) runs.push_back(std::make_shared<GeneratorRun>(generator, correction));
    list.add("threads", count, "generator + correction, " + std::to_string(count) + (count > 1 ? " threads" : " thread"),
             [runs](const FunctionBlock& block) { return onThreads(runs, block); })
        .may_be_on_front = false;
  }
}

// The correction's own settings, one at a time: learned steps, and what follows them.
void addCorrections(const std::shared_ptr<const Generator>& generator, const CorrectionOptions& standard, PointList& list) {
  const auto add = [&](int budget, const std::string& unit, const CorrectionOptions& options) {
    const auto run = std::make_shared<GeneratorRun>(generator, options);
    list.add("corrected", budget, "generator + correction, " + std::to_string(budget) + ' ' + unit,
             [run](const FunctionBlock& block) { return run->generateAndCorrect(block); });
  };
  const bool iterates = iteratesCheaply(generator->representation());
  for (const int count : {1, 2, 4, 8}) {
    CorrectionOptions options = standard;
    options.most_steps = count, options.mirror_images = 1,
    options.iterations = options.theta0_iterations = options.adam_steps = 0;
    if (generator->correctionStepCount() > 0)
      add(count, "learned step" + std::string(count > 1 ? "s" : "") + " at most", options);
  }
  for (const int count : {1, 2, 4, 8}) {
    CorrectionOptions options = standard;
    (iterates ? options.iterations : options.mirror_images) = count;
    const std::string unit = iterates ? "LM iteration" : "mirror image";
    add(count, count > 1 ? unit + 's' : unit, options);
  }
}

}  // namespace

GeneratorData keepCoefficients(GeneratorData data, int kept) {
  const std::vector<float>& deviation = data.basis.deviation;
  NLG_CHECK(kept, <=, data.basis.coefficientCount());
  std::vector<int> order(deviation.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return deviation[a] > deviation[b]; });
  for (size_t i = static_cast<size_t>(kept); i < order.size(); ++i) {
    std::fill_n(data.basis.components.begin() + static_cast<std::ptrdiff_t>(order[i]) * kOctantPointCount, kOctantPointCount,
                0.0f);
  }
  return data;
}

std::vector<PlotPoint> generatorPoints(const GeneratorData& data, const std::shared_ptr<const Generator>& generator,
                                       const CorrectionOptions& correction, const std::vector<int>& coefficients) {
  PointList list{representationName(data.representation), {}};
  const auto run = std::make_shared<GeneratorRun>(generator, correction);
  const auto alone = [](std::shared_ptr<GeneratorRun> r) {
    return [r](const FunctionBlock& block) { return r->generate(block); };
  };
  const auto aloneOf = [&](auto&&... settings) {
    return alone(std::make_shared<GeneratorRun>(std::make_shared<const Generator>(settings...)));
  };
  const auto corrected = [run](const FunctionBlock& block) { return run->generateAndCorrect(block); };
  list.add("generator", {}, "generator alone", alone(run));
  list.add("corrected", {}, "generator + correction", corrected);
  addCorrections(generator, correction, list);
  const int all = data.basis.coefficientCount();
  for (const int kept : coefficients.empty() ? defaultCoefficients(all) : coefficients) {
    list.add("coefficients", kept, "generator alone, " + std::to_string(kept) + " of " + std::to_string(all) + " coefficients",
             aloneOf(keepCoefficients(data, kept)));
  }
  list.add("precision", 32, "generator alone, float32", alone(run));
  list.add("precision", 16, "generator alone, int16", aloneOf(data, GeneratorPrecision::int16));
  list.add("theta_precision", 32, "generator + correction, theta float32", corrected);
  list.add("theta_precision", 16, "generator + correction, theta float16",
           [run](const FunctionBlock& block) { return correctedInHalf(*run, block); });
  addThreads(generator, correction, list);
  return list.points;
}

}  // namespace nlg
