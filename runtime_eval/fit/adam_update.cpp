#include "runtime_eval/fit/adam_update.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/adam_update.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

#ifndef NLG_ADAM_FACTORS
#define NLG_ADAM_FACTORS
namespace nlg {
// The numbers of one step.
struct AdamFactors {
  float beta1, beta2, rate, square_scale, gradient_scale;
};
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
HWY_INLINE void updateVector(D d, const AdamFactors& factors, const float* HWY_RESTRICT gradient, float* HWY_RESTRICT mean,
                             float* HWY_RESTRICT square, float* HWY_RESTRICT theta) {
  const auto g = hn::Mul(hn::LoadU(d, gradient), hn::Set(d, factors.gradient_scale));
  const auto m = hn::MulAdd(hn::Set(d, factors.beta1), hn::LoadU(d, mean), hn::Mul(hn::Set(d, 1.0f - factors.beta1), g));
  const auto v =
      hn::MulAdd(hn::Set(d, factors.beta2), hn::LoadU(d, square), hn::Mul(hn::Set(d, 1.0f - factors.beta2), hn::Mul(g, g)));
  const auto root = hn::Add(hn::Sqrt(hn::Mul(v, hn::Set(d, factors.square_scale))), hn::Set(d, 1e-8f));
  hn::StoreU(m, d, mean);
  hn::StoreU(v, d, square);
  hn::StoreU(hn::Sub(hn::LoadU(d, theta), hn::Div(hn::Mul(hn::Set(d, factors.rate), m), root)), d, theta);
}

void updateAll(const AdamFactors& factors, int64_t count, const float* HWY_RESTRICT gradient, float* HWY_RESTRICT mean,
               float* HWY_RESTRICT square, float* HWY_RESTRICT theta) {
  const hn::CappedTag<float, 16> d;
  const int64_t lanes = static_cast<int64_t>(hn::Lanes(d));
  int64_t i = 0;
  for (; i + lanes <= count; i += lanes) updateVector(d, factors, gradient + i, mean + i, square + i, theta + i);
  const hn::CappedTag<float, 1> one;
  for (; i < count; ++i) updateVector(one, factors, gradient + i, mean + i, square + i, theta + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(updateAll);

void AdamMoments::reset(int count) {
  mean_.assign(count, 0.0f);
  square_.assign(count, 0.0f);
  mean_power_ = square_power_ = 1.0;
}

void AdamMoments::step(double learning_rate, double beta1, double beta2, float gradient_scale, const float* gradient,
                       float* theta) {
  mean_power_ *= beta1;
  square_power_ *= beta2;
  adamUpdate({learning_rate, beta1, beta2, mean_power_, square_power_, gradient_scale}, static_cast<int64_t>(mean_.size()),
             gradient, mean_.data(), square_.data(), theta);
}

void adamUpdate(const AdamStep& step, int64_t count, const float* gradient, float* mean, float* square, float* theta) {
  const AdamFactors factors = {static_cast<float>(step.beta1), static_cast<float>(step.beta2),
                               static_cast<float>(step.learning_rate / (1.0 - step.beta1_power)),
                               static_cast<float>(1.0 / (1.0 - step.beta2_power)), step.gradient_scale};
  HWY_DYNAMIC_DISPATCH(updateAll)(factors, count, gradient, mean, square, theta);
}

}  // namespace nlg
#endif  // HWY_ONCE
