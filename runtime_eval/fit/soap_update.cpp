// SOAP (Vyas et al. 2024): Adam in a basis in which the gradients of a layer are nearly uncorrelated. docs/theory/math.md §5.
// The basis is that of Shampoo's two factors of a layer, turned by one sweep of Jacobi's rotations every kBasisSteps steps.
#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/adam_update.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/soap_update.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

#ifndef NLG_SOAP_FACTORS
#define NLG_SOAP_FACTORS
namespace nlg {
// The numbers of one step of the hidden layers.
struct SoapFactors {
  float beta1, beta2, rate, square_scale, gradient_scale;
  bool turns;                          // the basis is turned first …
  float factor_weight, square_weight;  // … and then: how much of a mean the factors and squares are, which started at 0
};

// How fast the factors forget, and how many steps a basis stands: docs/lab/training.md.
inline constexpr float kFactorDecay = 0.95f;
inline constexpr int kBasisSteps = 48;
// Squared correlation of two directions of a basis from which on they are turned.
inline constexpr float kTurnedFrom = 1e-4f;
// Trace of a factor below which no gradient has come for long: what is left of it says nothing of the squares.
inline constexpr float kLeastTrace = 1e-30f;
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Matrix = SoapMoments::Matrix;
using Layer = SoapMoments::Layer;
// No wider than the columns need: on many machines narrow vectors take half the time.
template <int kColumns>
using Tag = hn::CappedTag<float, kColumns <= 4   ? 4
                                 : kColumns <= 8 ? 8
                                                 : SoapMoments::kStride>;

// What lies behind a matrix's columns, up to a whole vector, is used by nobody.
template <int kColumns, class Operation>
HWY_INLINE void forEachVector(const Operation& operation) {
  const int lanes = static_cast<int>(hn::Lanes(Tag<kColumns>()));
  for (int c = 0; c < kColumns; c += lanes) operation(c);
}

// product = a (kRows x kInner) b (kInner x kColumns); store(vector, place) takes it.
template <int kRows, int kInner, int kColumns, class Store>
HWY_INLINE void multiply(const Matrix& a, const Matrix& b, const Store& store) {
  const Tag<kColumns> d;
  forEachVector<kColumns>([&](int c) {
    hn::Vec<Tag<kColumns>> sum[kRows];
    const auto first = hn::Load(d, &b.at[0][c]);
#pragma GCC unroll 16
    for (int r = 0; r < kRows; ++r) sum[r] = hn::Mul(hn::Set(d, a.at[r][0]), first);
#pragma GCC unroll 16
    for (int i = 1; i < kInner; ++i) {
      const auto row = hn::Load(d, &b.at[i][c]);
#pragma GCC unroll 16
      for (int r = 0; r < kRows; ++r) sum[r] = hn::MulAdd(hn::Set(d, a.at[r][i]), row, sum[r]);
    }
    for (int r = 0; r < kRows; ++r) store(sum[r], r, c);
  });
}

template <int kRows, int kInner, int kColumns>
HWY_INLINE void multiply(const Matrix& a, const Matrix& b, Matrix* product) {
  multiply<kRows, kInner, kColumns>(a, b, [&](auto sum, int r, int c) { hn::Store(sum, Tag<kColumns>(), &product->at[r][c]); });
}

// factor = decay factor + (1 - decay) a b
template <int kRows, int kInner>
HWY_INLINE void addToFactor(const Matrix& a, const Matrix& b, Matrix* HWY_RESTRICT factor) {
  const Tag<kRows> d;
  const auto kept = hn::Set(d, kFactorDecay), added = hn::Set(d, 1.0f - kFactorDecay);
  multiply<kRows, kInner, kRows>(a, b, [&](auto sum, int r, int c) {
    float* HWY_RESTRICT place = &factor->at[r][c];
    hn::Store(hn::MulAdd(added, sum, hn::Mul(kept, hn::Load(d, place))), d, place);
  });
}

template <int kRows, int kColumns>
HWY_INLINE void transpose(const Matrix& of, Matrix* result) {
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) result->at[c][r] = of.at[r][c];
  }
}

