#include "runtime_eval/evaluator/generator/projection.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/generator/parity_transform.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Three butterfly stages over the mirrors.
template <class V>
HWY_INLINE void butterflies(V (&value)[kMirrorCount]) {
#pragma GCC unroll 3
  for (int bit = 1; bit < kMirrorCount; bit *= 2) {
#pragma GCC unroll 8
    for (int m = 0; m < kMirrorCount; ++m) {
      if (m & bit) continue;
      const V sum = hn::Add(value[m], value[m | bit]), difference = hn::Sub(value[m], value[m | bit]);
      value[m] = sum;
      value[m | bit] = difference;
    }
  }
}

// Stored functions: on 16-bit integers (8 * 255 fits), then floats.
void bytesToFloats(const uint8_t* HWY_RESTRICT phi, float* HWY_RESTRICT classes) {
  const hn::CappedTag<float, 16> df;
  const hn::Rebind<int32_t, decltype(df)> d32;
  const hn::Rebind<int16_t, decltype(df)> d16;
  const hn::Rebind<uint8_t, decltype(df)> d8;
  for (int i = 0; i < kOctantPointCount; i += static_cast<int>(hn::Lanes(df))) {
    hn::Vec<decltype(d16)> value[kMirrorCount];
#pragma GCC unroll 8
    for (int m = 0; m < kMirrorCount; ++m) value[m] = hn::PromoteTo(d16, hn::LoadU(d8, phi + m * kOctantPointCount + i));
    butterflies(value);
#pragma GCC unroll 8
    for (int c = 0; c < kParityClassCount; ++c) {
      hn::StoreU(hn::ConvertTo(df, hn::PromoteTo(d32, value[c])), df, classes + c * kOctantPointCount + i);
    }
  }
}

void bytesToFloatsAll(const uint8_t* phi, int count, float* classes) {
  for (size_t n = 0; n < static_cast<size_t>(count); ++n) bytesToFloats(phi + n * kSupportPointCount, classes + n * kClassStride);
}
}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(bytesToFloatsAll);

void parityTransform(const uint8_t* phi, int count, float* classes) {
  HWY_DYNAMIC_DISPATCH(bytesToFloatsAll)(phi, count, classes);
}
}  // namespace nlg
#endif  // HWY_ONCE
