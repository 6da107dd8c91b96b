#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/loss/loss_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/loss/network_loss.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// A block is passed twice: forward and deltas, two vectors of points at a time, into these arrays (32 kB at most, level-1 cache);
// then the gradient as small matrix products over the block, so that its sums stay in registers.
constexpr int kBlock = 256;
template <NetworkShape kShape>
struct alignas(64) BlockState {
  float first[kShape.first][kBlock];  // hidden values
  float second[kShape.last()][kBlock];
  float first_delta[kShape.first][kBlock];  // d sum / d pre-activation
  float second_delta[kShape.last()][kBlock];
  float output_delta[kBlock];  // d sum / d sum of the output layer
};

struct Targets {
  const float* HWY_RESTRICT phi;
  const float* HWY_RESTRICT mask;
};

// Residuals of kGroup vectors of points; returns their d sum / d sum of the output layer and adds the squares.
template <OutputFunction kOutput, int kGroup>
HWY_INLINE void residuals(FloatTag d, bool tent_factor, const float* HWY_RESTRICT tent, Targets target, int lanes, Floats* output,
                          Floats& square_sum) {
#pragma GCC unroll 2
  for (int g = 0; g < kGroup; ++g) {
    const Floats factor = tent_factor ? hn::Load(d, tent + g * lanes) : hn::Set(d, 1.0f);
    const Floats mask = hn::LoadU(d, target.mask + g * lanes), phi = hn::LoadU(d, target.phi + g * lanes);
    const OutputValue of = outputValue<kOutput>(d, output[g]);
    const Floats residual = hn::Mul(mask, hn::MulSub(factor, of.value, phi));
    square_sum = hn::MulAdd(residual, residual, square_sum);
    output[g] = hn::Mul(hn::Add(residual, residual), hn::Mul(mask, factor));
    if constexpr (kOutput != OutputFunction::linear) output[g] = hn::Mul(output[g], of.derivative);
  }
}

// Deltas of the last hidden layer from the output's; stores them and the layer's values.
template <int kGroup, class Layer, int kWidth>
HWY_INLINE void lastDeltas(FloatTag d, const float* HWY_RESTRICT weights, Floats slope, const Layer& layer,
                           const Floats* output_delta, int lanes, int offset, float (*values)[kBlock], float (*deltas)[kBlock],
                           Floats (&delta)[kWidth][kGroup]) {
#pragma GCC unroll 8
  for (int j = 0; j < kWidth; ++j) {
    const Floats weight = hn::Set(d, weights[j]);
#pragma GCC unroll 2
    for (int g = 0; g < kGroup; ++g) {
      delta[j][g] = hn::Mul(hn::Mul(output_delta[g], weight), layer.derivative(d, j, g, slope));
      hn::Store(layer.value[j][g], d, &values[j][offset + g * lanes]);
      hn::Store(delta[j][g], d, &deltas[j][offset + g * lanes]);
    }
  }
}

// Deltas of the hidden layers from the output's.
template <NetworkShape kShape, int kGroup>
HWY_INLINE void backward(FloatTag d, const float* HWY_RESTRICT theta, Floats slope, const Hidden<kShape, kGroup>& hidden,
                         const Floats* output_delta, int lanes, int offset, BlockState<kShape>& block) {
  Floats delta[kShape.last()][kGroup];
  // with one hidden layer its deltas are the last ones, and end here
  if constexpr (kShape.second == 0) {
    lastDeltas<kGroup>(d, theta + kShape.w3(), slope, hidden.first, output_delta, lanes, offset, block.first, block.first_delta,
                       delta);
    return;
  }
  lastDeltas<kGroup>(d, theta + kShape.w3(), slope, hidden.second, output_delta, lanes, offset, block.second, block.second_delta,
                     delta);
  // W2^T times the deltas of the second layer, through the slopes of the first
#pragma GCC unroll 8
  for (int i = 0; i < kShape.first; ++i) {
    Floats sum[kGroup];
#pragma GCC unroll 2
    for (int g = 0; g < kGroup; ++g) sum[g] = hn::Zero(d);
#pragma GCC unroll 8
    for (int j = 0; j < kShape.second; ++j) {
      const Floats weight = hn::Set(d, theta[kShape.w2() + kShape.first * j + i]);
#pragma GCC unroll 2
      for (int g = 0; g < kGroup; ++g) sum[g] = hn::MulAdd(weight, delta[j][g], sum[g]);
    }
#pragma GCC unroll 2
    for (int g = 0; g < kGroup; ++g) {
      hn::Store(hidden.first.value[i][g], d, &block.first[i][offset + g * lanes]);
      hn::Store(hn::Mul(sum[g], hidden.first.derivative(d, i, g, slope)), d, &block.first_delta[i][offset + g * lanes]);
    }
  }
}

