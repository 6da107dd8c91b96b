#include "runtime_eval/fit/adam.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/fit/adam_update.h"
#include "runtime_eval/fit/loss_kernel.h"
#include "runtime_eval/support/finite.h"
#include "runtime_eval/support/random.h"

namespace nlg {
namespace {

// A minibatch: places from `first` on, and how many of them are valid.
struct Minibatch {
  int first = 0, valid_count = 0;
};

// Minibatches in a fresh random order every round; those without a valid point are left out.
class MinibatchOrder {
 public:
  MinibatchOrder(const PointOrder& points, int places, const WeightingFunction& function, uint64_t seed) : random_(seed) {
    for (int first = 0; first < points.placeCount(); first += places) {
      Minibatch batch{first, 0};
      for (int i = first; i < first + places; ++i) batch.valid_count += function.mask[i] > 0.0f;
      if (batch.valid_count > 0) order_.push_back(batch);
    }
  }
  bool empty() const { return order_.empty(); }
  Minibatch next() {
    if (position_ == 0) {
      for (size_t i = order_.size(); i > 1; --i) std::swap(order_[i - 1], order_[random_.below(static_cast<uint32_t>(i))]);
    }
    const Minibatch batch = order_[position_];
    position_ = (position_ + 1) % order_.size();
    return batch;
  }

 private:
  Random random_;
  std::vector<Minibatch> order_;
  size_t position_ = 0;
};

FitResult runAdam(const Representation& representation, const WeightingFunction& function, const Theta& start,
                  const AdamOptions& options) {
  FitResult result{start, functionRmse(representation, function, start.data()), 0, FitStop::budget};
  const PointOrder& points = pointOrder(representation);
  const int places = options.full_batch ? points.placeCount() : points.minibatch_places;
  MinibatchOrder order(points, places, function, options.seed);
  if (order.empty()) {
    result.stop = FitStop::no_points;
    return result;
  }
  if (!std::isfinite(result.rmse)) {
    result.stop = FitStop::not_finite;
    return result;
  }
  Theta theta = start;
  AdamMoments moments(static_cast<int>(theta.size()));
  Theta gradient(theta.size());
  for (; result.steps < options.steps; ++result.steps) {
    const Minibatch batch = order.next();
    lossAndGradient(representation, batch.first, places, &function.phi[batch.first], &function.mask[batch.first], theta.data(),
                    gradient.data());
    const float scale = 1.0f / static_cast<float>(batch.valid_count);
    const double phase = static_cast<double>(result.steps) / options.steps;
    const double rate = options.learning_rate * 0.5 * (1.0 + std::cos(M_PI * phase));
    moments.step(rate, options.beta1, options.beta2, scale, gradient.data(), theta.data());
    if (!allFinite(theta)) {
      result.stop = FitStop::not_finite;
      return result;
    }
  }
  const double rmse = functionRmse(representation, function, theta.data());
  if (rmse < result.rmse) result.theta = theta, result.rmse = rmse;
  return result;
}

}  // namespace

const char* fitStopName(FitStop stop) {
  switch (stop) {
    case FitStop::budget:
      return "budget";
    case FitStop::gradient:
      return "gradient";
    case FitStop::progress:
      return "progress";
    case FitStop::damping:
      return "damping";
    case FitStop::no_points:
      return "no_points";
    case FitStop::not_finite:
      return "not_finite";
  }
  return "unknown";
}

double functionRmse(const Representation& representation, const WeightingFunction& function, const float* theta) {
  const int valid_count = function.validCount();
  if (valid_count == 0) return 0.0;
  if (!allFinite({theta, static_cast<size_t>(representation.thetaCount())})) return std::numeric_limits<double>::infinity();
  const PointOrder& order = pointOrder(representation);
  const double sum = loss(representation, 0, order.placeCount(), function.phi.data(), function.mask.data(), theta);
  return std::sqrt(sum / valid_count);
}

AdamOptions refinementAdam(const Representation& representation, int steps) {
  AdamOptions options;
  options.steps = steps;
  options.learning_rate = representation.isField() ? 0.1 : 0.02;
  return options;
}

AdamOptions randomStartAdam(int steps) {
  AdamOptions options;
  options.steps = steps;
  options.learning_rate = 0.03;
  return options;
}

FitResult fitAdam(const Representation& representation, const WeightingFunction& function, const Theta& start,
                  const AdamOptions& options) {
  return timedFit([&] { return runAdam(representation, function, start, options); });
}

namespace {

Theta randomNetworkTheta(const NetworkShape& shape, uint64_t seed) {
  Random random(mixSeed(seed, 0x7468657461));
  Theta theta(shape.thetaCount());
  const auto fill = [&](int first, int end, double deviation) {
    for (int i = first; i < end; ++i) theta[i] = static_cast<float>(deviation * random.normal());
  };
  fill(shape.w1(), shape.b1(), std::sqrt(2.0 / 3.0));
  fill(shape.b1(), shape.w2(), 0.5);
  fill(shape.w2(), shape.b2(), std::sqrt(2.0 / shape.first));
  fill(shape.b2(), shape.w3(), 0.2);
  fill(shape.w3(), shape.b3(), std::sqrt(1.0 / shape.last()));
  return theta;
}

// A field that starts near the tent's height and is free to move: no node beyond the clamp.
Theta randomFieldTheta(int count, uint64_t seed) {
  Random random(mixSeed(seed, 0x6669656c64));
  Theta theta(count);
  for (int i = 0; i < count; i += 2) {
    theta[i] = static_cast<float>(random.uniform(0.2, 0.8));
    theta[i + 1] = static_cast<float>(0.5 * random.normal());
  }
  return theta;
}

}  // namespace

Theta randomTheta(const Representation& representation, uint64_t seed) {
  return representation.isField() ? randomFieldTheta(representation.thetaCount(), seed)
                                  : randomNetworkTheta(representation.shape(), seed);
}

}  // namespace nlg
