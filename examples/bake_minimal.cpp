// The smallest bake: the weighting function of one probe beside a wall becomes theta; refined when the generator missed it.
//
//   bake_minimal WEIGHTS.safetensors
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/adam.h"

namespace {

constexpr double kLargestRmse = 0.02;
constexpr int kRefinementSteps = 400;

// What an engine finds out by tracing rays: how much the probe counts at each support point, and which points lie in solid.
struct SampledFunction {
  std::vector<uint8_t> phi = std::vector<uint8_t>(nlg::kSupportPointCount, 0);
  std::vector<uint8_t> validity = std::vector<uint8_t>(nlg::kValidityByteCount, 0);
};

// A wall from x = 0.3 to 0.4: the tent on the probe's side of it, nothing behind.
SampledFunction besideAWall() {
  SampledFunction function;
  const std::vector<nlg::LocalPoint>& points = nlg::supportPattern().points;
  for (int p = 0; p < nlg::kSupportPointCount; ++p) {
    const float x = points[p][0];
    if (x < 0.3f) function.phi[p] = static_cast<uint8_t>(std::lround(255.0f * nlg::tent(points[p])));
    if (x < 0.3f || x > 0.4f) function.validity[p / 8] |= static_cast<uint8_t>(1 << (p % 8));
  }
  return function;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: bake_minimal WEIGHTS.safetensors\n"), 2;
  nlg::Generator generator;
  const nlg::WeightsResult loaded = nlg::Generator::load(argv[1], &generator);
  if (!loaded.ok()) return std::fprintf(stderr, "%s (%s)\n", loaded.detail.c_str(), nlg::weightsStatusName(loaded.status)), 3;
  const nlg::Representation& representation = generator.representation();
  std::printf("%s, %d numbers a function\n", nlg::representationName(representation), representation.thetaCount());

  // one scratch a thread; a real bake generates thousands of functions in a call
  nlg::GeneratorScratch scratch(generator);
  const SampledFunction sampled = besideAWall();
  nlg::Theta theta(representation.thetaCount());
  generator.generate(sampled.phi.data(), 1, theta.data(), &scratch);

  const nlg::WeightingFunction function =
      nlg::decodeFunction({sampled.phi.data(), sampled.validity.data()}, nlg::pointOrder(representation));
  const double rmse = nlg::functionRmse(representation, function, theta.data());
  std::printf("generated: RMSE %.5f\n", rmse);
  if (rmse <= kLargestRmse) return 0;

  const nlg::FitResult refined =
      nlg::fitAdam(representation, function, theta, nlg::refinementAdam(representation, kRefinementSteps));
  std::printf("refined: RMSE %.5f after %d steps\n", refined.rmse, refined.steps);
  return 0;
}
