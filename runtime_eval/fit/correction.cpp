#include "runtime_eval/fit/correction.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "runtime_eval/fit/loss_kernel.h"

namespace nlg {

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
  const int D = places_.theta_count;
  for (int i = 0; i < count; ++i) std::memcpy(&phi_[size_t(i) * kSupportPointCount], functions[i].phi, kSupportPointCount);
  generator_->project(phi_.data(), count, coefficients_.data(), &generator_scratch_);
  std::copy_n(theta, size_t(count) * D, current_.begin());
  going_on_.clear();
  for (int i = 0; i < count; ++i) {
    going_on_.push_back(i);
    best_error_[i] = std::numeric_limits<double>::infinity();
  }
  std::fill_n(changed_.begin(), count, uint8_t{0});
  const int step_count = generator_->correctionStepCount();
  for (int step = 0; step <= step_count && !going_on_.empty(); ++step) {
    measure(functions, current_.data(), step < step_count);
    // the features of those that stay behind close up over those that end here
    int kept = 0;
    float* features = layer_scratch_.input();
    for (size_t n = 0; n < going_on_.size(); ++n) {
      const int i = going_on_[n];
      if (!(error_[i] < best_error_[i])) continue;
      best_error_[i] = error_[i];
      if (step > 0) {
        std::copy_n(&current_[size_t(i) * D], D, theta + size_t(i) * D);
        changed_[i] = 1;
      }
      std::copy_n(features + n * places_.count(), places_.count(), features + size_t(kept) * places_.count());
      going_on_[kept++] = i;
    }
    going_on_.resize(kept);
    if (step == step_count) break;
    generator_->correctionLayers().run(kept, change_.data(), &layer_scratch_);
    for (int n = 0; n < kept; ++n) {
      float* target = &current_[size_t(going_on_[n]) * D];
      for (int d = 0; d < D; ++d) target[d] += change_[size_t(n) * D + d];
    }
  }
  return static_cast<int>(
      std::count_if(changed_.begin(), changed_.begin() + count, [](uint8_t changed) { return changed != 0; }));
}

void Corrector::measure(const StoredFunction* functions, const float* theta, bool want_features) {
  const Representation& representation = generator_->representation();
  const PointOrder& order = pointOrder(representation);
  const int D = places_.theta_count;
  for (size_t n = 0; n < going_on_.size(); ++n) {
    const int i = going_on_[n];
    const float* theta_i = theta + size_t(i) * D;
    int valid_count = 0;
    for (int b = 0; b < order.batchCount(); ++b) {
      const int begin = order.batch_begin[b];
      valid_count += decodeBatch(order, b, functions[i], 0, &function_.phi[begin], &function_.mask[begin]);
    }
    // no point, no error: nothing to lower, the function ends here
    error_[i] = std::numeric_limits<double>::infinity();
    if (valid_count == 0) continue;
    if (!want_features) {
      error_[i] = loss(representation, 0, order.placeCount(), function_.phi.data(), function_.mask.data(), theta_i) / valid_count;
      continue;
    }
    error_[i] = lossAndGradient(representation, 0, order.placeCount(), function_.phi.data(), function_.mask.data(), theta_i,
                                gradient_.data()) /
                valid_count;
    double square = 0.0;
    for (float& value : gradient_) {
      value /= static_cast<float>(valid_count);
      square += static_cast<double>(value) * value;
    }
    const double norm = std::sqrt(square) + 1e-12;
    // a theta so far out that its gradient overflows is left as it is
    if (!std::isfinite(norm)) error_[i] = std::numeric_limits<double>::infinity();
    float* features = layer_scratch_.input() + n * places_.count();
    std::copy_n(&coefficients_[size_t(i) * places_.coefficient_count], places_.coefficient_count, features);
    const float gradient_scale = static_cast<float>(std::sqrt(static_cast<double>(D)) / norm);
    for (int d = 0; d < D; ++d) {
      features[places_.theta() + d] = (theta_i[d] - generator_->theta0()[d]) / generator_->outputScale()[d];
      features[places_.gradient() + d] = gradient_[d] * gradient_scale;
    }
    features[places_.logNorm()] = static_cast<float>(std::log10(norm));
    features[places_.logError()] = static_cast<float>(std::log10(error_[i] + 1e-8));
  }
}

}  // namespace nlg
