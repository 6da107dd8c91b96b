#include "runtime_eval/fit/adam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/loss/loss_kernel.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/flush_subnormals.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
class AdamRun {
 public:
  AdamRun(const Representation& representation, const WeightingFunction& function, const AdamOptions& options,
          AdamWorkspace* workspace)
      : representation_(representation), function_(function), options_(options), work_(*workspace), random_(options.seed) {
    const PointOrder& points = pointOrder(representation);
    places_ = options.full_batch ? points.placeCount() : points.minibatch_places;
    work_.order_.clear();
    for (int first = 0; first < points.placeCount(); first += places_) {
      AdamWorkspace::Minibatch batch{first, 0};
      for (int i = first; i < first + places_; ++i) batch.valid_count += function.mask[i] > 0.0f;
      if (batch.valid_count > 0) work_.order_.push_back(batch);
    }
  }

  FitResult run(float* theta) {
    FitResult result{{}, functionRmse(representation_, function_, theta), 0, FitStop::budget};
    if (work_.order_.empty()) {
      result.stop = FitStop::no_points;
      return result;
    }
    if (!std::isfinite(result.rmse)) {
      result.stop = FitStop::not_finite;
      return result;
    }
    // the steps move a copy: theta keeps its start until the end is known to be better
    const int count = representation_.thetaCount();
    work_.moving_.assign(theta, theta + count);
    work_.gradient_.resize(count);
    if (runsInEigenbasis()) {
      work_.soap_moments_.reset(representation_);
    } else {
      work_.moments_.reset(count);
    }
    for (; result.steps < options_.steps; ++result.steps) {
      step(result.steps);
      if (!allFinite(work_.moving_)) {
        result.stop = FitStop::not_finite;
        return result;
      }
    }
    // the better of the two by blend RMSE: steps of minibatches may end higher than they began (docs/theory/math.md §5)
    const double rmse = functionRmse(representation_, function_, work_.moving_.data());
    if (rmse < result.rmse) {
      std::copy(work_.moving_.begin(), work_.moving_.end(), theta);
      result.rmse = rmse;
    }
    return result;
  }

 private:
  bool runsInEigenbasis() const { return options_.eigenbasis && representation_.isNetwork(); }

  void step(int number) {
    const AdamWorkspace::Minibatch batch = next();
    lossAndGradient(representation_, batch.first, places_, &function_.phi[batch.first], &function_.mask[batch.first],
                    work_.moving_.data(), work_.gradient_.data());
    // the gradient is a sum: as a mean over valid points, a minibatch with few of them counts like a full one
    const float scale = 1.0f / static_cast<float>(batch.valid_count);
    // cosine annealing: the rate falls towards 0, and with it the noise of minibatches
    const double phase = static_cast<double>(number) / options_.steps;
    const double rate = options_.learning_rate * 0.5 * (1.0 + std::cos(std::numbers::pi * phase));
    const auto move = [&](auto& moments) {
      moments.step(rate, options_.beta1, options_.beta2, scale, work_.gradient_.data(), work_.moving_.data());
    };
    if (runsInEigenbasis()) {
      move(work_.soap_moments_);
    } else {
      move(work_.moments_);
    }
  }

  // In a fresh random order every round; those without a valid point are left out.
  AdamWorkspace::Minibatch next() {
    std::vector<AdamWorkspace::Minibatch>& order = work_.order_;
    if (position_ == 0) {
      for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random_.below(static_cast<uint32_t>(i))]);
    }
    const AdamWorkspace::Minibatch batch = order[position_];
    position_ = (position_ + 1) % order.size();
    return batch;
  }

  const Representation& representation_;
  const WeightingFunction& function_;
  const AdamOptions& options_;
  AdamWorkspace& work_;
  Random random_;
  int places_ = 0;
  size_t position_ = 0;
};

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

// Of numbers that are counted in steps.
constexpr double kCodeRate = 1.0;

AdamOptions refinementAdam(const Representation& representation, int steps) {
  AdamOptions options;
  options.steps = steps;
  options.learning_rate = representation.isCode()       ? kCodeRate
                          : representation.isField()    ? 0.1
                          : representation.tentFactor() ? 0.04
                                                        : 0.02;
  return options;
}

AdamOptions randomStartAdam(const Representation& representation, int steps) {
  // one start of a code is as good as another
  if (representation.isCode()) return refinementAdam(representation, steps);
  AdamOptions options;
  options.steps = steps;
  options.learning_rate = 0.03;
  return options;
}

FitResult iterateAdam(const Representation& representation, const WeightingFunction& function, const AdamOptions& options,
                      AdamWorkspace* workspace, float* theta) {
  const FlushSubnormals flush;
  return AdamRun(representation, function, options, workspace).run(theta);
}

FitResult fitAdam(const Representation& representation, const WeightingFunction& function, const Theta& start,
                  const AdamOptions& options) {
  return timedFit([&] {
    AdamWorkspace workspace;
    Theta theta = start;
    FitResult result = iterateAdam(representation, function, options, &workspace, theta.data());
    result.theta = std::move(theta);
    return result;
  });
}

namespace {

Theta randomNetworkTheta(const NetworkShape& shape, uint64_t seed) {
  Random random(mixSeed(seed, 0x7468657461));
  Theta theta(shape.thetaCount());
  const auto fill = [&](int first, int end, double deviation) {
    for (int i = first; i < end; ++i) theta[i] = static_cast<float>(deviation * random.normal());
  };
  // He's initialisation of the hidden layers; biases away from 0 spread the kinks over the support
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

Theta randomCode(const Dictionary& dictionary, uint64_t seed) {
  Random random(mixSeed(seed, 0x636f6465));
  Theta theta;
  for (int k = 0; k < dictionary.codeCount(); ++k)
    theta.push_back(static_cast<float>(dictionary.deviations()[k] * random.normal()));
  return theta;
}

}  // namespace

Theta randomTheta(const Representation& representation, uint64_t seed) {
  if (representation.isCode()) return randomCode(*representation.dictionary, seed);
  return representation.isField() ? randomFieldTheta(representation.thetaCount(), seed)
                                  : randomNetworkTheta(representation.shape(), seed);
}

}  // namespace nlg
