#include "runtime_eval/fit/correction.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "runtime_eval/evaluator/representation.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss_kernel.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/support/support_pattern.h"

namespace nlg {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A last layer solved on few points may have numbers of any size: what float16 cannot hold is not taken, as light grids store it.
bool fitsFloat16(const float* theta, size_t count) {
  constexpr float kLargestHalf = 65504.0f;
  return std::all_of(theta, theta + count, [](float value) { return std::fabs(value) <= kLargestHalf; });
}

// By what a step has to lower the mean square for another one to follow, and a mirror image for its theta to be taken: below lies
// rounding, since errors of images are summed in another order.
constexpr double kPays = 0.99, kImagePays = 0.999;
// A representation that is wrong about the tent is so about every function, which no attempt changes: for it retry_rmse rises to so
// many times that error, at most to so many times itself.
constexpr double kRetryOverTent = 1.25, kMostRetry = 2.0;
// What counts as progress of Levenberg–Marquardt: three accepted iterations in a row that lower the mean square by less than this
// share end it.
constexpr double kIterationProgress = 0.05;
// Before iterations the first learned step gains more than it costs, and no other does.
constexpr int kStepsBeforeIterations = 1;

bool hasValidPoint(const StoredFunction& function) {
  return std::any_of(function.validity, function.validity + kValidityByteCount, [](uint8_t byte) { return byte != 0; });
}

}  // namespace

bool iteratesCheaply(const Representation& representation) {
  return representation.isField() || representation.thetaCount() <= 32;
}

Corrector::Corrector(const Generator& generator, const CorrectionOptions& options)
    : generator_(&generator),
      options_(options),
      generator_scratch_(generator),
      layer_scratch_(generator.correctionLayers()),
      places_{generator.coefficientCount(), generator.representation().thetaCount()} {
  if (generator.correctionStepCount() == 0) options_.most_steps = 0;
  if (generator.representation().isField()) options_.mirror_images = 1;
  if (iteratesCheaply(generator.representation())) {
    options_.adam_steps = 0;
  } else {
    options_.iterations = options_.theta0_iterations = 0;
  }
  if (options_.iterations > 0) options_.most_steps = std::min(options_.most_steps, kStepsBeforeIterations);
  if (empty()) return;
  const size_t batch = kBatchCount, theta_count = static_cast<size_t>(places_.theta_count);
  phi_.resize(batch * kSupportPointCount);
  coefficients_.resize(batch * places_.coefficient_count);
  mirrored_.resize(batch * places_.coefficient_count);
  rows_.resize(batch * places_.coefficient_count);
  current_.resize(batch * theta_count);
  change_.resize(batch * theta_count);
  gradient_.resize(theta_count);
  theta_.resize(theta_count);
  best_error_.resize(batch);
  error_.resize(batch);
  attempt_error_.resize(batch);
  changed_.resize(batch);
  going_on_.reserve(batch);
  const int place_count = pointOrder(generator.representation()).placeCount();
  function_.phi.resize(place_count);
  function_.mask.resize(place_count);
  function_.valid_count.resize(pointOrder(generator.representation()).batchCount());
  if (generator.exactLastLayer()) {
    // the last hidden values and the constant
    const int feature_count = generator.representation().shape().last() + 1;
    equations_.reset(feature_count, feature_count - 1);
  }
  // what is good enough, for this generator
  const double least_rmse = std::min(kRetryOverTent * tentRmse(), kMostRetry * options_.retry_rmse);
  const auto square = [](double rmse) { return rmse * rmse; };
  correct_square_ = square(options_.correct_rmse);
  retry_square_ = std::max(correct_square_, square(std::max(options_.retry_rmse, least_rmse)));
  const int iterations = options_.iterations + options_.theta0_iterations;
  fit_square_ = kInfinite;
  if (iterations > 0) fit_square_ = correct_square_;
  if (options_.adam_steps > 0) fit_square_ = std::max(correct_square_, square(std::max(options_.adam_rmse, least_rmse)));
  // one of each on the tent takes the memory that fits need
  best_error_[0] = 0.0;
  iterate(0, generator.theta0(), std::min(1, iterations), current_.data());
  stepAdam(0, generator.theta0(), std::min(1, options_.adam_steps), current_.data());
}

int Corrector::correct(const StoredFunction* functions, int count, float* theta) {
  if (empty()) return 0;
  int changed = 0;
  for (int begin = 0; begin < count; begin += kBatchCount) {
    changed += correctBatch(functions + begin, std::min(kBatchCount, count - begin),
                            theta + static_cast<size_t>(begin) * places_.theta_count);
  }
  return changed;
}

