#include <cmath>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"

namespace nlg {
namespace {

std::vector<double> coefficientsReference(const BasisData& basis, const double* phi) {
  std::vector<double> coefficients;
  for (int c = 0; c < kParityClassCount; ++c) {
    std::vector<double> parity(kOctantPointCount, 0.0);
    for (int m = 0; m < kMirrorCount; ++m) {
      for (int i = 0; i < kOctantPointCount; ++i) {
        parity[i] += mirrorSign(c, m) * phi[m * kOctantPointCount + i] / std::sqrt(8.0);
      }
    }
    for (int k = 0; k < basis.class_count[c]; ++k) {
      const size_t row = coefficients.size();
      double sum = 0.0;
      for (int i = 0; i < kOctantPointCount; ++i) {
        sum += (parity[i] - basis.mean[c * kOctantPointCount + i]) * basis.components[row * kOctantPointCount + i];
      }
      coefficients.push_back(sum / basis.deviation[row]);
    }
  }
  return coefficients;
}

std::vector<double> runLayersReference(const std::vector<GeneratorLayer>& layers, double slope, std::vector<double> values) {
  for (size_t l = 0; l < layers.size(); ++l) {
    const GeneratorLayer& layer = layers[l];
    std::vector<double> outputs(layer.output_count);
    for (int o = 0; o < layer.output_count; ++o) {
      double sum = layer.bias[o];
      for (int i = 0; i < layer.input_count; ++i)
        sum += static_cast<double>(layer.weight[size_t(o) * layer.input_count + i]) * values[i];
      if (l + 1 == layers.size()) {
        outputs[o] = sum;
      } else {
        outputs[o] = sum > 0 ? sum : slope * sum;
        if (layer.input_count == layer.output_count) outputs[o] += values[o];
      }
    }
    values = std::move(outputs);
  }
  return values;
}

}  // namespace

std::vector<double> generateReference(const GeneratorData& data, const double* phi) {
  std::vector<double> theta = runLayersReference(data.layers, data.slope, coefficientsReference(data.basis, phi));
  for (size_t i = 0; i < theta.size(); ++i) theta[i] = data.theta0[i] + data.output_scale[i] * theta[i];
  return theta;
}

}  // namespace nlg