// One sweep of Jacobi's rotations, which bring `vectors` nearer to the eigenvectors of `factor`: they stay orthonormal, and with a
// factor that changes slowly a sweep a turn is enough. A pair that is not finite is left out.
// rows       vectors, transposed, before and after
// diagonal   vectors^T factor vectors' diagonal afterwards
template <int kCount>
HWY_INLINE void turn(const Matrix& factor, Matrix* HWY_RESTRICT vectors, Matrix* HWY_RESTRICT rows,
                     float* HWY_RESTRICT diagonal) {
  Matrix product, seen;
  // the factor in the present basis: diagonal where the vectors are its eigenvectors
  multiply<kCount, kCount, kCount>(factor, *vectors, &product);
  multiply<kCount, kCount, kCount>(*rows, product, &seen);
  for (int p = 0; p < kCount; ++p) {
    for (int q = p + 1; q < kCount; ++q) {
      const float apart = seen.at[p][q];
      if (!(apart * apart > kTurnedFrom * std::fabs(seen.at[p][p] * seen.at[q][q]))) continue;
      // the smaller of the two angles that make the pair uncorrelated
      const float ratio = (seen.at[q][q] - seen.at[p][p]) / (2.0f * apart);
      const float tangent = std::copysign(1.0f, ratio) / (std::fabs(ratio) + std::sqrt(ratio * ratio + 1.0f));
      const float cosine = 1.0f / std::sqrt(tangent * tangent + 1.0f), sine = tangent * cosine;
      if (!std::isfinite(cosine) || !std::isfinite(sine)) continue;
      const auto rotate = [&](float& of_p, float& of_q) {
        const float p_before = of_p, q_before = of_q;
        of_p = cosine * p_before - sine * q_before;
        of_q = sine * p_before + cosine * q_before;
      };
      for (int k = 0; k < kCount; ++k) rotate(seen.at[p][k], seen.at[q][k]);
      for (int k = 0; k < kCount; ++k) rotate(seen.at[k][p], seen.at[k][q]);
      for (int k = 0; k < kCount; ++k) rotate(rows->at[p][k], rows->at[q][k]);
    }
  }
  transpose<kCount, kCount>(*rows, vectors);
  for (int i = 0; i < kCount; ++i) diagonal[i] = seen.at[i][i];
}

// A matrix of R x C from the basis to theta's own, and the other way round.
template <int kR, int kC>
HWY_INLINE void leaveBasis(const Layer& layer, const Matrix& matrix, Matrix* result) {
  Matrix half_way;
  multiply<kR, kR, kC>(layer.left_vectors, matrix, &half_way);
  multiply<kR, kC, kC>(half_way, layer.right_rows, result);
}
template <int kR, int kC>
HWY_INLINE void enterBasis(const Layer& layer, const Matrix& matrix, Matrix* result) {
  Matrix half_way;
  multiply<kR, kR, kC>(layer.left_rows, matrix, &half_way);
  multiply<kR, kC, kC>(half_way, layer.right_vectors, result);
}

// The mean goes along; the squares of a basis that is new follow from the factors, as Shampoo has them.
template <int kR, int kC>
void turnBasis(const SoapFactors& factors, Layer* layer) {
  Matrix mean;
  leaveBasis<kR, kC>(*layer, layer->mean, &mean);
  float left[kR], right[kC], trace = 0.0f;
  turn<kR>(layer->left, &layer->left_vectors, &layer->left_rows, left);
  turn<kC>(layer->right, &layer->right_vectors, &layer->right_rows, right);
  enterBasis<kR, kC>(*layer, mean, &layer->mean);
  for (const float value : left) trace += value;
  if (!(trace > kLeastTrace)) return;
  // squares and factors are means that started at 0, with different decays: this ratio brings Shampoo's estimate to Adam's scale
  const float scale = factors.square_weight / (factors.factor_weight * trace);
  for (int r = 0; r < kR; ++r) {
    for (int c = 0; c < kC; ++c) {
      // rounding may leave a value of nearly 0 below it
      const float square = scale * std::max(left[r], 0.0f) * std::max(right[c], 0.0f);
      // the factors forget sooner than the mean may: no step is longer for it
      layer->square.at[r][c] = std::max(square, layer->mean.at[r][c] * layer->mean.at[r][c]);
    }
  }
}

// Moments of a gradient in the basis; becomes the step that follows from them.
template <int kR, int kC>
HWY_INLINE void updateMoments(const SoapFactors& factors, Layer* HWY_RESTRICT layer, Matrix* HWY_RESTRICT gradient) {
  const Tag<kC> d;
  const auto beta1 = hn::Set(d, factors.beta1), beta2 = hn::Set(d, factors.beta2);
  const auto mean_added = hn::Set(d, 1.0f - factors.beta1), square_added = hn::Set(d, 1.0f - factors.beta2);
  const auto rate = hn::Set(d, factors.rate), square_scale = hn::Set(d, factors.square_scale), epsilon = hn::Set(d, 1e-16f);
  for (int r = 0; r < kR; ++r) {
    forEachVector<kC>([&](int c) {
      const auto g = hn::Load(d, &gradient->at[r][c]);
      const auto mean = hn::MulAdd(beta1, hn::Load(d, &layer->mean.at[r][c]), hn::Mul(mean_added, g));
      const auto square = hn::MulAdd(beta2, hn::Load(d, &layer->square.at[r][c]), hn::Mul(square_added, hn::Mul(g, g)));
      hn::Store(mean, d, &layer->mean.at[r][c]);
      hn::Store(square, d, &layer->square.at[r][c]);
      // no approximate reciprocal: its bits are not the same on every make of processor
      hn::Store(hn::Div(hn::Mul(rate, mean), hn::Sqrt(hn::MulAdd(square, square_scale, epsilon))), d, &gradient->at[r][c]);
    });
  }
}

