#include "runtime_eval/fit/code_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime_eval/fit/loss/loss_kernel.h"
#include "runtime_eval/numbers/finite.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/code_fit.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/brick-inl.h"

#ifndef NLG_CODE_FIT_ONCE
#define NLG_CODE_FIT_ONCE
namespace nlg {

// Points whose rows are made and multiplied together: their rows stay in the level-1 cache.
constexpr int kRowsAtOnce = 64;

// A point is active where it is wrong by more than kWrong, or where the sigmoid's slope is above kMoving; and its row is not all but 0.
constexpr float kWrong = 0.01f, kMoving = 0.02f, kLeastSlope = 1e-3f;

constexpr int kCellsASum = 64;

// What the sigmoid may be off, weighed, in a cell that a pass leaves out.
constexpr float kSettledError = 0.005f;
// phi is stored in steps of a 255th: a point is open where it is within this of the tent.
constexpr float kOpenMargin = 2.5f / 255;

struct PassInput {
  const PointOrder& order;
  const float *phi, *mask, *logits;
  const CellLimits* limits;  // by cell; null: no cell is left out
  float dark_root, kappa;
  float moving, least_slope;  // kMoving and kLeastSlope, or what leaves no point out
};
struct PassOutput {
  int* place;
  float *slope, *residual;
  int active_count;
  double lit_square, dark_square;
};

}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// A cell whose points are all open, or all shut, is settled where the sigmoid agrees: at its corners, and so between them.
void findCellLimits(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, CellLimits* limits) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  constexpr float kNever = std::numeric_limits<float>::infinity();
  for (int c = 0; c < cell_count; ++c) {
    // of the cell's valid points: the largest weight, how far phi falls below the tent, and the largest phi
    Floats weights = hn::Zero(d), below_tent = hn::Zero(d), light = hn::Zero(d);
    for (int place = order.cell_begin[c]; place < order.cell_begin[c + 1]; place += lanes) {
      const Floats weight = hn::Load(d, mask + place), value = hn::Load(d, phi + place);
      const auto is_valid = hn::Gt(weight, hn::Zero(d));
      weights = hn::Max(weights, weight);
      below_tent = hn::Max(below_tent, hn::IfThenElseZero(is_valid, hn::Sub(hn::Load(d, &order.points.tent[place]), value)));
      light = hn::Max(light, hn::IfThenElseZero(is_valid, value));
    }
    const float weight = hn::GetLane(hn::MaxOfLanes(d, weights));
    const bool is_open = hn::GetLane(hn::MaxOfLanes(d, below_tent)) <= kOpenMargin;
    const bool is_shut = hn::GetLane(hn::MaxOfLanes(d, light)) == 0.0f;
    // of a sigmoid that is nearly 1 or 0, exp(-|logit|) is what is missing; a cell without valid points is settled anyhow
    const float settled = weight > 0.0f ? std::log(weight / kSettledError) : -kNever;
    limits[c] = {is_open ? settled : kNever, is_shut ? -settled : -kNever};
  }
}

bool isSettled(const CellLimits& limits, int resolution, const float* corner) {
  if (std::isinf(limits.open) && std::isinf(limits.shut)) return limits.open < 0.0f;
  float lowest = corner[0], highest = corner[0];
  for (int u = 1; u < 8; ++u) {
    const float logit = corner[(u & 1) + resolution * ((u >> 1 & 1) + resolution * (u >> 2))];
    lowest = std::min(lowest, logit);
    highest = std::max(highest, logit);
  }
  return lowest > limits.open || highest < limits.shut;
}

