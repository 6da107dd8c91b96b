#include "runtime_eval/evaluator/generator/projection.h"

#include <algorithm>
#include <cmath>

namespace nlg {

namespace {

// By sample point: the tent.
const std::array<float, kSamplePointCount>& sampleTents() {
  static const std::array<float, kSamplePointCount> tents = [] {
    std::array<float, kSamplePointCount> values{};
    for (int j = 0; j < kSamplePointCount; ++j) values[j] = tent(supportPattern().points[supportPointOf(j)]);
    return values;
  }();
  return tents;
}

bool bitOf(const uint8_t* bits, size_t i) { return bits[i / 8] >> (i % 8) & 1; }

// phiAt, validAt   of a sample point
template <class Phi, class Valid>
void classesOf(const Phi& phiAt, const Valid& validAt, float* classes) {
  const std::array<float, kSamplePointCount>& tents = sampleTents();
  float channels[kMirrorCount][kSampleChannelCount * kOctantSampleCount];
  for (int m = 0; m < kMirrorCount; ++m) {
    for (int t = 0; t < kOctantSampleCount; ++t) {
      const int j = m * kOctantSampleCount + t;
      const float phi = phiAt(j), valid = validAt(j) ? 1.0f : 0.0f;
      const float visibility = std::min(1.0f, phi / std::max(kLeastTent, tents[j]));
      channels[m][t] = phi;
      channels[m][kOctantSampleCount + t] = 0.3f * (visibility - 0.7f) * valid;
      channels[m][2 * kOctantSampleCount + t] = 0.3f * (valid - 0.9f);
    }
  }
  const float scale = 1.0f / std::sqrt(8.0f);
  for (int c = 0; c < kParityClassCount; ++c) {
    float* row = classes + c * inputCount(GeneratorInput::samples);
    std::fill_n(row, inputCount(GeneratorInput::samples), 0.0f);
    for (int m = 0; m < kMirrorCount; ++m) {
      const float sign = scale * mirrorSign(c, m);
      for (int i = 0; i < inputCount(GeneratorInput::samples); ++i) row[i] += sign * channels[m][i];
    }
  }
}

}  // namespace

void sampleClasses(const StoredFunction& function, float* classes) {
  classesOf([&](int j) { return static_cast<float>(function.phi[supportPointOf(j)]) / 255.0f; },
            [&](int j) { return function.isValid(supportPointOf(j)); }, classes);
}

void sampleClasses(const VisibilitySamples& function, float* classes) {
  classesOf([&](int j) { return bitOf(function.seen, j) ? sampleTents()[j] : 0.0f; },
            [&](int j) { return bitOf(function.validity, j); }, classes);
}

void visibilityClasses(const StoredFunction& function, float* classes) {
  classesOf([&](int j) { return bitOf(function.seen, supportPointOf(j)) ? sampleTents()[j] : 0.0f; },
            [&](int j) { return function.isValid(supportPointOf(j)); }, classes);
}

Projection::Projection(const BasisData& basis)
    : input_(basis.input), coefficient_count_(basis.coefficientCount()), bias_(coefficient_count_) {
  const bool is_stored = input_ == GeneratorInput::coefficients;
  const double dequantise = is_stored ? 1.0 / (255.0 * std::sqrt(8.0)) : 1.0;
  const int length = inputCount(input_);
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    const int count = basis.class_count[c];
    std::vector<float> rows(size_t(count) * length);
    for (int k = 0; k < count; ++k) {
      const float* component = &basis.components[size_t(first + k) * length];
      // dequantisation, 1/√8 and the deviation go into the components, the mean into the bias: one product is left
      const double inverse_deviation = 1.0 / basis.deviation[first + k];
      double mean_coefficient = 0.0;
      for (int i = 0; i < length; ++i) {
        rows[size_t(k) * length + i] = static_cast<float>(component[i] * dequantise * inverse_deviation);
        if (is_stored) mean_coefficient += static_cast<double>(basis.mean[size_t(c) * length + i]) * component[i];
      }
      bias_[first + k] = static_cast<float>(-mean_coefficient * inverse_deviation);
    }
    components_[c] = PackedMatrix(rows.data(), count, length);
    first += count;
  }
}

void Projection::multiplyClasses(int count, float* coefficients, const ProjectionScratch& scratch) const {
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    multiply({scratch.classes_.data() + c * inputCount(input_), kClassStride}, count, components_[c], bias_.data() + first,
             Epilogue::none, 1.0f, coefficients + first, coefficient_count_);
    first += components_[c].outputCount();
  }
}

template <class Function>
void Projection::projectSamples(const Function* functions, int count, float* coefficients, ProjectionScratch* scratch) const {
  for (int n = 0; n < count; ++n) sampleClasses(functions[n], &scratch->classes_[size_t(n) * kClassStride]);
  multiplyClasses(count, coefficients, *scratch);
}

void Projection::project(const StoredFunction* functions, int count, float* coefficients, ProjectionScratch* scratch) const {
  if (input_ == GeneratorInput::samples) return projectSamples(functions, count, coefficients, scratch);
  for (int n = 0; n < count; ++n) parityTransform(functions[n].phi, 1, &scratch->classes_[size_t(n) * kClassStride]);
  multiplyClasses(count, coefficients, *scratch);
}

void Projection::project(const VisibilitySamples* functions, int count, float* coefficients, ProjectionScratch* scratch) const {
  projectSamples(functions, count, coefficients, scratch);
}

}  // namespace nlg