// weights, biases   places of the layer's first ones in theta
template <int kR, int kInputs>
HWY_INLINE void stepLayer(const SoapFactors& factors, Layer* layer, const float* HWY_RESTRICT gradient, int weights, int biases,
                          float* HWY_RESTRICT theta) {
  constexpr int kC = kInputs + 1;
  // what lies behind the columns is read, though nobody uses it: numbers that are slow to work with must not stand there
  Matrix own{}, transposed{}, step{}, in_basis{};
  // the gradient of (W, b) as one matrix: a row an output, the bias as its last column
  for (int r = 0; r < kR; ++r) {
    const auto set = [&](int c, float value) { own.at[r][c] = transposed.at[c][r] = factors.gradient_scale * value; };
    for (int c = 0; c < kInputs; ++c) set(c, gradient[weights + kInputs * r + c]);
    set(kInputs, gradient[biases + r]);
  }
  // Adam's formulas hold in the basis; only the step comes back to theta's own axes
  if (factors.turns) turnBasis<kR, kC>(factors, layer);
  enterBasis<kR, kC>(*layer, own, &in_basis);
  updateMoments<kR, kC>(factors, layer, &in_basis);
  leaveBasis<kR, kC>(*layer, in_basis, &step);
  for (int r = 0; r < kR; ++r) {
    for (int c = 0; c < kInputs; ++c) theta[weights + kInputs * r + c] -= step.at[r][c];
    theta[biases + r] -= step.at[r][kInputs];
  }
  // the next turn of the basis sees this gradient, too
  addToFactor<kR, kC>(own, transposed, &layer->left);
  addToFactor<kC, kR>(transposed, own, &layer->right);
}

void stepHidden(const Representation& network, const SoapFactors& factors, const float* HWY_RESTRICT gradient, Layer* layers,
                float* HWY_RESTRICT theta) {
  withNetworkShape(network, [&]<NetworkShape kShape>() {
    stepLayer<kShape.first, 3>(factors, &layers[0], gradient, kShape.w1(), kShape.b1(), theta);
    if constexpr (kShape.second > 0) {
      stepLayer<kShape.second, kShape.first>(factors, &layers[1], gradient, kShape.w2(), kShape.b2(), theta);
    }
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(stepHidden);

void SoapMoments::reset(const Representation& network) {
  network_ = network;
  steps_ = 0;
  mean_power_ = square_power_ = factor_power_ = 1.0;
  layers_.assign(network.shape().second > 0 ? 2 : 1, Layer{});
  for (Layer& layer : layers_) {
    for (Matrix* identity : {&layer.left_vectors, &layer.left_rows, &layer.right_vectors, &layer.right_rows}) {
      for (int i = 0; i < kStride; ++i) identity->at[i][i] = 1.0f;
    }
  }
  last_.reset(network.shape().last() + 1);
}

void SoapMoments::step(double learning_rate, double beta1, double beta2, float gradient_scale, const float* gradient,
                       float* theta) {
  const double factor_weight = 1.0 - factor_power_, square_weight = 1.0 - square_power_;  // of the steps before
  const bool turns = steps_ > 0 && steps_ % kBasisSteps == 0;
  ++steps_;
  mean_power_ *= beta1;
  square_power_ *= beta2;
  factor_power_ *= kFactorDecay;
  const SoapFactors factors = {.beta1 = static_cast<float>(beta1),
                               .beta2 = static_cast<float>(beta2),
                               .rate = static_cast<float>(learning_rate / (1.0 - mean_power_)),
                               .square_scale = static_cast<float>(1.0 / (1.0 - square_power_)),
                               .gradient_scale = gradient_scale,
                               .turns = turns,
                               .factor_weight = static_cast<float>(factor_weight),
                               .square_weight = static_cast<float>(square_weight)};
  HWY_DYNAMIC_DISPATCH(stepHidden)(network_, factors, gradient, layers_.data(), theta);
  // the last layer is a single row: plain Adam
  const int last = network_.shape().w3();
  last_.step(learning_rate, beta1, beta2, gradient_scale, gradient + last, theta + last);
}

}  // namespace nlg
#endif  // HWY_ONCE
