// Product fields: values, gradient, normal equations and the systems that Levenberg–Marquardt solves with them.
//
// Times are of all 8192 support points; product fields read them cell after cell, each cell filled up to whole vectors.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/fit/field_loss.h"
#include "runtime_eval/fit/field_normal_equations.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// A in [-0.1, 1.1], B normal.
Theta sampleField(int resolution) {
  Random random(1);
  Theta theta(Representation::productField(resolution).thetaCount());
  for (size_t i = 0; i < theta.size(); i += 2) {
    theta[i] = static_cast<float>(random.uniform(-0.1, 1.1));
    theta[i + 1] = static_cast<float>(random.normal());
  }
  return theta;
}

void evaluateAllCells(benchmark::State& state, int resolution) {
  const Theta theta = sampleField(resolution);
  AlignedFloats values(cellOrder(resolution).placeCount());
  for (auto _ : state) {
    evaluateFieldCells(cellOrder(resolution), theta.data(), values.data());
    benchmark::DoNotOptimize(values.data());
  }
}

void evaluateAnyPoints(benchmark::State& state, int resolution) {
  const Theta theta = sampleField(resolution);
  const PointSet points = makePointSet(testPoints(kSupportPointCount));
  AlignedFloats values(points.padded_count);
  for (auto _ : state) {
    evaluateField(resolution, points, theta.data(), values.data());
    benchmark::DoNotOptimize(values.data());
  }
}

void gradient(benchmark::State& state, int resolution) {
  const PointOrder& order = cellOrder(resolution);
  const WeightingFunction function = tentFunction(order);
  const Theta theta = sampleField(resolution);
  Theta result(theta.size());
  for (auto _ : state) {
    benchmark::DoNotOptimize(fieldLossAndGradient(order, function.phi.data(), function.mask.data(), theta.data(), result.data()));
  }
}

void normalEquations(benchmark::State& state, int resolution) {
  const PointOrder& order = cellOrder(resolution);
  const WeightingFunction function = tentFunction(order);
  const Theta theta = sampleField(resolution);
  NormalEquations equations;
  for (auto _ : state) fieldNormalEquations(order, function, theta.data(), &equations);
}

#define NLG_EACH_RESOLUTION(benchmark_function, name, shape)               \
  BENCHMARK_CAPTURE(benchmark_function, pf3, 3)->Name(name "/pf3/" shape); \
  BENCHMARK_CAPTURE(benchmark_function, pf5, 5)->Name(name "/pf5/" shape); \
  BENCHMARK_CAPTURE(benchmark_function, pf7, 7)->Name(name "/pf7/" shape); \
  BENCHMARK_CAPTURE(benchmark_function, pf9, 9)->Name(name "/pf9/" shape)

NLG_EACH_RESOLUTION(evaluateAllCells, "evaluate", "8192_points");
NLG_EACH_RESOLUTION(evaluateAnyPoints, "evaluate_anywhere", "8192_points");
NLG_EACH_RESOLUTION(gradient, "loss_and_gradient", "8192_points");
NLG_EACH_RESOLUTION(normalEquations, "normal_equations", "8192_points");

// Factors and solves; with the copy of the matrix that this destroys.
void solve(benchmark::State& state, int count, int bandwidth) {
  Random random(1);
  SymmetricBand matrix(count, bandwidth), destroyed;
  for (int row = 0; row < count; ++row) {
    for (int column = std::max(0, row - bandwidth); column < row; ++column) matrix.at(row, column) = random.uniform(-1.0, 1.0);
    matrix.at(row, row) = 2.0 * bandwidth + 1.0;
  }
  std::vector<double> x(count);
  for (auto _ : state) {
    destroyed = matrix;
    std::fill(x.begin(), x.end(), 1.0);
    benchmark::DoNotOptimize(destroyed.solve(x.data()));
  }
}
BENCHMARK_CAPTURE(solve, full, 113, 112)->Name("band_solve/networks/113_full");
BENCHMARK_CAPTURE(solve, pf3, 54, 27)->Name("band_solve/pf3/54_by_27");
BENCHMARK_CAPTURE(solve, pf5, 250, 63)->Name("band_solve/pf5/250_by_63");
BENCHMARK_CAPTURE(solve, pf7, 686, 115)->Name("band_solve/pf7/686_by_115");
BENCHMARK_CAPTURE(solve, pf9, 1458, 183)->Name("band_solve/pf9/1458_by_183");

}  // namespace
}  // namespace nlg
