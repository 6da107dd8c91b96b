#include "tests/runtime_eval/fit/reference_loss.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace nlg {
namespace {

// A layer of neurons: sums of the inputs, what the activation makes of them, its derivative, and d loss / d sum.
struct Layer {
  std::vector<double> input, value, derivative, delta;
  const double* weights;
  const double* biases;
};

void forward(double slope, const std::vector<double>& input, int width, const double* weights, const double* biases,
             Layer* layer) {
  *layer = {input, std::vector<double>(width), std::vector<double>(width), std::vector<double>(width), weights, biases};
  for (int j = 0; j < width; ++j) {
    double sum = biases[j];
    for (size_t i = 0; i < input.size(); ++i) sum += weights[static_cast<size_t>(j) * input.size() + i] * input[i];
    layer->derivative[j] = sum > 0 ? 1.0 : slope;
    layer->value[j] = layer->derivative[j] * sum;
  }
}

// value_delta   d loss / d value of each neuron
// returns       d loss / d input
std::vector<double> backward(const std::vector<double>& value_delta, Layer* layer, double* weight_gradient,
                             double* bias_gradient) {
  const size_t inputs = layer->input.size();
  std::vector<double> input_delta(inputs, 0.0);
  for (size_t j = 0; j < value_delta.size(); ++j) {
    layer->delta[j] = value_delta[j] * layer->derivative[j];
    bias_gradient[j] += layer->delta[j];
    for (size_t i = 0; i < inputs; ++i) {
      weight_gradient[j * inputs + i] += layer->delta[j] * layer->input[i];
      input_delta[i] += layer->delta[j] * layer->weights[j * inputs + i];
    }
  }
  return input_delta;
}

// The output function and its derivative.
std::pair<double, double> output(OutputFunction function, double sum) {
  if (function == OutputFunction::linear) return {sum, 1.0};
  const double value = 1.0 / (1.0 + std::exp(-sum));
  return {value, value * (1.0 - value)};
}

}  // namespace

double networkLossAndGradientReference(const NetworkKind& network, double slope, const PointSet& points, int first, int count,
                                       const float* phi, const float* mask, const double* theta, double* gradient) {
  const NetworkShape& shape = network.shape;
  std::fill_n(gradient, shape.thetaCount(), 0.0);
  double total = 0.0;
  for (int n = 0; n < count; ++n) {
    Layer layers[2];
    forward(slope, {points.x[first + n], points.y[first + n], points.z[first + n]}, shape.first, theta + shape.w1(),
            theta + shape.b1(), &layers[0]);
    if (shape.second > 0) {
      forward(slope, layers[0].value, shape.second, theta + shape.w2(), theta + shape.b2(), &layers[1]);
    }
    const std::vector<double>& last = layers[shape.second > 0].value;
    double sum = theta[shape.b3()];
    for (int j = 0; j < shape.last(); ++j) sum += theta[shape.w3() + j] * last[j];
    const auto [value, derivative] = output(shape.output, sum);
    const double factor = network.tent_factor ? points.tent[first + n] : 1.0;
    const double residual = mask[n] * (factor * value - phi[n]);
    total += residual * residual;
    const double output_delta = 2 * residual * mask[n] * factor * derivative;
    gradient[shape.b3()] += output_delta;
    std::vector<double> delta(shape.last());
    for (int j = 0; j < shape.last(); ++j) {
      gradient[shape.w3() + j] += output_delta * last[j];
      delta[j] = output_delta * theta[shape.w3() + j];
    }
    if (shape.second > 0) delta = backward(delta, &layers[1], gradient + shape.w2(), gradient + shape.b2());
    backward(delta, &layers[0], gradient + shape.w1(), gradient + shape.b1());
  }
  return total;
}

double networkLossAndGradientReference(const Representation& representation, const PointSet& points, int first, int count,
                                       const float* phi, const float* mask, const double* theta, double* gradient) {
  return networkLossAndGradientReference(representation.network(), representation.slope, points, first, count, phi, mask, theta,
                                         gradient);
}

FieldDerivative fieldDerivativeReference(int resolution, const LocalPoint& point, const double* theta) {
  FieldDerivative result{};
  int node[3];
  double share[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double position = (static_cast<double>(point[axis]) + 1.0) * 0.5 * (resolution - 1);
    node[axis] = std::clamp(static_cast<int>(position), 0, resolution - 2);
    share[axis] = position - node[axis];
  }
  double a = 0.0, b = 0.0, weight[8];
  for (int corner = 0; corner < 8; ++corner) {
    weight[corner] = 1.0;
    for (int axis = 2; axis >= 0; --axis) {
      const int high = corner >> axis & 1;
      weight[corner] *= high ? share[axis] : 1.0 - share[axis];
      result.node[corner] = result.node[corner] * resolution + node[axis] + high;
    }
    a += weight[corner] * theta[2 * result.node[corner]];
    b += weight[corner] * theta[2 * result.node[corner] + 1];
  }
  const double s = 1.0 / (1.0 + std::exp(-b));
  result.value = std::clamp(a, 0.0, 1.0) * s;
  for (int corner = 0; corner < 8; ++corner) {
    result.by_a[corner] = a >= 0.0 && a <= 1.0 ? weight[corner] * s : 0.0;
    result.by_b[corner] = weight[corner] * result.value / (1.0 + std::exp(b));
  }
  return result;
}

double fieldLossAndGradientReference(const PointOrder& order, const float* phi, const float* mask, const double* theta,
                                     double* gradient) {
  std::fill_n(gradient, 2 * order.resolution * order.resolution * order.resolution, 0.0);
  double total = 0.0;
  for (int place = 0; place < order.placeCount(); ++place) {
    const LocalPoint point = {order.points.x[place], order.points.y[place], order.points.z[place]};
    const FieldDerivative field = fieldDerivativeReference(order.resolution, point, theta);
    const double residual = mask[place] * (field.value - phi[place]);
    total += residual * residual;
    for (int corner = 0; corner < 8; ++corner) {
      gradient[2 * field.node[corner]] += 2 * residual * mask[place] * field.by_a[corner];
      gradient[2 * field.node[corner] + 1] += 2 * residual * mask[place] * field.by_b[corner];
    }
  }
  return total;
}

}  // namespace nlg
