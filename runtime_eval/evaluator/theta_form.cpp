#include "runtime_eval/evaluator/theta_form.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/numbers/finite.h"

namespace nlg {
namespace {

// Arrays on the stack hold kMaxThetaCount numbers: a representation that is added must not outgrow them.
static_assert(
    [] {
      bool fits = kMaxNetworkThetaCount <= kMaxThetaCount && std::size(kFieldResolutions) == std::size(kFields);
      for (const FieldKind& field : kFields) fits &= 2 * field.resolution * field.resolution * field.resolution <= kMaxThetaCount;
      for (const CodeKind& code : kCodes) fits &= code.count <= kMaxThetaCount;
      return fits;
    }(),
    "kernel_shape.h: kMaxThetaCount and kFieldResolutions cover every representation of nlg/representation.h");

// The numbers of one layer's units in theta: unit u has `inputs` weights from weights + u * inputs on, and a bias.
struct HiddenLayer {
  int weights, inputs, biases, units;
};

HiddenLayer firstLayer(const NetworkShape& shape) { return {shape.w1(), 3, shape.b1(), shape.first}; }
HiddenLayer secondLayer(const NetworkShape& shape) { return {shape.w2(), shape.first, shape.b2(), shape.second}; }

// Scales the units of a layer; divides what reads them: number n of `reader_count` that unit u has stands at
// readers + n * units + u.
// most   steps of a unit's largest number
void scaleLayer(const HiddenLayer& layer, float step, int most, int readers, int reader_count, float* theta) {
  for (int u = 0; u < layer.units; ++u) {
    float* weights = theta + layer.weights + u * layer.inputs;
    float& bias = theta[layer.biases + u];
    float largest = std::fabs(bias);
    for (int i = 0; i < layer.inputs; ++i) largest = std::max(largest, std::fabs(weights[i]));
    const auto isWhole = [&](float value) { return value == step * std::nearbyint(value / step); };
    if (largest <= kMostThetaSteps * step && isWhole(bias) && std::all_of(weights, weights + layer.inputs, isWhole)) continue;
    float scale = static_cast<float>(most) * step / largest;
    // numbers so small that their scale is none: they round to 0
    if (!std::isfinite(scale)) scale = 1.0f;
    for (int i = 0; i < layer.inputs; ++i) weights[i] *= scale;
    bias *= scale;
    for (int n = 0; n < reader_count; ++n) theta[readers + n * layer.units + u] /= scale;
  }
}

constexpr int kHalfBits = 10;  // behind the highest

// Bits behind the highest that int8 keeps of a last layer's numbers. Small networks feel the rounding of their hidden layers alone.
int lastLayerBits(const NetworkShape& shape) { return shape.first <= 4 ? 4 : kHalfBits; }

// To the nearest, and none beyond the largest.
Half ofFewerBits(Half half, int bits) {
  if (bits == kHalfBits) return half;
  constexpr uint32_t kInfinity = 0x7c00;
  const uint32_t step = 1u << (kHalfBits - bits), magnitude = half.bits & 0x7fffu;
  const uint32_t rounded = std::min((magnitude + step / 2) / step * step, kInfinity - step);
  return {static_cast<uint16_t>((half.bits & 0x8000u) | rounded)};
}

}  // namespace

ThetaForm thetaForm(const Representation& representation, ThetaPrecision precision) {
  const int D = representation.thetaCount();
  if (precision == ThetaPrecision::float32) return {.floats = D};
  if (precision == ThetaPrecision::float16 || representation.isField()) return {.halves = D};
  if (representation.isCode()) return {.steps = D};
  const int hidden = representation.shape().w3();
  return {.halves = D - hidden, .steps = hidden};
}

const char* thetaPrecisionName(ThetaPrecision precision) {
  return precision == ThetaPrecision::float32 ? "float32" : precision == ThetaPrecision::float16 ? "float16" : "int8";
}

float stepOf(const NetworkShape& shape) { return shape.second > 0 ? 0.03125f : 4.0f; }

int enoughThetaSteps(const NetworkShape& shape) { return shape.first <= 4 && shape.second == 0 ? 64 : kMostThetaSteps; }

void scaleHiddenLayers(const Representation& network, float* theta, UnitSteps most) {
  const NetworkShape& shape = network.shape();
  const float step = stepOf(shape);
  if (shape.second > 0) {
    scaleLayer(firstLayer(shape), step, most.first, shape.w2(), shape.second, theta);
    scaleLayer(secondLayer(shape), step, most.second, shape.w3(), 1, theta);
  } else {
    scaleLayer(firstLayer(shape), step, most.first, shape.w3(), 1, theta);
  }
}

void roundHiddenLayers(const Representation& network, float* theta, UnitSteps most) {
  scaleHiddenLayers(network, theta, most);
  const NetworkShape& shape = network.shape();
  const float step = stepOf(shape);
  for (int d = 0; d < shape.w3(); ++d) theta[d] = step * std::nearbyint(theta[d] / step);
}

bool roundTheta(const Representation& representation, ThetaPrecision precision, float* theta) {
  const ThetaForm form = thetaForm(representation, precision);
  const int D = representation.thetaCount();
  float rounded[kMaxThetaCount];
  std::copy_n(theta, D, rounded);
  // a code takes the least power of two that holds its largest number; networks scale their units instead
  if (representation.isCode() && form.steps > 0) {
    if (!allFinite({theta, static_cast<size_t>(D)})) return false;
    const float step = std::ldexp(1.0f, codeExponent(D, rounded));
    for (int k = 0; k < D; ++k)
      rounded[k] = step * std::clamp<float>(std::nearbyint(rounded[k] / step), -kMostCodeSteps, kMostCodeSteps);
  } else if (form.steps > 0) {
    roundHiddenLayers(representation, rounded);
  }
  // the rest in halves, in last layers of small networks with fewer bits
  for (int d = form.steps; d < D && form.halves > 0; ++d) {
    Half half;
    if (!halfFromFloat(rounded[d], &half)) return false;
    if (form.steps > 0) half = ofFewerBits(half, lastLayerBits(representation.shape()));
    rounded[d] = floatFromHalf(half);
  }
  std::copy_n(rounded, D, theta);
  return true;
}

int codeLength(int count, const float* z) {
  while (count > 0 && z[count - 1] == 0.0f) --count;
  return (count + kCodeGroup - 1) / kCodeGroup * kCodeGroup;
}

size_t storedThetaBytes(const Representation& representation, ThetaPrecision precision, const float* theta) {
  if (!representation.isCode() || precision != ThetaPrecision::int8) return thetaForm(representation, precision).bytes();
  Theta rounded(theta, theta + representation.thetaCount());
  roundTheta(representation, precision, rounded.data());
  return static_cast<size_t>(codeLength(representation.thetaCount(), rounded.data())) * sizeof(int8_t) + sizeof(uint8_t);
}

int codeExponent(int count, const float* z) {
  float largest = 0.0f;
  for (int k = 0; k < count; ++k) largest = std::max(largest, std::fabs(z[k]));
  int exponent = 0;
  while (exponent < kMostCodeExponent && largest > std::ldexp(static_cast<float>(kMostCodeSteps), exponent)) ++exponent;
  return exponent;
}

void packTheta(const Representation& representation, const float* theta, PackedTheta* packed) {
  ThetaForm form = thetaForm(representation, ThetaPrecision::int8);
  float step = representation.isNetwork() ? stepOf(representation.shape()) : 1.0f;
  if (representation.isCode()) {
    const int exponent = codeExponent(form.steps, theta);
    form.steps = codeLength(form.steps, theta);
    step = std::ldexp(1.0f, exponent);
    packed->groups.push_back(static_cast<uint8_t>(form.steps / kCodeGroup + kCodeExponentUnit * exponent));
  }
  for (int d = 0; d < form.steps; ++d) packed->steps.push_back(static_cast<int8_t>(theta[d] / step));
  const float* halves = theta + form.steps;
  for (int n = 0; n < form.halves; ++n) halfFromFloat(halves[n], &packed->halves.emplace_back());
}

void unpackTheta(const Representation& representation, const int8_t* steps, const Half* halves, float* theta) {
  const ThetaForm form = thetaForm(representation, ThetaPrecision::int8);
  const float step = representation.isNetwork() ? stepOf(representation.shape()) : 1.0f;
  for (int d = 0; d < form.steps; ++d) theta[d] = step * static_cast<float>(steps[d]);
  for (int n = 0; n < form.halves; ++n) theta[form.steps + n] = floatFromHalf(halves[n]);
}

bool unpackCode(int count, uint8_t groups, const int8_t* steps, float* theta) {
  const int length = groups % kCodeExponentUnit * kCodeGroup, exponent = groups / kCodeExponentUnit;
  if (length > count) return false;
  const float step = std::ldexp(1.0f, exponent);
  for (int k = 0; k < count; ++k) theta[k] = k < length ? step * static_cast<float>(steps[k]) : 0.0f;
  return codeLength(count, theta) == length && codeExponent(count, theta) == exponent;
}

}  // namespace nlg