void passVectors(const PassInput& in, PassOutput& out) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const PointOrder& order = in.order;
  const int lanes = static_cast<int>(hn::Lanes(d)), cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(order.resolution - 1)), one = hn::Set(d, 1.0f);
  const Floats dark_root = hn::Set(d, in.dark_root), kappa = hn::Set(d, in.kappa);
  const Floats wrong = hn::Set(d, kWrong), moving = hn::Set(d, in.moving), least = hn::Set(d, in.least_slope);
  // a cell's logit is a polynomial of its centred coordinates: 7 multiply-adds a point (docs/theory/representations.md §8)
  BrickPolynomials polynomials;
  brickPolynomials(order.resolution, in.logits, polynomials);
  // lit and dark squares stay apart: one pass then gives the cost at any weight of dark points
  double lit_total = 0.0, dark_total = 0.0;
  size_t active = 0;
  Floats lit_square = hn::Zero(d), dark_square = hn::Zero(d);
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(order.resolution, c);
    const bool is_left_out = in.limits != nullptr && isSettled(in.limits[c], order.resolution, in.logits + cell.first_node);
    const int cell_end = order.cell_begin[c + 1];
    for (int place = is_left_out ? cell_end : order.cell_begin[c]; place < cell_end; place += lanes) {
      const Floats logit = cellLogit(d, polynomials, c, cellPosition(d, order, cell, scale, place));
      const Sigmoid s = sigmoid(d, logit);
      const Floats mask = hn::Load(d, in.mask + place), tents = hn::Load(d, &order.points.tent[place]);
      const Floats phi = hn::Load(d, in.phi + place);
      // of lit points the mask may be above 1, too
      const auto is_dark = hn::And(hn::Eq(phi, hn::Zero(d)), hn::Gt(mask, one));
      const Floats bare = hn::MulSub(s.value, tents, phi), lit = hn::IfThenZeroElse(is_dark, hn::Mul(mask, bare));
      lit_square = hn::MulAdd(lit, lit, lit_square);
      dark_square = hn::MulAdd(hn::IfThenElseZero(is_dark, bare), bare, dark_square);
      // dark points at the weight of this step, which the ramp raises
      const Floats weight = hn::IfThenElse(is_dark, dark_root, mask), residual = hn::Mul(weight, bare);
      const Floats slope = hn::Mul(s.value, s.complement);
      // active is what is wrong, or what the sigmoid still moves; a wrong point of a saturated sigmoid gets the slope kappa
      const auto is_wrong = hn::Gt(hn::Abs(residual), wrong);
      const auto counts = hn::Or(is_wrong, hn::Gt(hn::Mul(slope, weight), moving));
      const Floats taken = hn::Mul(hn::Mul(hn::IfThenElse(is_wrong, hn::Max(slope, kappa), slope), tents), weight);
      const auto is_active = hn::And(counts, hn::Gt(taken, least));
      if (hn::AllFalse(d, is_active)) continue;
      // whole vectors: CompressStore takes a hundred cycles on some machines
      hn::StoreU(hn::Compress(hn::Iota(di, place), hn::RebindMask(di, is_active)), di, out.place + active);
      hn::StoreU(hn::Compress(taken, is_active), d, out.slope + active);
      hn::StoreU(hn::Compress(residual, is_active), d, out.residual + active);
      active += hn::CountTrue(d, is_active);
    }
    // floats over some cells, double over all
    if (c % kCellsASum != kCellsASum - 1) continue;
    lit_total += hn::GetLane(hn::SumOfLanes(d, lit_square));
    dark_total += hn::GetLane(hn::SumOfLanes(d, dark_square));
    lit_square = dark_square = hn::Zero(d);
  }
  lit_total += hn::GetLane(hn::SumOfLanes(d, lit_square));
  dark_total += hn::GetLane(hn::SumOfLanes(d, dark_square));
  out.lit_square = lit_total;
  out.dark_square = dark_total;
  out.active_count = static_cast<int>(active);
}

// Adds J^T J of some rows to the upper triangle of a matrix, in blocks of 8 rows by a vector.
// rows   row_count x count, a multiple of 8
void addRowProducts(const float* HWY_RESTRICT rows, int row_count, int count, float* HWY_RESTRICT matrix) {
  const hn::CappedTag<float, 8> d8;
  const FloatTag d;
  const auto addBlocks = [&](auto tag, int block) {
    // eight sums stay in registers over all rows; blocks across the diagonal also write below it, where nothing is read
    for (int a = 0; a < count; a += 8) {
      for (int c = a / block * block; c < count; c += block) {
        hn::Vec<decltype(tag)> sum[8];
#pragma GCC unroll 8
        for (int u = 0; u < 8; ++u) sum[u] = hn::Zero(tag);
        for (int i = 0; i < row_count; ++i) {
          const float* row = rows + static_cast<ptrdiff_t>(i) * count;
          const auto columns = hn::LoadU(tag, row + c);
#pragma GCC unroll 8
          for (int u = 0; u < 8; ++u) sum[u] = hn::MulAdd(hn::Set(tag, row[a + u]), columns, sum[u]);
        }
#pragma GCC unroll 8
        for (int u = 0; u < 8; ++u) {
          float* to = matrix + static_cast<ptrdiff_t>(a + u) * count + c;
          hn::StoreU(hn::Add(hn::LoadU(tag, to), sum[u]), tag, to);
        }
      }
    }
  };
  // a count that is no multiple of the widest vector takes narrower ones
  if (count % static_cast<int>(hn::Lanes(d)) == 0) {
    addBlocks(d, static_cast<int>(hn::Lanes(d)));
  } else {
    addBlocks(d8, static_cast<int>(hn::Lanes(d8)));
  }
}

