#include "runtime_eval/fit/network_loss.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/network_loss.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// A block is passed twice: forward and deltas, two vectors of points at a time, into these arrays (32 kB, level-1 cache);
// then the gradient as small matrix products over the block, so that its 113 sums stay in registers.
constexpr int kBlock = 256;
struct alignas(64) BlockState {
  float first[kHiddenCount][kBlock];  // hidden values
  float second[kHiddenCount][kBlock];
  float first_delta[kHiddenCount][kBlock];  // d sum / d pre-activation
  float second_delta[kHiddenCount][kBlock];
  float output_delta[kBlock];  // d sum / d network output
};

struct Targets {
  const float* HWY_RESTRICT phi;
  const float* HWY_RESTRICT mask;
};

// Residuals of kGroup vectors of points; returns their d sum / d output and adds the squares.
template <int kGroup>
HWY_INLINE void residuals(FloatTag d, bool tent_factor, const float* HWY_RESTRICT tent, Targets target, int lanes, Floats* output,
                          Floats& square_sum) {
#pragma GCC unroll 2
  for (int g = 0; g < kGroup; ++g) {
    const Floats factor = tent_factor ? hn::Load(d, tent + g * lanes) : hn::Set(d, 1.0f);
    const Floats mask = hn::LoadU(d, target.mask + g * lanes), phi = hn::LoadU(d, target.phi + g * lanes);
    const Floats residual = hn::Mul(mask, hn::MulSub(factor, output[g], phi));
    square_sum = hn::MulAdd(residual, residual, square_sum);
    output[g] = hn::Mul(hn::Add(residual, residual), factor);
  }
}

// Deltas of both hidden layers from the output's.
template <int kGroup>
HWY_INLINE void backward(FloatTag d, const float* HWY_RESTRICT theta, Floats slope, const Hidden<kGroup>& hidden,
                         const Floats* output_delta, int lanes, int offset, BlockState& block) {
  using L = ThetaLayout;
  const Floats one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  Floats delta[kHiddenCount][kGroup];
#pragma GCC unroll 8
  for (int j = 0; j < kHiddenCount; ++j) {
    const Floats weight = hn::Set(d, theta[L::w3 + j]);
#pragma GCC unroll 2
    for (int g = 0; g < kGroup; ++g) {
      const Floats derivative = hn::IfThenElse(hn::Gt(hidden.second[j][g], zero), one, slope);
      delta[j][g] = hn::Mul(hn::Mul(output_delta[g], weight), derivative);
      hn::Store(hidden.second[j][g], d, &block.second[j][offset + g * lanes]);
      hn::Store(delta[j][g], d, &block.second_delta[j][offset + g * lanes]);
    }
  }
#pragma GCC unroll 8
  for (int i = 0; i < kHiddenCount; ++i) {
    Floats sum[kGroup];
#pragma GCC unroll 2
    for (int g = 0; g < kGroup; ++g) sum[g] = zero;
#pragma GCC unroll 8
    for (int j = 0; j < kHiddenCount; ++j) {
      const Floats weight = hn::Set(d, theta[L::w2 + kHiddenCount * j + i]);
#pragma GCC unroll 2
      for (int g = 0; g < kGroup; ++g) sum[g] = hn::MulAdd(weight, delta[j][g], sum[g]);
    }
#pragma GCC unroll 2
    for (int g = 0; g < kGroup; ++g) {
      const Floats derivative = hn::IfThenElse(hn::Gt(hidden.first[i][g], zero), one, slope);
      hn::Store(hidden.first[i][g], d, &block.first[i][offset + g * lanes]);
      hn::Store(hn::Mul(sum[g], derivative), d, &block.first_delta[i][offset + g * lanes]);
    }
  }
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
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int c = 0; c < kColumns; ++c) sums[r][c] += hn::GetLane(hn::SumOfLanes(d, accumulator[r][c]));
  }
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
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) sums[r] += hn::GetLane(hn::SumOfLanes(d, accumulator[r]));
}

void addBlockGradient(FloatTag d, int count, const BlockState& block, const PointSet& points, int first,
                      float* HWY_RESTRICT gradient) {
  using L = ThetaLayout;
  const float* axes[3] = {&points.x[first], &points.y[first], &points.z[first]};
  constexpr int kTile = 4;
  for (int j = 0; j < kHiddenCount; j += kTile) {
    const float* delta_rows[kTile];
    float* w2_rows[kTile];
    for (int r = 0; r < kTile; ++r) delta_rows[r] = block.second_delta[j + r];
    for (int i = 0; i < kHiddenCount; i += kTile) {
      const float* columns[kTile];
      for (int c = 0; c < kTile; ++c) columns[c] = block.first[i + c];
      for (int r = 0; r < kTile; ++r) w2_rows[r] = gradient + L::w2 + kHiddenCount * (j + r) + i;
      addProducts<kTile, kTile>(d, count, delta_rows, columns, w2_rows);
    }
    float* w1_rows[kTile];
    for (int r = 0; r < kTile; ++r) delta_rows[r] = block.first_delta[j + r], w1_rows[r] = gradient + L::w1 + 3 * (j + r);
    addProducts<kTile, 3>(d, count, delta_rows, axes, w1_rows);
  }
  const float* output_row[1] = {block.output_delta};
  const float* second_rows[kHiddenCount];
  float* w3_row[1] = {gradient + L::w3};
  for (int j = 0; j < kHiddenCount; ++j) second_rows[j] = block.second[j];
  addProducts<1, kHiddenCount>(d, count, output_row, second_rows, w3_row);
  addSums<kHiddenCount>(d, count, block.first_delta, gradient + L::b1);
  addSums<kHiddenCount>(d, count, block.second_delta, gradient + L::b2);
  addSums<1>(d, count, &block.output_delta, gradient + L::b3);
}

