#include "runtime_eval/policy/last_layer_stage.h"

#include <algorithm>

#include "runtime_eval/fit/last_layer.h"

namespace nlg {

LastLayerStage::LastLayerStage(const Generator& generator) : solved_(generator.representation().thetaCount()) {
  // the last hidden values and the constant
  const int feature_count = generator.representation().shape().last() + 1;
  equations_.reset(feature_count, feature_count - 1);
}

void LastLayerStage::run(ThetaBatch& batch, const int* members, int member_count) {
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

}  // namespace nlg