// Adds the sum of the lanes of each of kCount vectors to `sums`. Four of them at a time share their shuffles: alone they would be an
// eighth of a step of Adam.
template <int kCount>
HWY_INLINE void addLaneSums(FloatTag d, const Floats* vectors, float* HWY_RESTRICT sums) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (kCount >= 4) {
    const hn::RepartitionToWide<FloatTag> pairs;
    const auto halves = [&](Floats a, Floats b) { return hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b)); };
    const auto ab = hn::BitCast(pairs, halves(vectors[0], vectors[1])), cd = hn::BitCast(pairs, halves(vectors[2], vectors[3]));
    // of every block of four lanes: the sums of its lanes of the four vectors
    const Floats blocks =
        hn::Add(hn::BitCast(d, hn::InterleaveLower(pairs, ab, cd)), hn::BitCast(d, hn::InterleaveUpper(pairs, ab, cd)));
    const hn::CappedTag<float, 4> four;
    // wider vectors fold by halves until one block of four is left
    const auto addHalves = [](auto narrow, auto vector) {
      return hn::Add(hn::LowerHalf(narrow, vector), hn::UpperHalf(narrow, vector));
    };
    const auto store = [&](auto sum) { hn::StoreU(hn::Add(hn::LoadU(four, sums), sum), four, sums); };
    if constexpr (hn::MaxLanes(FloatTag()) == 16) {
      store(addHalves(four, addHalves(hn::CappedTag<float, 8>(), blocks)));
    } else if constexpr (hn::MaxLanes(FloatTag()) == 8) {
      store(addHalves(four, blocks));
    } else {
      store(blocks);
    }
    addLaneSums<kCount - 4>(d, vectors + 4, sums + 4);
    return;
  }
#endif
  for (int i = 0; i < kCount; ++i) sums[i] += hn::GetLane(hn::SumOfLanes(d, vectors[i]));
}

// Sums over the block of rows (a) times columns (b): kRows x kColumns products in registers.
template <int kRows, int kColumns>
HWY_INLINE void addProducts(FloatTag d, int count, const float* const* a, const float* const* b, float* const* sums) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  Floats accumulator[kRows][kColumns];
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int c = 0; c < kColumns; ++c) accumulator[r][c] = hn::Zero(d);
  }
  for (int i = 0; i < count; i += lanes) {
    Floats column[kColumns];
#pragma GCC unroll 8
    for (int c = 0; c < kColumns; ++c) column[c] = hn::Load(d, b[c] + i);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const Floats row = hn::Load(d, a[r] + i);
#pragma GCC unroll 8
      for (int c = 0; c < kColumns; ++c) accumulator[r][c] = hn::MulAdd(row, column[c], accumulator[r][c]);
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) addLaneSums<kColumns>(d, accumulator[r], sums[r]);
}

// Sums over the block of each of kRows rows.
template <int kRows>
HWY_INLINE void addSums(FloatTag d, int count, const float (*rows)[kBlock], float* sums) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  Floats accumulator[kRows];
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) accumulator[r] = hn::Zero(d);
  for (int i = 0; i < count; i += lanes) {
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) accumulator[r] = hn::Add(accumulator[r], hn::Load(d, &rows[r][i]));
  }
  addLaneSums<kRows>(d, accumulator, sums);
}

// Rows that addProducts takes at a time: a divisor of a layer's width whose sums fit the registers.
constexpr int tileOf(int width) { return width % 4 == 0 ? 4 : width % 3 == 0 ? 3 : 2; }

// Adds the products of all pairs of rows, `rows` by `columns`, to sums, row-major.
template <int kRowCount, int kColumnCount>
HWY_INLINE void addLayerGradient(FloatTag d, int count, const float (*rows)[kBlock], const float* const* columns,
                                 float* HWY_RESTRICT sums) {
  constexpr int kRows = tileOf(kRowCount), kColumns = kColumnCount == 3 ? 3 : tileOf(kColumnCount);
  for (int r = 0; r < kRowCount; r += kRows) {
    const float* row_tile[kRows];
    float* sum_tile[kRows];
    for (int i = 0; i < kRows; ++i) row_tile[i] = rows[r + i];
    for (int c = 0; c < kColumnCount; c += kColumns) {
      for (int i = 0; i < kRows; ++i) sum_tile[i] = sums + kColumnCount * (r + i) + c;
      addProducts<kRows, kColumns>(d, count, row_tile, columns + c, sum_tile);
    }
  }
}

template <NetworkShape kShape>
HWY_INLINE void addBlockGradient(FloatTag d, int count, const BlockState<kShape>& block, const PointSet& points, int first,
                                 float* HWY_RESTRICT gradient) {
  constexpr int kLast = kShape.last();
  const float* axes[3] = {&points.x[first], &points.y[first], &points.z[first]};
  addLayerGradient<kShape.first, 3>(d, count, block.first_delta, axes, gradient + kShape.w1());
  addSums<kShape.first>(d, count, block.first_delta, gradient + kShape.b1());
  if constexpr (kShape.second > 0) {
    const float* first_rows[kShape.first];
    for (int i = 0; i < kShape.first; ++i) first_rows[i] = block.first[i];
    addLayerGradient<kShape.second, kShape.first>(d, count, block.second_delta, first_rows, gradient + kShape.w2());
    addSums<kShape.second>(d, count, block.second_delta, gradient + kShape.b2());
  }
  const float* output_row[1] = {block.output_delta};
  const float* last_rows[kLast];
  float* w3_row[1] = {gradient + kShape.w3()};
  for (int j = 0; j < kLast; ++j) last_rows[j] = kShape.second > 0 ? block.second[j] : block.first[j];
  addProducts<1, kLast>(d, count, output_row, last_rows, w3_row);
  addSums<1>(d, count, &block.output_delta, gradient + kShape.b3());
}