int Corrector::correctBatch(const StoredFunction* functions, int count, float* theta) {
  if (options_.most_steps > 0 || options_.mirror_images > 1) {
    for (int i = 0; i < count; ++i) std::memcpy(&phi_[size_t(i) * kSupportPointCount], functions[i].phi, kSupportPointCount);
    generator_->project(phi_.data(), count, coefficients_.data(), &generator_scratch_);
  }
  for (int i = 0; i < count; ++i) {
    changed_[i] = 0;
    best_error_[i] = kInfinite;
    if (!generator_->exactLastLayer()) continue;  // else the first measurement is of the theta that came
    decode(functions[i], 0);
    best_error_[i] = meanSquare(&theta[static_cast<size_t>(i) * places_.theta_count]);
  }
  for (int mirror = 0; mirror < options_.mirror_images; ++mirror) {
    going_on_.clear();
    for (int i = 0; i < count; ++i) {
      const bool is_wrong = best_error_[i] > (mirror == 0 ? correct_square_ : retry_square_);
      if (is_wrong && hasValidPoint(functions[i])) going_on_.push_back(i);
    }
    if (going_on_.empty()) break;
    startAttempt(mirror, theta);
    runSteps(functions, mirror, theta);
  }
  for (int i = 0; i < count; ++i) fitOn(functions[i], i, theta);
  return static_cast<int>(std::count(changed_.begin(), changed_.begin() + count, uint8_t{1}));
}

void Corrector::fitOn(const StoredFunction& stored, int i, float* theta) {
  if (!(best_error_[i] > fit_square_) || !hasValidPoint(stored)) return;
  const float* own = &theta[static_cast<size_t>(i) * places_.theta_count];
  decode(stored, 0);
  iterate(i, own, options_.iterations, theta);
  if (best_error_[i] > retry_square_) iterate(i, generator_->theta0(), options_.theta0_iterations, theta);
  stepAdam(i, own, options_.adam_steps, theta);
}

void Corrector::startAttempt(int mirror, const float* theta) {
  const size_t D = static_cast<size_t>(places_.theta_count), K = static_cast<size_t>(places_.coefficient_count);
  for (const int i : going_on_) {
    attempt_error_[i] = kInfinite;
    generator_->projection().mirrorCoefficients(&coefficients_[i * K], mirror, &mirrored_[i * K]);
    if (mirror == 0) std::copy_n(&theta[i * D], D, &current_[i * D]);
  }
  if (mirror == 0) return;
  // the generator reads rows without gaps
  for (size_t n = 0; n < going_on_.size(); ++n) std::copy_n(&mirrored_[going_on_[n] * K], K, rows_.begin() + n * K);
  generator_->generateFromCoefficients(rows_.data(), static_cast<int>(going_on_.size()), change_.data(), &generator_scratch_);
  for (size_t n = 0; n < going_on_.size(); ++n) std::copy_n(&change_[n * D], D, &current_[going_on_[n] * D]);
}

void Corrector::runSteps(const StoredFunction* functions, int mirror, float* theta) {
  const size_t D = static_cast<size_t>(places_.theta_count);
  for (int step = 0;; ++step) {
    measure(functions, mirror, step < options_.most_steps);
    keepBetter(mirror, theta);
    if (step == options_.most_steps || going_on_.empty()) return;
    generator_->correctionLayers().run(static_cast<int>(going_on_.size()), change_.data(), &layer_scratch_);
    for (size_t n = 0; n < going_on_.size(); ++n) {
      float* target = &current_[going_on_[n] * D];
      for (size_t d = 0; d < D; ++d) target[d] += change_[n * D + d];
    }
  }
}

void Corrector::decode(const StoredFunction& stored, int mirror) {
  const PointOrder& order = pointOrder(generator_->representation());
  valid_count_ = 0;
  for (int b = 0; b < order.batchCount(); ++b) {
    const int begin = order.batch_begin[b];
    function_.valid_count[b] = decodeBatch(order, b, stored, mirror, &function_.phi[begin], &function_.mask[begin]);
    valid_count_ += function_.valid_count[b];
  }
}

double Corrector::meanSquare(const float* theta) const {
  if (valid_count_ == 0 || !allFinite({theta, static_cast<size_t>(places_.theta_count)})) return kInfinite;
  const int place_count = static_cast<int>(function_.phi.size());
  const double sum = loss(generator_->representation(), 0, place_count, function_.phi.data(), function_.mask.data(), theta);
  return std::isfinite(sum) ? sum / valid_count_ : kInfinite;
}

void Corrector::measure(const StoredFunction* functions, int mirror, bool network_runs) {
  const Representation& representation = generator_->representation();
  const int place_count = static_cast<int>(function_.phi.size());
  for (size_t n = 0; n < going_on_.size(); ++n) {
    const int i = going_on_[n];
    float* theta = &current_[static_cast<size_t>(i) * places_.theta_count];
    decode(functions[i], mirror);
    if (generator_->exactLastLayer()) {
      solveLastLayer(representation, 0, place_count, function_.phi.data(), function_.mask.data(), theta, &equations_);
    }
    error_[i] = kInfinite;
    if (!network_runs || valid_count_ == 0) {
      error_[i] = meanSquare(theta);
      continue;
    }
    const double sum =
        lossAndGradient(representation, 0, place_count, function_.phi.data(), function_.mask.data(), theta, gradient_.data());
    // a theta so far out that its gradient overflows is left as it is
    const bool is_finite = std::isfinite(sum) && allFinite({theta, gradient_.size()}) && allFinite(gradient_);
    if (!is_finite) continue;
    error_[i] = sum / valid_count_;
    writeFeatures(i, n);
  }
}

