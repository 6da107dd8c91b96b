#pragma once

#include <algorithm>
#include <cmath>

namespace nlg {

// 1 / (1 + exp(-logit)). From logits below -87 on it stays at 1.6e-38: no exponential overflows, in engines that trap that. NaN of NaN.
template <class Real>
Real logistic(Real logit) {
  return Real(1) / (Real(1) + std::exp(-std::max(logit, Real(-87))));
}

}  // namespace nlg