// The rows of active points, times their slopes: J. And J^T r.
// cell_of   by place; null: a row a point. Two neighbours in one cell else become one row at their weighed mean, with the sum of their
//           squares: half of the rows, and steps no worse (docs/lab/training.md)
// returns   how many rows
int makeRows(const float* HWY_RESTRICT at_places, size_t stride, const int* place, const float* slope, const float* residual,
             int point_count, const uint16_t* cell_of, int count, float* HWY_RESTRICT rows, float* HWY_RESTRICT gradient) {
  const hn::CappedTag<float, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int row_count = 0;
  for (int i = 0; i < point_count; ++row_count) {
    const float* from = at_places + static_cast<size_t>(place[i]) * stride;
    float* row = rows + static_cast<ptrdiff_t>(row_count) * count;
    const bool is_pair = cell_of != nullptr && i + 1 < point_count && cell_of[place[i]] == cell_of[place[i + 1]];
    // the pair's row is the mean by squared slopes, times the root of their sum; the gradient keeps the pull of each
    if (is_pair) {
      const float* other = at_places + static_cast<size_t>(place[i + 1]) * stride;
      const float a = slope[i] * slope[i], b = slope[i + 1] * slope[i + 1], over = 1.0f / std::sqrt(a + b);
      const auto share = hn::Set(d, a * over), other_share = hn::Set(d, b * over);
      const auto pull = hn::Set(d, slope[i] * residual[i]), other_pull = hn::Set(d, slope[i + 1] * residual[i + 1]);
      for (int k = 0; k < count; k += lanes) {
        const auto value = hn::LoadU(d, from + k), other_value = hn::LoadU(d, other + k);
        hn::StoreU(hn::MulAdd(share, value, hn::Mul(other_share, other_value)), d, row + k);
        hn::StoreU(hn::MulAdd(pull, value, hn::MulAdd(other_pull, other_value, hn::LoadU(d, gradient + k))), d, gradient + k);
      }
      i += 2;
      continue;
    }
    const auto factor = hn::Set(d, slope[i]), wrong = hn::Set(d, residual[i]);
    for (int k = 0; k < count; k += lanes) {
      const auto value = hn::Mul(factor, hn::LoadU(d, from + k));
      hn::StoreU(value, d, row + k);
      hn::StoreU(hn::MulAdd(wrong, value, hn::LoadU(d, gradient + k)), d, gradient + k);
    }
    ++i;
  }
  return row_count;
}

// Cholesky in place on the upper triangle; false where a pivot is none.
template <class Tag>
bool factorWith(Tag d, int count, float* HWY_RESTRICT matrix) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < count; ++i) {
    float* pivot_row = matrix + static_cast<ptrdiff_t>(i) * count;
    if (!(pivot_row[i] > 0.0f) || !std::isfinite(pivot_row[i])) return false;
    const auto inverse = hn::Set(d, 1.0f / std::sqrt(pivot_row[i]));
    // whole vectors: numbers left of the diagonal are never read
    for (int k = i / lanes * lanes; k < count; k += lanes)
      hn::StoreU(hn::Mul(hn::LoadU(d, pivot_row + k), inverse), d, pivot_row + k);
    for (int j = i + 1; j < count; ++j) {
      const auto factor = hn::Set(d, pivot_row[j]);
      float* row = matrix + static_cast<ptrdiff_t>(j) * count;
      for (int k = j / lanes * lanes; k < count; k += lanes)
        hn::StoreU(hn::NegMulAdd(factor, hn::LoadU(d, pivot_row + k), hn::LoadU(d, row + k)), d, row + k);
    }
  }
  return true;
}