void Corrector::writeFeatures(int i, size_t row) {
  const int D = places_.theta_count;
  const float* theta = &current_[static_cast<size_t>(i) * D];
  double square = 0.0;
  for (const float value : gradient_) square += static_cast<double>(value) * value;
  const double norm = std::sqrt(square) / valid_count_ + 1e-12;  // of the gradient of the mean
  const double gradient_scale = std::sqrt(static_cast<double>(D)) / (norm * valid_count_);
  float* features = layer_scratch_.input() + row * places_.count();
  std::copy_n(&mirrored_[static_cast<size_t>(i) * places_.coefficient_count], places_.coefficient_count, features);
  for (int d = 0; d < D; ++d) {
    features[places_.theta() + d] = (theta[d] - generator_->theta0()[d]) / generator_->outputScale()[d];
    features[places_.gradient() + d] = static_cast<float>(gradient_[d] * gradient_scale);
  }
  features[places_.logNorm()] = static_cast<float>(std::log10(norm));
  features[places_.logError()] = static_cast<float>(std::log10(error_[i] + 1e-8));
}

void Corrector::keepBetter(int mirror, float* theta) {
  const size_t D = static_cast<size_t>(places_.theta_count);
  const double pays = mirror == 0 ? 1.0 : kImagePays;
  size_t kept = 0;
  for (size_t n = 0; n < going_on_.size(); ++n) {
    const int i = going_on_[n];
    if (!std::isfinite(error_[i])) continue;
    std::copy_n(&current_[i * D], D, theta_.begin());
    mirrorTheta(generator_->representation(), mirror, theta_.data());
    if (std::memcmp(&theta[i * D], theta_.data(), D * sizeof(float)) == 0) {
      best_error_[i] = error_[i];  // of a theta that nothing has happened to yet only the error is new
      if (best_error_[i] <= correct_square_) continue;
    } else if (error_[i] < pays * best_error_[i] && fitsFloat16(theta_.data(), D)) {
      best_error_[i] = error_[i];
      changed_[i] = 1;
      std::copy_n(theta_.data(), D, &theta[i * D]);
    }
    const bool paid = error_[i] < kPays * attempt_error_[i];
    attempt_error_[i] = std::min(attempt_error_[i], error_[i]);
    if (!paid) continue;
    float* features = layer_scratch_.input();
    if (kept != n && options_.most_steps > 0) {
      std::copy_n(features + n * places_.count(), places_.count(), features + kept * places_.count());
    }
    going_on_[kept++] = i;
  }
  going_on_.resize(kept);
}

double Corrector::tentRmse() {
  const Representation& representation = generator_->representation();
  const PointOrder& order = pointOrder(representation);
  for (int p = 0; p < kSupportPointCount; ++p) {
    phi_[p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
  }
  generator_->generate(phi_.data(), 1, current_.data(), &generator_scratch_);
  function_ = tentFunction(order);
  if (generator_->exactLastLayer()) {
    solveLastLayer(representation, 0, order.placeCount(), function_.phi.data(), function_.mask.data(), current_.data(),
                   &equations_);
  }
  return functionRmse(representation, function_, current_.data());
}

void Corrector::iterate(int i, const float* start, int iterations, float* theta) {
  const size_t D = static_cast<size_t>(places_.theta_count);
  const Representation& representation = generator_->representation();
  if (iterations == 0) return;
  LevenbergMarquardtOptions options = refinementLevenbergMarquardt(representation, iterations);
  options.progress_tolerance = kIterationProgress;
  std::copy_n(start, D, theta_.begin());
  const FitResult fit =
      iterateLevenbergMarquardt(representation, function_, options, &normal_equations_, &levenberg_workspace_, theta_.data());
  takeFitted(i, fit.rmse * fit.rmse, theta);
}

void Corrector::stepAdam(int i, const float* start, int steps, float* theta) {
  if (steps == 0) return;
  const size_t D = static_cast<size_t>(places_.theta_count);
  const Representation& representation = generator_->representation();
  std::copy_n(start, D, theta_.begin());
  const FitResult fit =
      iterateAdam(representation, function_, refinementAdam(representation, steps), &adam_workspace_, theta_.data());
  takeFitted(i, fit.rmse * fit.rmse, theta);
}

void Corrector::takeFitted(int i, double error, float* theta) {
  const size_t D = static_cast<size_t>(places_.theta_count);
  if (!(error < kImagePays * best_error_[i]) || !fitsFloat16(theta_.data(), D)) return;
  best_error_[i] = error;
  changed_[i] = 1;
  std::copy_n(theta_.data(), D, &theta[i * D]);
}

}  // namespace nlg
