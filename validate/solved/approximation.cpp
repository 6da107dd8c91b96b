#include "validate/solved/approximation.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/function_check.h"

namespace nlg {
namespace {

// The support points' part of a function, as shards hold it.
struct StoredSamples {
  std::vector<uint8_t> phi, validity;

  StoredSamples(const std::vector<float>& values, const std::vector<uint8_t>& valid) : validity(kValidityByteCount) {
    for (int p = 0; p < kSupportPointCount; ++p) {
      phi.push_back(valid[p] ? static_cast<uint8_t>(std::lround(255.0f * std::clamp(values[p], 0.0f, 1.0f))) : 0);
      if (valid[p]) validity[p / 8] = static_cast<uint8_t>(validity[p / 8] | 1 << (p % 8));
    }
  }
};

}  // namespace

Approximation approximate(const SolvedScene& scene, const DiffusionRule& rule, const Representation& representation,
                          const FunctionFit& fit) {
  const SamplePoints& points = scene.points;
  const std::vector<LocalPoint> local = localPoints(points);
  const PointSet places = makePointSet(local);
  std::vector<std::vector<float>> value_of_probe;  // at all of `local`
  FunctionChecker checker;
  Approximation result;
  int function_count = 0;
  for (const ProbeView& view : scene.views) {
    if (view.free_space) {
      value_of_probe.emplace_back(places.tent.data(), places.tent.data() + local.size());
      continue;
    }
    const StoredSamples samples(generate(scene.table, view, rule), view.valid);
    const StoredFunction stored{samples.phi.data(), samples.validity.data()};
    const Theta theta = fit(stored);
    result.function_rmse_mean += checker.check(representation, stored, theta.data(), {}).rmse;
    ++function_count;
    AlignedFloats values(places.padded_count);
    evaluate(representation, places, theta.data(), values.data());
    value_of_probe.emplace_back(values.data(), values.data() + local.size());
  }
  result.function_rmse_mean /= std::max(1, function_count);
  result.weights.resize(points.count());
  for (size_t i = 0; i < points.count(); ++i) {
    for (int corner = 0; corner < kCornerCount; ++corner) {
      const int probe = points.probe[i][corner];
      if (probe < 0) continue;
      result.weights[i][corner] = std::max(0.0f, value_of_probe[probe][points.cell_point[i] * kCornerCount + corner]);
    }
  }
  return result;
}

FunctionFit generatorFit(const Generator& generator) {
  const auto scratch = std::make_shared<GeneratorScratch>(generator);
  const auto corrector = std::make_shared<Corrector>(generator);
  return [&generator, scratch, corrector](const StoredFunction& stored) {
    Theta theta(generator.representation().thetaCount());
    generator.generate(stored.phi, 1, theta.data(), scratch.get());
    corrector->correct(&stored, 1, theta.data());
    return theta;
  };
}

FunctionFit directFit(const Generator& generator, const DirectOptions& options) {
  const auto kernel = std::make_shared<NormalEquationsKernel>();
  return [&generator, options, kernel](const StoredFunction& stored) {
    const Representation& representation = generator.representation();
    const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
    return fitDirect(representation, decodeFunction(stored, pointOrder(representation)), theta0, options, kernel.get())
        .best.theta;
  };
}

}  // namespace nlg
