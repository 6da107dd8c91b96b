#include "runtime_eval/evaluator/projection.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/projection.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Three butterfly stages on 16-bit integers (8 * 255 fits), then floats.
HWY_INLINE void parityTransformOne(const uint8_t* HWY_RESTRICT phi, float* HWY_RESTRICT classes) {
  const hn::CappedTag<float, 16> df;
  const hn::Rebind<int32_t, decltype(df)> d32;
  const hn::Rebind<int16_t, decltype(df)> d16;
  const hn::Rebind<uint8_t, decltype(df)> d8;
  const int lanes = static_cast<int>(hn::Lanes(df));
  for (int i = 0; i < kOctantPointCount; i += lanes) {
    hn::Vec<decltype(d16)> value[kMirrorCount];
#pragma GCC unroll 8
    for (int m = 0; m < kMirrorCount; ++m) value[m] = hn::PromoteTo(d16, hn::LoadU(d8, phi + m * kOctantPointCount + i));
#pragma GCC unroll 3
    for (int bit = 1; bit < kMirrorCount; bit *= 2) {
#pragma GCC unroll 8
      for (int m = 0; m < kMirrorCount; ++m) {
        if (m & bit) continue;
        const auto sum = hn::Add(value[m], value[m | bit]), difference = hn::Sub(value[m], value[m | bit]);
        value[m] = sum;
        value[m | bit] = difference;
      }
    }
#pragma GCC unroll 8
    for (int c = 0; c < kParityClassCount; ++c) {
      hn::StoreU(hn::ConvertTo(df, hn::PromoteTo(d32, value[c])), df, classes + c * kOctantPointCount + i);
    }
  }
}

void parityTransformAll(const uint8_t* HWY_RESTRICT phi, int count, float* HWY_RESTRICT classes) {
  for (size_t n = 0; n < static_cast<size_t>(count); ++n) {
    parityTransformOne(phi + n * kSupportPointCount, classes + n * kSupportPointCount);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(parityTransformAll);

void parityTransform(const uint8_t* phi, int count, float* classes) {
  HWY_DYNAMIC_DISPATCH(parityTransformAll)(phi, count, classes);
}

Projection::Projection(const BasisData& basis) : coefficient_count_(basis.coefficientCount()), bias_(coefficient_count_) {
  const double dequantise = 1.0 / (255.0 * std::sqrt(8.0));
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    const int count = basis.class_count[c];
    std::vector<float> rows(size_t(count) * kOctantPointCount);
    for (int k = 0; k < count; ++k) {
      const float* component = &basis.components[size_t(first + k) * kOctantPointCount];
      const float* mean = &basis.mean[size_t(c) * kOctantPointCount];
      const double inverse_deviation = 1.0 / basis.deviation[first + k];
      double mean_coefficient = 0.0;
      for (int i = 0; i < kOctantPointCount; ++i) {
        rows[size_t(k) * kOctantPointCount + i] = static_cast<float>(component[i] * dequantise * inverse_deviation);
        mean_coefficient += static_cast<double>(mean[i]) * component[i];
      }
      bias_[first + k] = static_cast<float>(-mean_coefficient * inverse_deviation);
    }
    components_[c] = PackedMatrix(rows.data(), count, kOctantPointCount);
    first += count;
  }
}

void Projection::project(const uint8_t* phi, int count, float* coefficients, float* scratch) const {
  parityTransform(phi, count, scratch);
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    if (components_[c].outputCount() == 0) continue;
    multiply({scratch + c * kOctantPointCount, kSupportPointCount}, count, components_[c], &bias_[first], Epilogue::none, 1.0f,
             coefficients + first, coefficient_count_);
    first += components_[c].outputCount();
  }
}

}  // namespace nlg
#endif  // HWY_ONCE
