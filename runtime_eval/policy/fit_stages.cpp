// Short fits after the correction: Levenberg–Marquardt for product fields, Adam for networks. A function that takes one counts
// as fitted.
#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/policy/stage_runner.h"

namespace nlg {
namespace {

// What counts as progress: three accepted iterations in a row that lower the mean square by less than this share end a stage. The
// fits of direct optimisation go on for far less; here the time is better spent on the next function.
constexpr double kIterationProgress = 0.05;

// Adam: a function whose RMSE is kFullRmse takes the steps that are asked for, others as many as is in proportion, and none more than
// kMostSteps times as many. The same steps in all take a mean error 4 % lower so than evenly (docs/lab/training.md).
constexpr double kFullRmse = 0.01, kMostSteps = 4.0;

// One fit of the tent, so that workspaces have the memory that every later fit needs.
template <class Fit>
void warmUp(const Generator& generator, const Fit& fit) {
  const Representation& representation = generator.representation();
  Theta theta(generator.theta0(), generator.theta0() + representation.thetaCount());
  fit(representation, tentFunction(pointOrder(representation)), theta.data());
}

// The correction: solves the last layer exactly for each function, in networks with a linear output whose weights ask for it.
// No iterative fit. docs/theory/math.md §6.
class LastLayerStage : public StageRun {
 public:
  // generator   with exactLastLayer()
  explicit LastLayerStage(const Generator& generator) : solved_(generator.representation().thetaCount()) {
    // the last hidden values and the constant
    const int feature_count = generator.representation().shape().last() + 1;
    equations_.reset(feature_count, feature_count - 1);
  }
  void run(ThetaBatch& batch, const int* members, int member_count) override {
    for (int n = 0; n < member_count; ++n) {
      const int i = members[n];
      std::copy_n(batch.theta(i), batch.thetaCount(), solved_.begin());
      const WeightingFunction& function = batch.function(i);
      solveLastLayer(batch.representation(), 0, static_cast<int>(function.phi.size()), function.phi.data(), function.mask.data(),
                     solved_.data(), &equations_);
      // of equal theta the one that came stays: it is solved already
      batch.meanSquare(i);
      batch.offer(i, solved_.data(), batch.meanSquareOf(solved_.data()), 1.0);
    }
  }

 private:
  SymmetricBand equations_;
  std::vector<float> solved_;
};

// For product fields, whose normal equations are a band, so that an iteration is cheap. Networks gain more by Adam in the same time,
// the smallest too (docs/lab/training.md).
class LevenbergMarquardtStage : public StageRun {
 public:
  enum class Start { theta, theta0 };
  LevenbergMarquardtStage(const Generator& generator, Start start, int iterations)
      : start_(start),
        options_(refinementLevenbergMarquardt(generator.representation(), iterations)),
        theta_(generator.representation().thetaCount()) {
    options_.progress_tolerance = kIterationProgress;
    warmUp(generator, [&](const Representation& representation, const WeightingFunction& tent, float* theta) {
      LevenbergMarquardtOptions once = options_;
      once.iterations = 1;
      iterateLevenbergMarquardt(representation, tent, once, &kernel_, &workspace_, theta);
    });
  }
  void run(ThetaBatch& batch, const int* members, int member_count) override {
    for (int n = 0; n < member_count; ++n) {
      const int i = members[n];
      batch.meanSquare(i);
      std::copy_n(start_ == Start::theta ? batch.theta(i) : batch.generator().theta0(), batch.thetaCount(), theta_.begin());
      const FitResult fit =
          iterateLevenbergMarquardt(batch.representation(), batch.function(i), options_, &kernel_, &workspace_, theta_.data());
      batch.offer(i, theta_.data(), fit.rmse * fit.rmse, kOfferPays);
    }
  }

 private:
  Start start_;
  LevenbergMarquardtOptions options_;
  NormalEquationsKernel kernel_;
  LevenbergMarquardtWorkspace workspace_;
  std::vector<float> theta_;  // one function
};

class AdamStage : public StageRun {
 public:
  // full_steps   of a function whose RMSE is .01; of others in proportion, four times as many at most
  AdamStage(const Generator& generator, int full_steps)
      : full_steps_(full_steps),
        options_(refinementAdam(generator.representation(), full_steps)),
        theta_(generator.representation().thetaCount()) {
    warmUp(generator, [&](const Representation& representation, const WeightingFunction& tent, float* theta) {
      AdamOptions once = options_;
      once.steps = 1;
      iterateAdam(representation, tent, once, &workspace_, theta);
      solveLastLayer(representation, 0, static_cast<int>(tent.phi.size()), tent.phi.data(), tent.mask.data(), theta,
                     &last_layer_);
    });
  }
  void run(ThetaBatch& batch, const int* members, int member_count) override {
    for (int n = 0; n < member_count; ++n) {
      const int i = members[n];
      const double share = std::min(kMostSteps, std::sqrt(batch.meanSquare(i)) / kFullRmse);
      options_.steps = static_cast<int>(std::clamp(full_steps_ * share, 1.0, double{std::numeric_limits<int>::max()}));
      const WeightingFunction& function = batch.function(i);
      // no step leads away from a theta that is not finite
      std::copy_n(std::isfinite(batch.meanSquare(i)) ? batch.theta(i) : batch.generator().theta0(), batch.thetaCount(),
                  theta_.begin());
      const double rmse = iterateAdam(batch.representation(), function, options_, &workspace_, theta_.data()).rmse;
      batch.offer(i, theta_.data(), rmse * rmse, kOfferPays);
      // its steps end somewhere around the least error: in the last layer the very least is a system of equations away
      const bool is_solved = solveLastLayer(batch.representation(), 0, static_cast<int>(function.phi.size()), function.phi.data(),
                                            function.mask.data(), theta_.data(), &last_layer_);
      if (is_solved) batch.offer(i, theta_.data(), batch.meanSquareOf(theta_.data()), 1.0);
    }
  }

 private:
  int full_steps_;
  AdamOptions options_;
  AdamWorkspace workspace_;
  SymmetricBand last_layer_;
  std::vector<float> theta_;  // one function
};

}  // namespace

std::unique_ptr<StageRun> makeStage(const StagePlan& plan, const Generator& generator) {
  using Start = LevenbergMarquardtStage::Start;
  switch (plan.stage) {
    case ThetaStage::last_layer:
      return std::make_unique<LastLayerStage>(generator);
    case ThetaStage::lm:
      return std::make_unique<LevenbergMarquardtStage>(generator, Start::theta, plan.budget);
    case ThetaStage::lm_theta0:
      return std::make_unique<LevenbergMarquardtStage>(generator, Start::theta0, plan.budget);
    case ThetaStage::adam:
      return std::make_unique<AdamStage>(generator, plan.budget);
    default:
      return nullptr;  // not of one batch: the policy's own
  }
}

}  // namespace nlg
