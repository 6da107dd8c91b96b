// The correction: solves the last layer exactly for each function, in networks with a linear output whose weights ask for it.
// No iterative fit. docs/theory/math.md §6.
#pragma once

#include <vector>

#include "nlg/policy.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/policy/theta_batch.h"

namespace nlg {

class LastLayerStage : public StageRun {
 public:
  // generator   with exactLastLayer()
  explicit LastLayerStage(const Generator& generator);
  void run(ThetaBatch& batch, const int* members, int member_count) override;

 private:
  SymmetricBand equations_;
  std::vector<float> solved_;
};

}  // namespace nlg
