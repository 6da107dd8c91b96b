// Elementary functions of vectors of floats, for any Highway target. Included once per target; see Highway's quick reference
// on "-inl.h".
#if defined(NLG_ELEMENTARY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NLG_ELEMENTARY_INL_H_
#undef NLG_ELEMENTARY_INL_H_
#else
#define NLG_ELEMENTARY_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 16>;
using Floats = hn::Vec<FloatTag>;

// The value limited to [low, high]; what is no number stays so.
HWY_INLINE Floats limit(Floats value, Floats low, Floats high) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR
  return hn::Max(low, hn::Min(high, value));  // of these, NaN in the second argument is the result
#else
  value = hn::IfThenElse(hn::Gt(value, high), high, value);
  return hn::IfThenElse(hn::Lt(value, low), low, value);
#endif
}

struct Sigmoid {
  Floats value, complement;  // sigmoid(b) and 1 - sigmoid(b), each to its own relative accuracy
};

// 1 / (1 + exp(-b)) to 3 units in the last place for |b| <= 87, constant beyond: 1, or 1.6e-38. Not finite only where b is NaN.
HWY_INLINE Sigmoid sigmoid(FloatTag d, Floats b) {
  // exp(-b) = 2^n exp(-r), r = b + n ln 2, |r| <= ln 2 / 2.
  const Floats limited = limit(b, hn::Set(d, -87.0f), hn::Set(d, 87.0f));
  // added to a number below 2^22, this leaves its nearest integer in the low bits, here with the exponent's bias of 127
  const Floats shift = hn::Set(d, 0x1.8p23f + 127.0f);
  const Floats shifted = hn::NegMulAdd(limited, hn::Set(d, 1.44269504f), shift);
  const Floats n = hn::Sub(shifted, shift);
  // ln 2 in two parts; n times the first is exact
  Floats r = hn::MulAdd(n, hn::Set(d, 0x1.62e4p-1f), limited);
  r = hn::MulAdd(n, hn::Set(d, 1.42860677e-6f), r);
  // interpolates exp(-r) at Chebyshev nodes: relative error 9e-9
  Floats e = hn::MulAdd(r, hn::Set(d, 0.001384041531f), hn::Set(d, -0.008363232884f));
  e = hn::MulAdd(r, e, hn::Set(d, 0.04166784554f));
  e = hn::MulAdd(r, e, hn::Set(d, -0.1666657667f));
  e = hn::MulAdd(r, e, hn::Set(d, 0.4999999611f));
  e = hn::MulAdd(r, e, hn::Set(d, -1.0f));
  const Floats one = hn::Set(d, 1.0f);
  e = hn::MulAdd(r, e, one);
  const hn::RebindToUnsigned<FloatTag> bits;
  e = hn::Mul(e, hn::BitCast(d, hn::ShiftLeft<23>(hn::BitCast(bits, shifted))));
  const Floats value = hn::Div(one, hn::Add(one, e));
  return {value, hn::Mul(e, value)};
}

HWY_INLINE Floats clampToUnit(FloatTag d, Floats a) { return limit(a, hn::Zero(d), hn::Set(d, 1.0f)); }

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();
#endif
