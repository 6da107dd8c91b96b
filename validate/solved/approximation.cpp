#include "validate/solved/approximation.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/evaluate.h"
#include "validate/errors/best_known.h"
#include "validate/errors/policy_run.h"

namespace nlg {

std::vector<StoredFunction> TargetFunctions::views() const {
  std::vector<StoredFunction> all;
  for (size_t n = 0; n < phi.size(); ++n) all.push_back({phi[n].data(), validity[n].data()});
  return all;
}

TargetFunctions targetFunctions(const SolvedScene& scene, const DiffusionRule& rule) {
  TargetFunctions functions;
  for (const ProbeView& view : scene.views) {
    functions.of_probe.push_back(view.free_space ? -1 : static_cast<int>(functions.phi.size()));
    if (view.free_space) continue;
    const std::vector<float> values = generate(scene.table, view, rule);
    std::vector<uint8_t> phi(kSupportPointCount), validity(kValidityByteCount);
    for (int p = 0; p < kSupportPointCount; ++p) {
      if (!view.valid[p]) continue;
      phi[p] = static_cast<uint8_t>(std::lround(255.0f * std::clamp(values[p], 0.0f, 1.0f)));
      validity[p / 8] = static_cast<uint8_t>(validity[p / 8] | 1 << (p % 8));
    }
    functions.phi.push_back(std::move(phi));
    functions.validity.push_back(std::move(validity));
  }
  return functions;
}

std::array<ThetaOfFunctions, kThetaWordCount> thetaByWord(const Generator& generator, const TargetFunctions& functions,
                                                          const PolicyOptions& policy) {
  const std::vector<StoredFunction> views = functions.views();
  const auto theta_count = static_cast<size_t>(generator.representation().thetaCount());
  std::array<ThetaOfFunctions, kThetaWordCount> words;
  for (ThetaOfFunctions& word : words) word.resize(views.size());
  runPolicy({&generator}, views, policy, {}, [&](int, uint64_t function, const MadeTheta&, const ThetaByWord& theta) {
    for (size_t w = 0; w < words.size(); ++w) {
      if (theta[w] != nullptr) words[w][function].assign(theta[w], theta[w] + theta_count);
    }
  });
  return words;
}

ThetaOfFunctions bestKnownTheta(const Generator& generator, const TargetFunctions& functions, const ThetaOfFunctions& starts,
                                const DirectOptions& options) {
  const std::vector<StoredFunction> views = functions.views();
  NormalEquationsKernel kernel;
  ThetaOfFunctions best(views.size());
  for (size_t n = 0; n < views.size(); ++n) {
    if (starts[n].empty()) continue;
    const WeightingFunction function = decodeFunction(views[n], pointOrder(generator.representation()));
    best[n] = fitLong(generator, function, starts[n], options, &kernel).at(LongFit::best_known).theta;
  }
  return best;
}

Approximation approximate(const SolvedScene& scene, const TargetFunctions& functions, const Representation& representation,
                          const ThetaOfFunctions& theta) {
  const SamplePoints& points = scene.points;
  const std::vector<LocalPoint> local = localPoints(points);
  const PointSet places = makePointSet(local);
  const std::vector<float> tents(places.tent.data(), places.tent.data() + local.size());
  const std::vector<StoredFunction> views = functions.views();
  FunctionChecker checker;
  Approximation result;
  std::vector<std::vector<float>> value_of_function;  // at all of `local`
  for (size_t n = 0; n < views.size(); ++n) {
    if (theta[n].empty()) {
      result.function_rmse_mean += checker.checkBareTent(views[n], {}).rmse;
      value_of_function.push_back(tents);
      continue;
    }
    result.function_rmse_mean += checker.check(representation, views[n], theta[n].data(), {}).rmse;
    AlignedFloats values(places.padded_count);
    evaluate(representation, places, theta[n].data(), values.data());
    value_of_function.emplace_back(values.data(), values.data() + local.size());
  }
  result.function_rmse_mean /= std::max<double>(1.0, static_cast<double>(views.size()));
  result.weights.resize(points.count());
  for (size_t i = 0; i < points.count(); ++i) {
    for (int corner = 0; corner < kCornerCount; ++corner) {
      const int probe = points.probe[i][corner];
      if (probe < 0) continue;
      const int function = functions.of_probe[probe];
      const std::vector<float>& values = function < 0 ? tents : value_of_function[function];
      const size_t place = points.cell_point[i] * kCornerCount + corner;
      result.weights[i][corner] = std::clamp(values[place], 0.0f, tents[place]);
    }
  }
  return result;
}

}  // namespace nlg
