#include "runtime_eval/evaluator/generator/projection.h"

#include <cmath>

namespace nlg {

Projection::Projection(const BasisData& basis) : coefficient_count_(basis.coefficientCount()), bias_(coefficient_count_) {
  const double dequantise = 1.0 / (255.0 * std::sqrt(8.0));
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    const int count = basis.class_count[c];
    std::vector<float> rows(size_t(count) * kOctantPointCount);
    for (int k = 0; k < count; ++k) {
      const float* component = &basis.components[size_t(first + k) * kOctantPointCount];
      const float* mean = &basis.mean[size_t(c) * kOctantPointCount];
      // dequantisation, 1/√8 and the deviation go into the components, the mean into the bias: one product is left
      const double inverse_deviation = 1.0 / basis.deviation[first + k];
      double mean_coefficient = 0.0;
      for (int i = 0; i < kOctantPointCount; ++i) {
        rows[size_t(k) * kOctantPointCount + i] = static_cast<float>(component[i] * dequantise * inverse_deviation);
        mean_coefficient += static_cast<double>(mean[i]) * component[i];
      }
      bias_[first + k] = static_cast<float>(-mean_coefficient * inverse_deviation);
    }
    components_[c] = PackedMatrix(rows.data(), count, kOctantPointCount);
    first += count;
  }
}

template <class Sample>
void Projection::projectSamples(const Sample* phi, int count, float* coefficients, ProjectionScratch* scratch) const {
  parityTransform(phi, count, scratch->classes_.data());
  int first = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    multiply({scratch->classes_.data() + c * kOctantPointCount, kClassStride}, count, components_[c], bias_.data() + first,
             Epilogue::none, 1.0f, coefficients + first, coefficient_count_);
    first += components_[c].outputCount();
  }
}

void Projection::project(const uint8_t* phi, int count, float* coefficients, ProjectionScratch* scratch) const {
  projectSamples(phi, count, coefficients, scratch);
}

void Projection::project(const float* phi, int count, float* coefficients, ProjectionScratch* scratch) const {
  projectSamples(phi, count, coefficients, scratch);
}

}  // namespace nlg
