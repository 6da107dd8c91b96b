#include "runtime_eval/fit/correction.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss_kernel.h"

namespace nlg {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A last layer solved on few points may have numbers of any size: what float16 cannot hold is not taken, as light grids store it.
bool fitsFloat16(const float* theta, size_t count) {
  constexpr float kLargestHalf = 65504.0f;
  return std::all_of(theta, theta + count, [](float value) { return std::fabs(value) <= kLargestHalf; });
}

}  // namespace

Corrector::Corrector(const Generator& generator)
    : generator_(&generator),
      generator_scratch_(generator),
      layer_scratch_(generator.correctionLayers()),
      places_{generator.coefficientCount(), generator.representation().thetaCount()} {
  if (empty()) return;
  const size_t batch = kBatchCount, theta_count = static_cast<size_t>(places_.theta_count);
  phi_.resize(batch * kSupportPointCount);
  coefficients_.resize(batch * places_.coefficient_count);
  current_.resize(batch * theta_count);
  change_.resize(batch * theta_count);
  gradient_.resize(theta_count);
  best_error_.resize(batch);
  error_.resize(batch);
  changed_.resize(batch);
  going_on_.reserve(batch);
  const int place_count = pointOrder(generator.representation()).placeCount();
  function_.phi.resize(place_count);
  function_.mask.resize(place_count);
  if (generator.exactLastLayer()) {
    // the last hidden values and the constant
    const int feature_count = generator.representation().shape().last() + 1;
    equations_.reset(feature_count, feature_count - 1);
  }
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
  const size_t D = static_cast<size_t>(places_.theta_count);
  const int step_count = generator_->correctionStepCount();
  if (step_count > 0) {
    for (int i = 0; i < count; ++i) std::memcpy(&phi_[size_t(i) * kSupportPointCount], functions[i].phi, kSupportPointCount);
    generator_->project(phi_.data(), count, coefficients_.data(), &generator_scratch_);
  }
  std::copy_n(theta, count * D, current_.begin());
  going_on_.clear();
  for (int i = 0; i < count; ++i) {
    going_on_.push_back(i);
    changed_[i] = 0;
    best_error_[i] = kInfinite;
    if (!generator_->exactLastLayer()) continue;
    decode(functions[i]);
    best_error_[i] = meanSquare(&theta[i * D]);
  }
  for (int step = 0; step <= step_count; ++step) {
    measure(functions, step < step_count);
    const int kept = keepBetter(step == 0, theta);
    if (step == step_count || kept == 0) break;
    generator_->correctionLayers().run(kept, change_.data(), &layer_scratch_);
    for (int n = 0; n < kept; ++n) {
      float* target = &current_[going_on_[n] * D];
      for (size_t d = 0; d < D; ++d) target[d] += change_[n * D + d];
    }
  }
  return static_cast<int>(std::count(changed_.begin(), changed_.begin() + count, uint8_t{1}));
}

void Corrector::decode(const StoredFunction& stored) {
  const PointOrder& order = pointOrder(generator_->representation());
  valid_count_ = 0;
  for (int b = 0; b < order.batchCount(); ++b) {
    const int begin = order.batch_begin[b];
    valid_count_ += decodeBatch(order, b, stored, 0, &function_.phi[begin], &function_.mask[begin]);
  }
}

double Corrector::meanSquare(const float* theta) const {
  if (valid_count_ == 0) return kInfinite;
  const int place_count = static_cast<int>(function_.phi.size());
  const double sum = loss(generator_->representation(), 0, place_count, function_.phi.data(), function_.mask.data(), theta);
  return std::isfinite(sum) ? sum / valid_count_ : kInfinite;
}

void Corrector::measure(const StoredFunction* functions, bool network_runs) {
  const Representation& representation = generator_->representation();
  const int place_count = static_cast<int>(function_.phi.size());
  for (size_t n = 0; n < going_on_.size(); ++n) {
    const int i = going_on_[n];
    float* theta = &current_[static_cast<size_t>(i) * places_.theta_count];
    decode(functions[i]);
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
    const bool is_finite =
        std::isfinite(sum) && std::all_of(gradient_.begin(), gradient_.end(), [](float value) { return std::isfinite(value); });
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
  std::copy_n(&coefficients_[static_cast<size_t>(i) * places_.coefficient_count], places_.coefficient_count, features);
  for (int d = 0; d < D; ++d) {
    features[places_.theta() + d] = (theta[d] - generator_->theta0()[d]) / generator_->outputScale()[d];
    features[places_.gradient() + d] = static_cast<float>(gradient_[d] * gradient_scale);
  }
  features[places_.logNorm()] = static_cast<float>(std::log10(norm));
  features[places_.logError()] = static_cast<float>(std::log10(error_[i] + 1e-8));
}

int Corrector::keepBetter(bool all_go_on, float* theta) {
  const size_t D = static_cast<size_t>(places_.theta_count);
  int kept = 0;
  for (size_t n = 0; n < going_on_.size(); ++n) {
    const int i = going_on_[n];
    if (!std::isfinite(error_[i])) continue;
    const bool is_as_it_came = std::memcmp(&theta[i * D], &current_[i * D], D * sizeof(float)) == 0;
    const bool is_better = error_[i] < best_error_[i] && (is_as_it_came || fitsFloat16(&current_[i * D], D));
    if (!is_better && !all_go_on) continue;
    if (is_better) {
      best_error_[i] = error_[i];
      // of a theta that nothing has happened to yet only the error is new
      if (!is_as_it_came) changed_[i] = 1;
      std::copy_n(&current_[i * D], D, &theta[i * D]);
    }
    // the features of those that go on close up
    float* features = layer_scratch_.input();
    if (static_cast<size_t>(kept) != n && generator_->correctionStepCount() > 0) {
      std::copy_n(features + n * places_.count(), places_.count(), features + static_cast<size_t>(kept) * places_.count());
    }
    going_on_[kept++] = i;
  }
  going_on_.resize(kept);
  return kept;
}

}  // namespace nlg
