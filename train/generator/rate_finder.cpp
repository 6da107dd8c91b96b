#include "train/generator/rate_finder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kSteps = 200;
constexpr double kLowestRate = 1e-6, kHighestRate = 1.0;
constexpr double kSmoothing = 0.9;      // of the loss, over about ten steps
constexpr double kDivergedRatio = 2.0;  // of the lowest smoothed loss
constexpr size_t kSettled = 30;         // steps before which the smoothed loss is that of few batches, and the rates move nothing
constexpr size_t kSlopeSteps = 10;      // the slope is taken over so many

double rateOf(int step) { return kLowestRate * std::pow(kHighestRate / kLowestRate, double(step) / (kSteps - 1)); }

// Where the smoothed loss fell most within kSlopeSteps: the rate in their middle.
double steepestRate(const std::vector<double>& smoothed) {
  size_t best = 0;
  double largest_fall = -INFINITY;
  for (size_t i = kSettled; i + kSlopeSteps < smoothed.size(); ++i) {
    const double fall = smoothed[i] - smoothed[i + kSlopeSteps];
    if (fall > largest_fall) largest_fall = fall, best = i + kSlopeSteps / 2;
  }
  return rateOf(static_cast<int>(best));
}

}  // namespace

RateFinding findRate(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                     TrainingState* state) {
  const ProcessGroup alone;
  TrainStep step(options, representation, training, *state, alone);
  RateFinding finding;
  finding.diverged = kHighestRate;
  finding.csv = "rate,loss,smoothed_loss\n";
  std::vector<double> smoothed;
  double sum = 0.0, weight = 0.0, lowest = INFINITY;
  for (int i = 0; i < kSteps; ++i) {
    const TrainStep::Result result = step.computeGradient(*state);
    const bool finite = std::isfinite(result.loss) && std::isfinite(result.gradient_norm);
    if (!finite && i == 0) throw NumericalError("train", "the first step of the ramp", "loss", result.loss);
    sum = kSmoothing * sum + (1 - kSmoothing) * result.loss;
    weight = kSmoothing * weight + (1 - kSmoothing);
    const double value = sum / weight;
    if (!finite || value > kDivergedRatio * lowest) {
      finding.diverged = rateOf(i);
      break;
    }
    if (smoothed.size() >= kSettled) lowest = std::min(lowest, value);
    smoothed.push_back(value);
    char line[96];
    std::snprintf(line, sizeof line, "%.6g,%.6g,%.6g\n", rateOf(i), result.loss, value);
    finding.csv += line;
    step.apply(*state, rateOf(i));
  }
  finding.steepest = steepestRate(smoothed);
  finding.suggested = std::min(finding.steepest, finding.diverged / 10);
  return finding;
}

}  // namespace nlg
