#include "runtime_eval/fit/correction_stages.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss_kernel.h"
#include "runtime_eval/numbers/finite.h"

namespace nlg {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// By what a learned step has to lower the mean square for another one to follow.
constexpr double kStepPays = 0.99;

// The last hidden values and the constant.
void prepare(const Generator& generator, SymmetricBand* equations) {
  if (!generator.exactLastLayer()) return;
  const int feature_count = generator.representation().shape().last() + 1;
  equations->reset(feature_count, feature_count - 1);
}

void solve(const Representation& representation, const WeightingFunction& function, float* theta, SymmetricBand* equations) {
  solveLastLayer(representation, 0, static_cast<int>(function.phi.size()), function.phi.data(), function.mask.data(), theta,
                 equations);
}

}  // namespace

LastLayerStage::LastLayerStage(const Generator& generator) : solved_(generator.representation().thetaCount()) {
  prepare(generator, &equations_);
}

void LastLayerStage::run(ThetaBatch& batch, int* members, int member_count) {
  for (int n = 0; n < member_count; ++n) {
    const int i = members[n];
    std::copy_n(batch.theta(i), batch.thetaCount(), solved_.begin());
    solve(batch.representation(), batch.function(i), solved_.data(), &equations_);
    // of equal theta the one that came stays: it is solved already
    batch.meanSquare(i);
    batch.offer(i, solved_.data(), batch.meanSquareOf(solved_.data()), 1.0);
  }
}

LearnedStepsStage::LearnedStepsStage(const Generator& generator, int most_steps)
    : generator_(&generator),
      most_steps_(generator.correctionStepCount() > 0 ? most_steps : 0),
      places_{generator.coefficientCount(), generator.representation().thetaCount()},
      layer_scratch_(generator.correctionLayers()),
      current_(static_cast<size_t>(kBatchCount) * places_.theta_count),
      change_(current_.size()),
      error_(kBatchCount),
      least_error_(kBatchCount),
      gradient_(places_.theta_count),
      theta_(places_.theta_count) {
  prepare(generator, &equations_);
}

void LearnedStepsStage::run(ThetaBatch& batch, int* members, int member_count) {
  const size_t D = batch.thetaCount();
  for (int n = 0; n < member_count; ++n) {
    batch.meanSquare(members[n]);
    std::copy_n(batch.theta(members[n]), D, &current_[n * D]);
  }
  going_on_ = members;
  count_ = member_count;
  goOn(batch, 0, false);
}

void LearnedStepsStage::attempt(ThetaBatch& batch, int mirror, const float* start, int* members, int member_count) {
  std::copy_n(start, member_count * batch.thetaCount(), current_.begin());
  for (int n = 0; n < member_count; ++n) batch.meanSquare(members[n]);
  going_on_ = members;
  count_ = member_count;
  goOn(batch, mirror, true);
}

void LearnedStepsStage::goOn(ThetaBatch& batch, int mirror, bool solve_first) {
  std::fill_n(least_error_.begin(), count_, kInfinite);
  for (int step = 0;; ++step) {
    measure(batch, mirror, generator_->exactLastLayer() && (step > 0 || solve_first), step < most_steps_);
    keepBetter(batch, mirror);
    if (step == most_steps_ || count_ == 0) return;
    generator_->correctionLayers().run(count_, change_.data(), &layer_scratch_);
    const size_t value_count = count_ * batch.thetaCount();
    for (size_t d = 0; d < value_count; ++d) current_[d] += change_[d];
  }
}

// Errors of current_ and, when the network is to run, what it reads.
void LearnedStepsStage::measure(ThetaBatch& batch, int mirror, bool solve_last_layer, bool network_runs) {
  for (int n = 0; n < count_; ++n) {
    float* theta = &current_[n * batch.thetaCount()];
    const WeightingFunction& function = batch.function(going_on_[n], mirror);
    if (solve_last_layer) solve(batch.representation(), function, theta, &equations_);
    error_[n] = kInfinite;
    if (!network_runs || batch.validCount() == 0) {
      error_[n] = batch.meanSquareOf(theta);
      continue;
    }
    const double sum = lossAndGradient(batch.representation(), 0, static_cast<int>(function.phi.size()), function.phi.data(),
                                       function.mask.data(), theta, gradient_.data());
    // a theta so far out that its gradient overflows is left as it is
    const bool is_finite = std::isfinite(sum) && allFinite({theta, gradient_.size()}) && allFinite(gradient_);
    if (!is_finite) continue;
    error_[n] = sum / batch.validCount();
    writeFeatures(batch, n, mirror);
  }
}

void LearnedStepsStage::writeFeatures(const ThetaBatch& batch, int n, int mirror) {
  const int D = places_.theta_count;
  const float* theta = &current_[static_cast<size_t>(n) * D];
  double square = 0.0;
  for (const float value : gradient_) square += static_cast<double>(value) * value;
  const double norm = std::sqrt(square) / batch.validCount() + 1e-12;  // of the gradient of the mean
  const double gradient_scale = std::sqrt(static_cast<double>(D)) / (norm * batch.validCount());
  float* features = layer_scratch_.input() + static_cast<size_t>(n) * places_.count();
  batch.mirrorCoefficients(going_on_[n], mirror, features);
  generator_->writeThetaFeatures(theta, features + places_.theta());
  for (int d = 0; d < D; ++d) features[places_.gradient() + d] = static_cast<float>(gradient_[d] * gradient_scale);
  features[places_.logNorm()] = static_cast<float>(std::log10(norm));
  features[places_.logError()] = static_cast<float>(std::log10(error_[n] + 1e-8));
}

void LearnedStepsStage::keepBetter(ThetaBatch& batch, int mirror) {
  const size_t D = batch.thetaCount(), width = static_cast<size_t>(places_.count());
  int kept = 0;
  for (int n = 0; n < count_; ++n) {
    const int i = going_on_[n];
    if (!std::isfinite(error_[n])) continue;
    std::copy_n(&current_[n * D], D, theta_.begin());
    mirrorTheta(batch.representation(), mirror, theta_.data());
    batch.offer(i, theta_.data(), error_[n], mirror == 0 ? 1.0 : kOfferPays);
    const bool paid = error_[n] < kStepPays * least_error_[n];
    least_error_[kept] = std::min(least_error_[n], error_[n]);
    if (!paid) continue;
    if (kept != n) {
      std::copy_n(&current_[n * D], D, &current_[kept * D]);
      float* features = layer_scratch_.input();
      if (most_steps_ > 0) std::copy_n(features + n * width, width, features + kept * width);
    }
    going_on_[kept++] = i;
  }
  count_ = kept;
}

MirrorImagesStage::MirrorImagesStage(const Generator& generator, int attempts, double above_rmse, int most_steps)
    : attempts_(attempts),
      above_square_(above_rmse * above_rmse),
      steps_(generator, most_steps),
      start_(static_cast<size_t>(kBatchCount) * generator.representation().thetaCount()),
      going_on_(kBatchCount) {}

void MirrorImagesStage::run(ThetaBatch& batch, int* members, int member_count) {
  for (int mirror = 1; mirror < attempts_; ++mirror) {
    int count = 0;
    for (int n = 0; n < member_count; ++n) {
      if (batch.meanSquare(members[n]) > above_square_) going_on_[count++] = members[n];
    }
    if (count == 0) return;
    batch.generateMirrored(mirror, going_on_.data(), count, start_.data());
    steps_.attempt(batch, mirror, start_.data(), going_on_.data(), count);
  }
}

}  // namespace nlg