double lossAndGradientVectors(const Representation& representation, const PointSet& points, int first, int count,
                              const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, const float* HWY_RESTRICT theta,
                              float* HWY_RESTRICT gradient) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  constexpr int kGroup = 2;
  BlockState block;
  std::fill_n(gradient, ThetaLayout::count, 0.0f);
  double total = 0.0;
  for (int begin = 0; begin < count; begin += kBlock) {
    const int block_count = std::min(kBlock, count - begin);
    Floats square_sum = hn::Zero(d);
    const auto step = [&]<int kVectors>(int offset) {
      const int at = first + begin + offset;
      Floats x[kVectors], y[kVectors], z[kVectors], output[kVectors];
      for (int g = 0; g < kVectors; ++g) {
        x[g] = hn::Load(d, &points.x[at + g * lanes]);
        y[g] = hn::Load(d, &points.y[at + g * lanes]);
        z[g] = hn::Load(d, &points.z[at + g * lanes]);
      }
      Hidden<kVectors> hidden;
      forwardNetwork<kVectors>(d, theta, slope, x, y, z, hidden, output);
      residuals<kVectors>(d, representation.tentFactor(), &points.tent[at], {phi + begin + offset, mask + begin + offset}, lanes,
                          output, square_sum);
      for (int g = 0; g < kVectors; ++g) hn::Store(output[g], d, &block.output_delta[offset + g * lanes]);
      backward<kVectors>(d, theta, slope, hidden, output, lanes, offset, block);
    };
    int offset = 0;
    for (; offset + kGroup * lanes <= block_count; offset += kGroup * lanes) step.template operator()<kGroup>(offset);
    for (; offset < block_count; offset += lanes) step.template operator()<1>(offset);
    addBlockGradient(d, block_count, block, points, first + begin, gradient);
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

double lossVectors(const Representation& representation, const PointSet& points, int first, int count,
                   const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask, const float* HWY_RESTRICT theta) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  double total = 0.0;
  for (int begin = 0; begin < count; begin += kBlock) {
    Floats square_sum = hn::Zero(d);
    for (int i = begin; i < std::min(begin + kBlock, count); i += lanes) {
      const int at = first + i;
      const Floats x = hn::Load(d, &points.x[at]), y = hn::Load(d, &points.y[at]), z = hn::Load(d, &points.z[at]);
      Hidden<1> hidden;
      Floats output;
      forwardNetwork<1>(d, theta, slope, &x, &y, &z, hidden, &output);
      residuals<1>(d, representation.tentFactor(), &points.tent[at], {phi + i, mask + i}, lanes, &output, square_sum);
    }
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
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

double networkLossAndGradientReference(const Representation& representation, const PointSet& points, int first, int count,
                                       const float* phi, const float* mask, const double* theta, double* gradient) {
  using L = ThetaLayout;
  std::fill_n(gradient, ThetaLayout::count, 0.0);
  const double slope = representation.slope;
  const auto leaky = [slope](double value) { return value > 0 ? value : slope * value; };
  double total = 0.0;
  for (int n = 0; n < count; ++n) {
    const double point[3] = {points.x[first + n], points.y[first + n], points.z[first + n]};
    double h1[kHiddenCount], h2[kHiddenCount], d2[kHiddenCount];
    for (int j = 0; j < kHiddenCount; ++j) {
      double sum = theta[L::b1 + j];
      for (int a = 0; a < 3; ++a) sum += theta[L::w1 + 3 * j + a] * point[a];
      h1[j] = leaky(sum);
    }
    double output = theta[L::b3];
    for (int j = 0; j < kHiddenCount; ++j) {
      double sum = theta[L::b2 + j];
      for (int i = 0; i < kHiddenCount; ++i) sum += theta[L::w2 + kHiddenCount * j + i] * h1[i];
      h2[j] = leaky(sum);
      output += theta[L::w3 + j] * h2[j];
    }
    const double factor = representation.tentFactor() ? points.tent[first + n] : 1.0;
    const double residual = mask[n] * (factor * output - phi[n]);
    total += residual * residual;
    const double output_delta = 2 * residual * factor;
    gradient[L::b3] += output_delta;
    for (int j = 0; j < kHiddenCount; ++j) {
      gradient[L::w3 + j] += output_delta * h2[j];
      d2[j] = output_delta * theta[L::w3 + j] * (h2[j] > 0 ? 1 : slope);
      gradient[L::b2 + j] += d2[j];
      for (int i = 0; i < kHiddenCount; ++i) gradient[L::w2 + kHiddenCount * j + i] += d2[j] * h1[i];
    }
    for (int i = 0; i < kHiddenCount; ++i) {
      double sum = 0.0;
      for (int j = 0; j < kHiddenCount; ++j) sum += theta[L::w2 + kHiddenCount * j + i] * d2[j];
      const double d1 = sum * (h1[i] > 0 ? 1 : slope);
      gradient[L::b1 + i] += d1;
      for (int a = 0; a < 3; ++a) gradient[L::w1 + 3 * i + a] += d1 * point[a];
    }
  }
  return total;
}

}  // namespace nlg
#endif  // HWY_ONCE
