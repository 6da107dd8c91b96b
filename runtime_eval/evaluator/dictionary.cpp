#include "runtime_eval/evaluator/dictionary.h"

#include <bit>
#include <cmath>
#include <utility>

#include "runtime_eval/numbers/logistic.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/dictionary.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/brick-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

void expandVectors(const Dictionary& dictionary, const float* HWY_RESTRICT z, int count, float* HWY_RESTRICT logits) {
  const FloatTag d;
  const size_t lanes = hn::Lanes(d), stride = dictionary.nodeStride();
  const float* base = dictionary.row(dictionary.codeCount());
  // four vectors of nodes at a time stay in registers over all rows
  for (size_t n = 0; n < stride; n += 4 * lanes) {
    Floats sum[4];
#pragma GCC unroll 4
    for (size_t i = 0; i < 4; ++i) sum[i] = n + i * lanes < stride ? hn::Load(d, base + n + i * lanes) : hn::Zero(d);
    for (int k = 0; k < count; ++k) {
      const Floats factor = hn::Set(d, z[k]);
      const float* row = dictionary.row(k) + n;
#pragma GCC unroll 4
      for (size_t i = 0; i < 4; ++i) {
        if (n + i * lanes < stride) sum[i] = hn::MulAdd(factor, hn::Load(d, row + i * lanes), sum[i]);
      }
    }
#pragma GCC unroll 4
    for (size_t i = 0; i < 4; ++i) {
      if (n + i * lanes < stride) hn::StoreU(sum[i], d, logits + n + i * lanes);
    }
  }
}

float largestVectors(size_t count, const float* HWY_RESTRICT logits) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  // as integers magnitudes are in the same order, and what is no number is above them all
  auto largest = hn::Zero(di);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) largest = hn::Max(largest, hn::BitCast(di, hn::Abs(hn::LoadU(d, logits + i))));
  alignas(64) int32_t lanes[16];
  hn::Store(largest, di, lanes);
  return std::bit_cast<float>(*std::max_element(lanes, lanes + hn::Lanes(di)));
}

void roundVectors(size_t count, float step, float* HWY_RESTRICT logits) {
  const FloatTag d;
  const Floats steps_a_logit = hn::Set(d, 1.0f / step), of_step = hn::Set(d, step);
  for (size_t i = 0; i < count; i += hn::Lanes(d))
    hn::StoreU(hn::Mul(hn::Round(hn::Mul(hn::LoadU(d, logits + i), steps_a_logit)), of_step), d, logits + i);
}

void evaluateCellLogits(const PointOrder& order, const float* HWY_RESTRICT logits, float* HWY_RESTRICT values) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(order.resolution - 1));
  BrickPolynomials polynomials;
  brickPolynomials(order.resolution, logits, polynomials);
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(order.resolution, c);
    for (int place = order.cell_begin[c]; place < order.cell_begin[c + 1]; place += lanes) {
      const Floats logit = cellLogit(d, polynomials, c, cellPosition(d, order, cell, scale, place));
      hn::StoreU(hn::Mul(hn::Load(d, &order.points.tent[place]), sigmoid(d, logit).value), d, values + place);
    }
  }
}

