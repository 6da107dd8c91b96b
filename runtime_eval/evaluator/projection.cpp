#include "runtime_eval/evaluator/projection.h"

#include <cmath>

#include "runtime_eval/evaluator/mirror_coefficients.h"

namespace nlg {

ProjectionScratch::ProjectionScratch(GeneratorPrecision precision) {
  const size_t count = size_t(kBatchCount) * kClassStride;
  if (precision == GeneratorPrecision::float32) float_classes_.resize(count);
  if (precision == GeneratorPrecision::int16) integer_classes_.resize(count);
}

Projection::Projection(const BasisData& basis, GeneratorPrecision precision)
    : precision_(precision),
      coefficient_count_(basis.coefficientCount()),
      class_count_(basis.class_count),
      bias_(coefficient_count_) {
  const double dequantise = 1.0 / (255.0 * std::sqrt(8.0));
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    const int count = basis.class_count[c];
    std::vector<float> rows(size_t(count) * kOctantPointCount);
    for (int k = 0; k < count; ++k) {
      const float* component = &basis.components[size_t(first + k) * kOctantPointCount];
      const float* mean = &basis.mean[size_t(c) * kOctantPointCount];
      const double inverse_deviation = 1.0 / basis.deviation[first + k];
      double mean_coefficient = 0.0;
      for (int i = 0; i < kOctantPointCount; ++i) {
        rows[size_t(k) * kOctantPointCount + i] = static_cast<float>(component[i] * dequantise * inverse_deviation);
        mean_coefficient += static_cast<double>(mean[i]) * component[i];
      }
      bias_[first + k] = static_cast<float>(-mean_coefficient * inverse_deviation);
    }
    if (precision == GeneratorPrecision::float32) {
      float_components_[c] = PackedMatrix(rows.data(), count, kOctantPointCount);
    } else {
      integer_components_[c] = PackedIntegerMatrix(rows.data(), count, kOctantPointCount, kLargestClassSum);
      // what the integer classes leave out of class 0
      for (int k = 0; c == 0 && k < count; ++k) {
        const double missing = double{kLargestClassSum} * integer_components_[c].weightSum(k);
        bias_[first + k] = static_cast<float>(bias_[first + k] + missing * integer_components_[c].steps()[k]);
      }
    }
    first += count;
  }
}

template <class Sample>
void Projection::projectSamples(const Sample* phi, int count, float* coefficients, ProjectionScratch* scratch) const {
  const bool integers = precision_ == GeneratorPrecision::int16;
  if (integers) {
    parityTransform(phi, count, scratch->integer_classes_.data());
  } else {
    parityTransform(phi, count, scratch->float_classes_.data());
  }
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    const int begin = c * kOctantPointCount;
    if (integers) {
      const IntegerRows rows{scratch->integer_classes_.data() + begin, kClassStride, nullptr};
      multiply(rows, count, integer_components_[c], bias_.data() + first, Epilogue::none, 1.0f, nullptr, coefficients + first,
               coefficient_count_);
      first += integer_components_[c].outputCount();
    } else {
      multiply({scratch->float_classes_.data() + begin, kClassStride}, count, float_components_[c], bias_.data() + first,
               Epilogue::none, 1.0f, coefficients + first, coefficient_count_);
      first += float_components_[c].outputCount();
    }
  }
}

void Projection::mirrorCoefficients(const float* coefficients, int mirror, float* mirrored) const {
  nlg::mirrorCoefficients(class_count_, class_count_, coefficients, mirror, mirrored);
}

void Projection::project(const uint8_t* phi, int count, float* coefficients, ProjectionScratch* scratch) const {
  projectSamples(phi, count, coefficients, scratch);
}

void Projection::project(const float* phi, int count, float* coefficients, ProjectionScratch* scratch) const {
  projectSamples(phi, count, coefficients, scratch);
}

}  // namespace nlg