bool factorUpper(int count, float* HWY_RESTRICT matrix) {
  const FloatTag d;
  return count % static_cast<int>(hn::Lanes(d)) == 0 ? factorWith(d, count, matrix)
                                                     : factorWith(hn::CappedTag<float, 8>(), count, matrix);
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {
namespace {

HWY_EXPORT(findCellLimits);
HWY_EXPORT(passVectors);
HWY_EXPORT(addRowProducts);
HWY_EXPORT(makeRows);
HWY_EXPORT(factorUpper);

// By step: the least slope of a point that is wrong.
constexpr float kKappas[] = {0.02f, 0.01f, 0.005f, 0.0f};
constexpr int kRampSteps = 3;  // until all is at its full weight
// Marquardt's damping after a step that lowers what is minimised, and after one that does not.
constexpr double kLessDamping = 0.25, kMoreDamping = 8.0, kLeastDamping = 1e-7, kMostDamping = 1e6;
constexpr float kLeastDiagonal = 1e-3f;  // of the largest entry: numbers that change nothing are damped as if they did so much
constexpr int kSlowSteps = 2;

float kappaOf(const CodeFitOptions& options, int step) { return options.is_ramped ? kKappas[std::min(step, kRampSteps)] : 0.0f; }

// The root of the weight of dark points at a step, of what it is in the end.
float darkRoot(const CodeFitOptions& options, int step, float full) {
  if (!options.is_ramped || step >= kRampSteps || full <= 1.0f) return full;
  return std::pow(full, static_cast<float>(step) / kRampSteps);
}

}  // namespace

void CodeFit::prepare(const Representation& representation) {
  if (dictionary_ == representation.dictionary) return;
  dictionary_ = representation.dictionary;
  order_ = &cellOrder(dictionary_->resolution());
  // passes store whole vectors, so that arrays by place are longer by a group
  const auto K = static_cast<size_t>(dictionary_->codeCount()), places = static_cast<size_t>(order_->placeCount()) + kPointGroup;
  logits_.assign(dictionary_->nodeStride(), 0.0f);
  for (AlignedFloats* square : {&matrix_, &factor_}) square->assign(K * K, 0.0f);
  gradient_.assign(K, 0.0f);
  rows_.assign(2 * kRowsAtOnce * K, 0.0f);
  limits_.assign(order_->cell_begin.size() - 1, {});
  cell_of_.assign(static_cast<size_t>(order_->placeCount()), 0);
  // the cell of every place, so that makeRows can pair neighbours
  for (size_t c = 0; c < limits_.size(); ++c) {
    std::fill(cell_of_.begin() + order_->cell_begin[c], cell_of_.begin() + order_->cell_begin[c + 1], static_cast<uint16_t>(c));
  }
  trial_.assign(K, 0.0f);
  start_.assign(K, 0.0f);
  for (Pass* pass : {&best_, &other_}) {
    pass->place.assign(places, 0);
    pass->slope.assign(places, 0.0f);
    pass->residual.assign(places, 0.0f);
  }
}

void CodeFit::runPass(const WeightingFunction& function, int count, const float* z, float dark_root, float kappa,
                      const CellLimits* limits, Pass* pass) {
  expandCode(*dictionary_, z, count, logits_.data());
  const PassInput in{*order_,
                     function.phi.data(),
                     function.mask.data(),
                     logits_.data(),
                     limits,
                     dark_root,
                     kappa,
                     all_points_ ? -1.0f : kMoving,
                     all_points_ ? 0.0f : kLeastSlope};
  PassOutput out{pass->place.data(), pass->slope.data(), pass->residual.data(), 0, 0.0, 0.0};
  HWY_DYNAMIC_DISPATCH(passVectors)(in, out);
  pass->active_count = out.active_count;
  pass->lit_square = out.lit_square;
  pass->dark_square = out.dark_square;
  pass->dark_root = dark_root;
  pass->kappa = kappa;
}

double CodeFit::priorCost(const CodeFitOptions& options, int count, const float* z) const {
  double sum = 0.0;
  for (int k = 0; k < count; ++k) {
    const double over = z[k] / dictionary_->deviations()[k];
    sum += over * over;
  }
  return options.prior * sum;
}

void CodeFit::addEquations(const Pass& pass, int count, float kappa, RowsOf rows) {
  const Dictionary::FitTables& tables = dictionary_->fitTables();
  const auto K = static_cast<size_t>(dictionary_->codeCount());
  std::fill_n(matrix_.begin(), count * count, 0.0f);
  std::fill_n(gradient_.begin(), count, 0.0f);
  const bool is_merged = rows == RowsOf::pairs;
  const int points_at_once = is_merged ? 2 * kRowsAtOnce : kRowsAtOnce;
  for (int first = 0; first < pass.active_count;) {
    const int point_count = std::min(points_at_once, pass.active_count - first);
    const int row_count =
        HWY_DYNAMIC_DISPATCH(makeRows)(tables.at_places.data(), K, &pass.place[first], &pass.slope[first], &pass.residual[first],
                                       point_count, is_merged ? cell_of_.data() : nullptr, count, rows_.data(), gradient_.data());
    first += point_count;
    HWY_DYNAMIC_DISPATCH(addRowProducts)(rows_.data(), row_count, count, matrix_.data());
  }
  // damping by the straight-through slope of all points, a constant of the dictionary (docs/theory/representations.md §9)
  if (kappa == 0.0f) return;
  for (int i = 0; i < count; ++i) {
    for (int k = i; k < count; ++k) matrix_[i * count + k] += kappa * kappa * tables.tent_squares[i * K + k];
  }
}

bool CodeFit::solveStep(const CodeFitOptions& options, int count, double damping, const float* z, float* trial) {
  std::copy_n(matrix_.begin(), count * count, factor_.begin());
  // Marquardt's damping is relative to the diagonal; the prior has a diagonal of its own and pulls towards the mean code, 0
  float largest = 0.0f;
  for (int i = 0; i < count; ++i) largest = std::max(largest, matrix_[i * count + i]);
  for (int i = 0; i < count; ++i) {
    const float deviation = dictionary_->deviations()[i];
    const auto prior = static_cast<float>(options.prior) / (deviation * deviation);
    factor_[i * count + i] += static_cast<float>(damping) * std::max(matrix_[i * count + i], kLeastDiagonal * largest) + prior;
    trial[i] = -(gradient_[i] + prior * z[i]);
  }
  if (!HWY_DYNAMIC_DISPATCH(factorUpper)(count, factor_.data())) return false;
  // U^T U step = - gradient
  for (int i = 0; i < count; ++i) {
    const float* row = &factor_[i * count];
    const float value = trial[i] /= row[i];
    for (int k = i + 1; k < count; ++k) trial[k] -= row[k] * value;
  }
  for (int i = count - 1; i >= 0; --i) {
    const float* row = &factor_[i * count];
    float sum = trial[i];
    for (int k = i + 1; k < count; ++k) sum -= row[k] * trial[k];
    trial[i] = sum / row[i];
  }
  for (int i = 0; i < count; ++i) trial[i] += z[i];
  return allFinite({trial, static_cast<size_t>(count)});
}

FitResult CodeFit::iterate(const Representation& representation, const WeightingFunction& function, const CodeFitOptions& options,
                           int count, float* z) {
  prepare(representation);
  all_points_ = options.all_points;
  const auto K = static_cast<size_t>(dictionary_->codeCount());
  FitResult result;
  const int valid_count = function.validCount();
  if (valid_count == 0) {
    result.stop = FitStop::no_points;
    return result;
  }
  // numbers beyond `count` stay 0, as in the stored code
  std::fill(z + count, z + K, 0.0f);
  std::copy_n(z, K, start_.begin());
  std::fill(trial_.begin(), trial_.end(), 0.0f);
  const float full_root = function.dark_root;
  // settled cells cost a pass nothing; a fit of all points leaves none out
  const CellLimits* const limits = all_points_ ? nullptr : limits_.data();
  if (limits != nullptr) HWY_DYNAMIC_DISPATCH(findCellLimits)(*order_, function.phi.data(), function.mask.data(), limits_.data());
  const auto squareOf = [&](const Pass& pass, float root) { return pass.lit_square + double{root} * root * pass.dark_square; };
  const auto rootAt = [&](int step) { return darkRoot(options, step, full_root); };
  // the cost of the start at full weights: at the end it says whether the fit was worth keeping
  runPass(function, count, z, rootAt(0), kappaOf(options, 0), limits, &best_);
  const double first_square = squareOf(best_, full_root);
  if (!allFinite({z, K}) || !std::isfinite(first_square)) {
    result.stop = FitStop::not_finite;
    result.rmse = std::numeric_limits<double>::infinity();
    return result;
  }
  double damping = options.damping, prior = priorCost(options, count, z);
  bool is_current = false;  // the equations are of best_
  int slow_steps = 0;
  for (int step = 0; step < options.iterations; ++step) {
    // first steps weigh dark points less and see through saturated sigmoids: at full weight a fit closes too much
    const float root = rootAt(step), kappa = kappaOf(options, step);
    // a step that was no better left rows of other weights
    if (best_.dark_root != root || best_.kappa != kappa) {
      runPass(function, count, z, root, kappa, limits, &best_);
      is_current = false;
    }
    if (!is_current) addEquations(best_, count, kappa, all_points_ ? RowsOf::points : RowsOf::pairs);
    is_current = true;
    ++result.steps;
    double trial_prior = 0.0;
    const bool is_solved = solveStep(options, count, damping, z, trial_.data());
    if (is_solved) {
      // rows as the next step wants them
      runPass(function, count, trial_.data(), rootAt(step + 1), kappaOf(options, step + 1), limits, &other_);
      trial_prior = priorCost(options, count, trial_.data());
    }
    // both at this step's weight of dark points, though the rows of other_ are already the next step's
    const double before = squareOf(best_, root) + prior, after = squareOf(other_, root) + trial_prior;
    if (!is_solved || !(after < before)) {
      damping *= kMoreDamping;
      if (damping <= kMostDamping) continue;
      result.stop = FitStop::damping;
      break;
    }
    damping = std::max(kLeastDamping, damping * kLessDamping);
    slow_steps = after > (1.0 - options.progress_tolerance) * before ? slow_steps + 1 : 0;
    std::swap(best_, other_);
    std::copy_n(trial_.begin(), count, z);
    prior = trial_prior;
    is_current = false;
    // two slow steps in a row end the fit, but not before the ramp has reached the full weights
    if (slow_steps < kSlowSteps || step < kRampSteps) continue;
    result.stop = FitStop::progress;
    break;
  }
  // only rounded logits are stored, so that their error decides
  const auto roundedSquare = [&](const float* of) {
    return loss(representation, 0, static_cast<int>(function.phi.size()), function.phi.data(), function.mask.data(), of);
  };
  double square = roundedSquare(z);
  // what rounding adds is far less than half
  if (!(square < 0.5 * first_square)) {
    const double start_square = roundedSquare(start_.data());
    if (!(square <= start_square)) {
      std::copy_n(start_.begin(), K, z);
      square = start_square;
    }
  }
  result.rmse = std::sqrt(square / valid_count);
  return result;
}

bool CodeEquations::factor() { return HWY_DYNAMIC_DISPATCH(factorUpper)(count, matrix.data()); }

void CodeFit::equationsAt(const Representation& representation, const WeightingFunction& function, const CodeFitOptions& options,
                          const float* z, CodeEquations* equations) {
  prepare(representation);
  all_points_ = options.all_points;
  const int K = dictionary_->codeCount();
  // to find the settled cells would cost as much as this one pass; they hold no active points
  runPass(function, K, z, function.dark_root, 0.0f, nullptr, &other_);
  addEquations(other_, K, 0.0f, RowsOf::points);
  equations->count = K;
  equations->matrix.resize(matrix_.size());
  for (int i = 0; i < K; ++i) {
    const float deviation = dictionary_->deviations()[i];
    for (int k = i; k < K; ++k) equations->matrix[i * K + k] = equations->matrix[k * K + i] = matrix_[i * K + k];
    equations->matrix[i * K + i] += static_cast<float>(options.prior) / (deviation * deviation);
  }
}

}  // namespace nlg
#endif  // HWY_ONCE