void evaluatePointLogits(int resolution, const PointSet& points, const float* HWY_RESTRICT logits, float* HWY_RESTRICT values) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats half = hn::Set(d, 0.5f * static_cast<float>(resolution - 1)),
               most = hn::Set(d, static_cast<float>(resolution - 1));
  const auto last = hn::Set(di, resolution - 2);
  // limited as an integer too: a position that is no number must not lead outside the brick
  const auto along = [&](const float* from, Floats* share) {
    const Floats position = limit(hn::MulAdd(hn::Load(d, from), half, half), hn::Zero(d), most);
    const auto node = hn::Max(hn::Zero(di), hn::Min(last, hn::ConvertTo(di, position)));
    *share = hn::Sub(position, hn::ConvertTo(d, node));
    return node;
  };
  const auto between = [](Floats low, Floats high, Floats share) { return hn::MulAdd(share, hn::Sub(high, low), low); };
  for (int i = 0; i < points.padded_count; i += lanes) {
    Floats share[3];
    const auto x = along(&points.x[i], &share[0]), y = along(&points.y[i], &share[1]), z = along(&points.z[i], &share[2]);
    const auto side = hn::Set(di, resolution);
    const auto low = hn::Add(x, hn::Mul(side, hn::Add(y, hn::Mul(side, z))));
    // points in no order: eight gathers each, where points of one cell would share its polynomial
    const auto row = [&](int offset) {
      const float* from = logits + offset;
      return between(hn::GatherIndex(d, from, low), hn::GatherIndex(d, from + 1, low), share[0]);
    };
    const Floats near = between(row(0), row(resolution), share[1]);
    const Floats far = between(row(resolution * resolution), row(resolution * (resolution + 1)), share[1]);
    const Floats value = sigmoid(d, between(near, far, share[2])).value;
    hn::StoreU(hn::Mul(hn::Load(d, &points.tent[i]), value), d, values + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {
namespace {

HWY_EXPORT(expandVectors);
HWY_EXPORT(largestVectors);
HWY_EXPORT(roundVectors);
HWY_EXPORT(evaluateCellLogits);
HWY_EXPORT(evaluatePointLogits);

constexpr int kMostExponent = 24;  // of either sign

}  // namespace

std::string whatIsWrong(const DictionaryData& data) {
  const int r = data.resolution, K = data.code_count;
  if (r < 3 || r > kMaxBrickResolution || r % 2 == 0) return "resolution: expected 3, 5, 7 or 9, got " + std::to_string(r);
  if (K < 8 || K > kMaxCodeCount || K % 8 != 0)
    return "codes: expected a multiple of 8 from 8 to " + std::to_string(kMaxCodeCount) + ", got " + std::to_string(K);
  const size_t rows = static_cast<size_t>(K) + 1, nodes = static_cast<size_t>(r) * r * r;
  if (data.nodes.size() != rows * nodes || data.exponents.size() != rows || data.deviations.size() != static_cast<size_t>(K))
    return "nodes, exponents or deviations: not as many as resolution and codes say";
  for (const int exponent : data.exponents) {
    if (std::abs(exponent) > kMostExponent) return "exponents: " + std::to_string(exponent) + " is out of range";
  }
  for (const float deviation : data.deviations) {
    if (!(deviation > 1e-6f && deviation < 1e6f)) return "deviations: expected numbers from 1e-6 to 1e6";
  }
  return "";
}

Dictionary::Dictionary(DictionaryData data) : data_(std::move(data)) {
  const auto nodes = static_cast<size_t>(nodeCount());
  node_stride_ = brickStride(nodes);
  rows_.assign(static_cast<size_t>(codeCount() + 1) * node_stride_, 0.0f);
  for (int k = 0; k <= codeCount(); ++k) {
    for (size_t n = 0; n < nodes; ++n)
      rows_[k * node_stride_ + n] = std::ldexp(static_cast<float>(data_.nodes[k * nodes + n]), data_.exponents[k]);
  }
}

const Dictionary::FitTables& Dictionary::fitTables() const {
  std::call_once(made_, [&] {
    const PointOrder& order = cellOrder(resolution());
    const auto K = static_cast<size_t>(codeCount());
    // docs/theory/representations.md §9: b(x) by place, the rows of fits; and the sum of tent² b b^T, their damping under kappa
    fit_tables_.at_places.assign(static_cast<size_t>(order.placeCount()) * K, 0.0f);
    fit_tables_.tent_squares.assign(K * K, 0.0f);
    for (int p = 0; p < order.placeCount(); ++p) {
      // a place without a point only fills up a vector
      if (order.pattern_index[p] < 0) continue;
      float* values = &fit_tables_.at_places[static_cast<size_t>(p) * K];
      const LocalPoint point = {order.points.x[p], order.points.y[p], order.points.z[p]};
      forEachNode(placeAmongNodes(resolution(), point), resolution(), [&](int node, float weight) {
        for (size_t k = 0; k < K; ++k) values[k] += weight * rows_[k * node_stride_ + static_cast<size_t>(node)];
      });
      const float tent_square = order.points.tent[p] * order.points.tent[p];
      for (size_t i = 0; i < K; ++i) {
        for (size_t k = 0; k < K; ++k) fit_tables_.tent_squares[i * K + k] += tent_square * values[i] * values[k];
      }
    }
  });
  return fit_tables_;
}

void expandCode(const Dictionary& dictionary, const float* z, int count, float* logits) {
  HWY_DYNAMIC_DISPATCH(expandVectors)(dictionary, z, count, logits);
}

float stepOfLogits(size_t count, const float* logits) {
  const float largest = HWY_DYNAMIC_DISPATCH(largestVectors)(count, logits);
  if (!std::isfinite(largest)) return largest;
  int exponent = kLeastStepExponent;
  while (largest > std::ldexp(static_cast<float>(kMostLogitSteps), exponent)) ++exponent;
  return std::ldexp(1.0f, exponent);
}

void roundedLogits(const Dictionary& dictionary, const float* z, float* logits) {
  expandCode(dictionary, z, dictionary.codeCount(), logits);
  const size_t count = dictionary.nodeStride();
  HWY_DYNAMIC_DISPATCH(roundVectors)(count, stepOfLogits(count, logits), logits);
}

float packBrick(const Dictionary& dictionary, const float* z, int8_t* brick) {
  alignas(64) float logits[kMaxBrickStride];
  expandCode(dictionary, z, dictionary.codeCount(), logits);
  const float step = stepOfLogits(dictionary.nodeStride(), logits);
  for (int n = 0; n < dictionary.nodeCount(); ++n) brick[n] = static_cast<int8_t>(std::nearbyint(logits[n] / step));
  return step;
}

float evaluateCode(const Dictionary& dictionary, const LocalPoint& point, const float* z) {
  alignas(64) float logits[kMaxBrickStride];
  roundedLogits(dictionary, z, logits);
  const int r = dictionary.resolution();
  const auto [node, share] = placeAmongNodes(r, point);
  const float* low = logits + node[0] + r * (node[1] + r * node[2]);
  const auto between = [](float near, float far, float way) { return near + way * (far - near); };
  const auto row = [&, along = share[0]](int offset) { return between(low[offset], low[offset + 1], along); };
  const float near = between(row(0), row(r), share[1]), far = between(row(r * r), row(r * (r + 1)), share[1]);
  return logistic(between(near, far, share[2]));
}

double evaluateCodeReference(const Dictionary& dictionary, const LocalPoint& point, const double* z) {
  // unrounded logits of all nodes: the largest decides the step of all
  std::vector<double> logits;
  double largest = 0.0, logit = 0.0;
  for (int n = 0; n < dictionary.nodeCount(); ++n) {
    double sum = dictionary.row(dictionary.codeCount())[n];
    for (int k = 0; k < dictionary.codeCount(); ++k) sum += z[k] * dictionary.row(k)[n];
    logits.push_back(sum);
    largest = std::max(largest, std::fabs(sum));
  }
  // the least power of two whose 127 steps hold the largest logit (docs/theory/representations.md §9)
  double step = std::ldexp(1.0, kLeastStepExponent);
  while (largest > kMostLogitSteps * step) step *= 2.0;
  forEachNode(placeAmongNodes<double>(dictionary.resolution(), point), dictionary.resolution(),
              [&](int node, double weight) { logit += weight * step * std::nearbyint(logits[node] / step); });
  return tent(point) * logistic(logit);
}

void evaluateLogits(int resolution, const PointSet& points, const float* logits, float* values) {
  HWY_DYNAMIC_DISPATCH(evaluatePointLogits)(resolution, points, logits, values);
}

void evaluateLogitCells(const PointOrder& order, const float* logits, float* values) {
  HWY_DYNAMIC_DISPATCH(evaluateCellLogits)(order, logits, values);
}

}  // namespace nlg
#endif  // HWY_ONCE
