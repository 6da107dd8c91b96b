// The smallest bake: the weighting function of one probe beside a wall becomes theta, by the policy of nlg-bake.
//
//   bake_minimal WEIGHTS.safetensors
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "nlg/policy.h"

namespace {

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

void print(const char* what, const nlg::FunctionCheck& check) {
  std::printf("%s: RMSE %.5f, leaking points %.2f %%\n", what, check.rmse, 100.0 * check.leak_share);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: bake_minimal WEIGHTS.safetensors\n"), 2;
  nlg::Generator generator;
  const nlg::FileResult loaded = nlg::Generator::load(argv[1], &generator);
  if (!loaded.ok()) return std::fprintf(stderr, "%s (%s)\n", loaded.detail.c_str(), nlg::fileStatusName(loaded.status)), 3;
  const nlg::Representation& representation = generator.representation();
  std::printf("%s, %d numbers a function\n", nlg::representationName(representation), representation.thetaCount());

  // one policy a thread; a real bake gives it thousands of functions in a call
  nlg::ThetaPolicy policy({&generator}, nlg::PolicyOptions{});
  const SampledFunction sampled = besideAWall();
  const nlg::StoredFunction function = {sampled.phi.data(), sampled.validity.data()};
  nlg::MadeTheta made;
  policy.bake(&function, 1, &made);
  if (made.isBareTent()) return std::printf("the bare tent is enough: no theta\n"), 0;

  for (const nlg::ThetaWord word :
       {nlg::ThetaWord::network, nlg::ThetaWord::corrected, nlg::ThetaWord::fitted, nlg::ThetaWord::stored}) {
    print(nlg::wordName(word), made.record.at(word));
  }
  std::printf("%s, by the stage \"%s\" in %.0f microseconds\n",
              made.check().passes(policy.options().check()) ? "accepted" : "still failing", nlg::stageTitle(made.record.ended),
              made.record.elapsedUs(nlg::ThetaWord::stored));
  return 0;
}