template <NetworkShape kShape>
double shapeLossAndGradient(const Representation& representation, const PointSet& points, int first, int count,
                            const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, const float* HWY_RESTRICT theta,
                            float* HWY_RESTRICT gradient) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  const bool tent_factor = representation.tentFactor();
  constexpr int kGroup = 2;
  BlockState<kShape> block;
  std::fill_n(gradient, kShape.thetaCount(), 0.0f);
  double total = 0.0;
  for (int begin = 0; begin < count; begin += kBlock) {
    const int block_count = std::min(kBlock, count - begin);
    Floats square_sum = hn::Zero(d);
    // first pass: values, residuals and deltas of the block's points, into arrays that stay in the level-1 cache
    const auto step = [&]<int kVectors>(int offset) {
      const int at = first + begin + offset;
      Floats x[kVectors], y[kVectors], z[kVectors], output[kVectors];
      for (int g = 0; g < kVectors; ++g) {
        x[g] = hn::Load(d, &points.x[at + g * lanes]);
        y[g] = hn::Load(d, &points.y[at + g * lanes]);
        z[g] = hn::Load(d, &points.z[at + g * lanes]);
      }
      Hidden<kShape, kVectors> hidden;
      forwardNetwork<kShape, kVectors>(d, theta, slope, x, y, z, hidden, output);
      residuals<kShape.output, kVectors>(d, tent_factor, &points.tent[at], {phi + begin + offset, mask + begin + offset}, lanes,
                                         output, square_sum);
      for (int g = 0; g < kVectors; ++g) hn::Store(output[g], d, &block.output_delta[offset + g * lanes]);
      backward<kShape, kVectors>(d, theta, slope, hidden, output, lanes, offset, block);
    };
    // two vectors at a time hide the latency of multiply-adds; the rest of a block takes one
    int offset = 0;
    for (; offset + kGroup * lanes <= block_count; offset += kGroup * lanes) step.template operator()<kGroup>(offset);
    for (; offset < block_count; offset += lanes) step.template operator()<1>(offset);
    // second pass: the gradient as small matrix products. Squares add up in float within a block, in double beyond it
    addBlockGradient<kShape>(d, block_count, block, points, first + begin, gradient);
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

template <NetworkShape kShape>
double shapeLoss(const Representation& representation, const PointSet& points, int first, int count,
                 const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, const float* HWY_RESTRICT theta) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  const bool tent_factor = representation.tentFactor();
  double total = 0.0;
  for (int begin = 0; begin < count; begin += kBlock) {
    Floats square_sum = hn::Zero(d);
    for (int i = begin; i < std::min(begin + kBlock, count); i += lanes) {
      const int at = first + i;
      const Floats x = hn::Load(d, &points.x[at]), y = hn::Load(d, &points.y[at]), z = hn::Load(d, &points.z[at]);
      Hidden<kShape, 1> hidden;
      Floats output;
      forwardNetwork<kShape, 1>(d, theta, slope, &x, &y, &z, hidden, &output);
      residuals<kShape.output, 1>(d, tent_factor, &points.tent[at], {phi + i, mask + i}, lanes, &output, square_sum);
    }
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

double lossAndGradientVectors(const Representation& representation, const PointSet& points, int first, int count,
                              const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, const float* HWY_RESTRICT theta,
                              float* HWY_RESTRICT gradient) {
  return withNetworkShape(representation, [&]<NetworkShape kShape>() {
    return shapeLossAndGradient<kShape>(representation, points, first, count, phi, mask, theta, gradient);
  });
}

double lossVectors(const Representation& representation, const PointSet& points, int first, int count,
                   const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, const float* HWY_RESTRICT theta) {
  return withNetworkShape(representation, [&]<NetworkShape kShape>() {
    return shapeLoss<kShape>(representation, points, first, count, phi, mask, theta);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(lossAndGradientVectors);
HWY_EXPORT(lossVectors);

double networkLossAndGradient(const Representation& representation, const PointSet& points, int first, int count,
                              const float* phi, const float* mask, const float* theta, float* gradient) {
  return HWY_DYNAMIC_DISPATCH(lossAndGradientVectors)(representation, points, first, count, phi, mask, theta, gradient);
}

double networkLoss(const Representation& representation, const PointSet& points, int first, int count, const float* phi,
                   const float* mask, const float* theta) {
  return HWY_DYNAMIC_DISPATCH(lossVectors)(representation, points, first, count, phi, mask, theta);
}

}  // namespace nlg
#endif  // HWY_ONCE
