// Trains one network, with its tables if it has some, on one thread.
#pragma once

#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "runtime_eval/numbers/random.h"

namespace nlg {

// What is trained. Its parameters are flat tensors of floats that take gradients.
class Learner {
 public:
  virtual ~Learner() = default;
  virtual std::vector<torch::Tensor>& parameters() = 0;
  // Of a batch by chance: a scalar, differentiable by parameters().
  virtual torch::Tensor loss(Random* random) = 0;
  // Of what is held out, always the same.
  virtual double heldOutLoss() = 0;
};

// The rate falls as half a cosine from `rate` to 0 over `steps`. Every `check_steps` the held-out loss is measured; the parameters that
// it was least with are those that are kept, and training ends early when `patience` checks in a row found none better.
struct TrainingOptions {
  int steps = 3000;
  int check_steps = 100;
  int patience = 10;
  float rate = 5e-3f;
  uint64_t seed = 1;
};

struct TrainingRecord {
  int steps = 0;               // done
  int best_step = 0;           // whose parameters were kept
  double held_out_loss = 0.0;  // with these
  double processor_s = 0.0;    // of the calling thread
};

// Adam (Kingma and Ba, 2015), β .9 and .99. Numbers whose gradient is 0 stand still, as those of table rows that no sample of a batch
// reads do in Müller et al., "Instant Neural Graphics Primitives" (SIGGRAPH 2022).
// The same bits for the same seed, on one machine.
// throws   NumericalError on a loss that is not finite
TrainingRecord train(Learner* learner, const TrainingOptions& options);

// Σ (prediction - target)² / (prediction² + kLossFloor²), its mean, where the divisor is a constant to gradients: errors count as shares
// of the light (Lehtinen et al., "Noise2Noise", 2018; Müller et al., "Real-time Neural Radiance Caching", 2021).
inline constexpr double kLossFloor = 0.1;
torch::Tensor relativeSquares(const torch::Tensor& prediction, const torch::Tensor& target);

// The same over the mean of both squares: what tells that training should end. An answer near 0 where there is light counts 2 at most;
// above it would count hundreds, and a handful of such places would say when.
double evenSquares(const torch::Tensor& prediction, const torch::Tensor& target);

// Mean of |prediction - target| / (|prediction| + |target| + kShareFloor): SMAPE, as the talk recommends it.
inline constexpr double kShareFloor = 0.01;
torch::Tensor symmetricShares(const torch::Tensor& prediction, const torch::Tensor& target);

}  // namespace nlg
