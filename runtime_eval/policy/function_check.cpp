#include "nlg/check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/support/weighting_function.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/policy/function_check.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

#ifndef NLG_FUNCTION_CHECK_SUMS
#define NLG_FUNCTION_CHECK_SUMS
namespace nlg {
struct CheckSums {
  double square = 0.0;                    // of the residuals at valid points
  double loss = 0.0;                      // of the weighed ones
  double leak = 0.0;                      // of |value| at valid points whose phi is 0
  int32_t valid = 0, zero = 0, over = 0;  // valid points; of these those whose phi is 0; of these those that leak
};
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Sums over all support points; float inside an octant, double over octants.
void compareVectors(const float* HWY_RESTRICT values, const float* HWY_RESTRICT tent, const StoredFunction& stored,
                    const CheckOptions& options, CheckSums& sums) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto lane_bit = hn::Shl(hn::Set(di, 1), hn::Iota(di, 0));
  const auto zero = hn::Zero(d), scale = hn::Set(d, 1.0f / 255.0f);
  const auto share = hn::Set(d, static_cast<float>(options.tau_leak)), rim = hn::Set(d, kRimTent);
  const auto dark_weight = hn::Set(d, static_cast<float>(options.dark_weight)),
             floor = hn::Set(d, static_cast<float>(options.blend_floor));
  const auto unit = hn::Set(d, 1.0f);
  const auto one = hn::Set(di, 1), none = hn::Zero(di);
  for (int begin = 0; begin < kSupportPointCount; begin += kOctantPointCount) {
    auto square = zero, loss = zero, leak = zero;
    auto valid_count = none, zero_count = none, over_count = none;
    for (int i = begin; i < begin + kOctantPointCount; i += lanes) {
      // the bits of these points: lanes divides 8 or is 8 or 16
      int32_t bits = stored.validity[i / 8] >> (i % 8);
      if (lanes > 8) bits |= stored.validity[i / 8 + 1] << 8;
      const auto valid = hn::RebindMask(d, hn::Ne(hn::And(hn::Set(di, bits), lane_bit), none));
      const auto phi = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d8, stored.phi + i)));
      const auto value = hn::Load(d, values + i);
      const auto residual = hn::IfThenElseZero(valid, hn::NegMulAdd(phi, scale, value));
      square = hn::MulAdd(residual, residual, square);
      // a dark point leaks beyond a share of its tent; kRimTent forgives the border, where the tent itself is almost 0
      const auto tents = hn::Load(d, tent + i), limit = hn::MulAdd(share, tents, rim);
      const auto dark = hn::And(valid, hn::Eq(phi, zero));
      const auto magnitude = hn::IfThenElseZero(dark, hn::Abs(value));
      // LossWeights::root, squared
      auto lit_weight = unit;
      if (stored.blend_sum != nullptr) {
        const auto sum = hn::Mul(hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d8, stored.blend_sum + i))), scale);
        const auto root = hn::Div(unit, hn::Max(sum, floor));
        lit_weight = hn::IfThenElse(dark, unit, hn::Mul(root, root));
      }
      // m² of docs/theory/math.md §4; a dark point at the border, whose tent is almost 0 too, weighs 1
      const auto weight = hn::IfThenElse(hn::And(dark, hn::Gt(tents, rim)), dark_weight, lit_weight);
      loss = hn::MulAdd(hn::Mul(weight, residual), residual, loss);
      leak = hn::Add(leak, magnitude);
      valid_count = hn::Add(valid_count, hn::IfThenElseZero(hn::RebindMask(di, valid), one));
      zero_count = hn::Add(zero_count, hn::IfThenElseZero(hn::RebindMask(di, dark), one));
      over_count = hn::Add(over_count, hn::IfThenElseZero(hn::RebindMask(di, hn::Gt(magnitude, limit)), one));
    }
    sums.square += hn::GetLane(hn::SumOfLanes(d, square));
    sums.loss += hn::GetLane(hn::SumOfLanes(d, loss));
    sums.leak += hn::GetLane(hn::SumOfLanes(d, leak));
    sums.valid += hn::GetLane(hn::SumOfLanes(di, valid_count));
    sums.zero += hn::GetLane(hn::SumOfLanes(di, zero_count));
    sums.over += hn::GetLane(hn::SumOfLanes(di, over_count));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {
namespace {

const PointSet& patternPoints() {
  static const PointSet points = makePointSet(supportPattern().points);
  return points;
}

// Of the cell order that fills most places up.
int mostPlaces() {
  int most = 0;
  for (const int resolution : kFieldResolutions) most = std::max(most, cellOrder(resolution).placeCount());
  return most;
}

}  // namespace

HWY_EXPORT(compareVectors);

double FunctionCheck::trouble(const CheckOptions& options) const {
  if (!std::isfinite(rmse) || !std::isfinite(blend_rmse)) return std::numeric_limits<double>::infinity();
  return std::max(rmse / options.tau_rmse, blend_rmse / options.tau_blend);
}

struct FunctionChecker::Buffers {
  AlignedFloats values = AlignedFloats(patternPoints().padded_count);  // pattern order
  AlignedFloats cell_values = AlignedFloats(mostPlaces());             // by place of a cell order
  AlignedFloats tent = AlignedFloats(patternPoints().padded_count);    // pattern order
  std::vector<uint8_t> tent_byte = std::vector<uint8_t>(kSupportPointCount);
};

FunctionChecker::FunctionChecker() : buffers_(std::make_unique<Buffers>()) {
  for (int p = 0; p < kSupportPointCount; ++p) {
    buffers_->tent[p] = tent(supportPattern().points[p]);
    buffers_->tent_byte[p] = static_cast<uint8_t>(std::lround(255.0f * buffers_->tent[p]));
  }
}
FunctionChecker::~FunctionChecker() = default;
FunctionChecker::FunctionChecker(FunctionChecker&&) noexcept = default;
FunctionChecker& FunctionChecker::operator=(FunctionChecker&&) noexcept = default;

FunctionCheck FunctionChecker::check(const Representation& representation, const StoredFunction& stored, const float* theta,
                                     const CheckOptions& options) {
  // cell by cell fields and codes are several times faster; their values then go into the pattern's order
  if (!representation.isNetwork()) {
    const PointOrder& order = pointOrder(representation);
    if (representation.isCode()) {
      alignas(64) float logits[kMaxBrickStride];
      roundedLogits(*representation.dictionary, theta, logits);
      evaluateLogitCells(order, logits, buffers_->cell_values.data());
    } else {
      evaluateFieldCells(order, theta, buffers_->cell_values.data());
    }
    for (int place = 0; place < order.placeCount(); ++place) {
      if (order.pattern_index[place] >= 0) buffers_->values[order.pattern_index[place]] = buffers_->cell_values[place];
    }
  } else {
    evaluate(representation, patternPoints(), theta, buffers_->values.data());
  }
  FunctionCheck result = compare(buffers_->values.data(), stored, options);
  // a theta with a NaN or an infinity fails, even where clamps make its values finite
  const bool is_finite = allFinite({theta, static_cast<size_t>(representation.thetaCount())});
  if (!is_finite) result.rmse = result.blend_rmse = std::numeric_limits<double>::infinity();
  return result;
}

FunctionCheck FunctionChecker::checkBareTent(const StoredFunction& stored, const CheckOptions& options) {
  StoredFunction function = stored;
  if (!isPartlyLit(stored)) function.blend_sum = nullptr;
  return compare(buffers_->tent.data(), function, options);
}

bool FunctionChecker::isPartlyLit(const StoredFunction& stored) const {
  // a byte beside the tent's own may be rounding
  int partly = 0;
  for (int p = 0; p < kSupportPointCount; ++p) partly += stored.phi[p] != 0 && stored.phi[p] + 1 < buffers_->tent_byte[p];
  return partly > 0;
}

FunctionCheck FunctionChecker::compare(const float* values, const StoredFunction& stored, const CheckOptions& options) const {
  CheckSums sums;
  HWY_DYNAMIC_DISPATCH(compareVectors)(values, buffers_->tent.data(), stored, options, sums);
  FunctionCheck result;
  result.valid_count = sums.valid;
  result.zero_count = sums.zero;
  if (sums.valid > 0) {
    result.rmse = std::sqrt(sums.square / sums.valid);
    result.blend_rmse = std::sqrt(sums.loss / sums.valid);
  }
  if (sums.zero > 0) {
    result.leak_mean = sums.leak / sums.zero;
    result.leak_share = static_cast<double>(sums.over) / sums.zero;
  }
  // finite theta may have values that are none: an error that is no number is the largest there is
  for (double* error : {&result.rmse, &result.blend_rmse, &result.leak_mean}) {
    if (std::isnan(*error)) *error = std::numeric_limits<double>::infinity();
  }
  return result;
}

}  // namespace nlg
#endif  // HWY_ONCE
