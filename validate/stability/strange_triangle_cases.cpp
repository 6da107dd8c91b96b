// Triangles that no modeller meant: without area, twice, turned round, missing, through probes.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "validate/stability/scene_measures.h"

namespace nlg {
namespace {

// … and what was added changes nothing at all.
StabilityResult measureUnchanged(const StabilityInputs& inputs, const FaceScene& faces, uint32_t expected_drops) {
  const Scene scene = faces.finish();
  const ProbeFunctions room = probeFunctions(inputs, furnishedRoom().finish());
  const ProbeFunctions other = probeFunctions(inputs, scene);
  const FunctionDifference apart = difference(room, other);
  StabilityResult result;
  result.holds = apart.same_bits() && other.broken == 0 && scene.dropped_triangle_count == expected_drops;
  result.measured = fmt::format("{} triangles dropped and counted; against the room without them: {}",
                                scene.dropped_triangle_count, describe(apart));
  addFigures(other, &result);
  addFigures(apart, &result);
  result.figures["dropped_triangles"] = scene.dropped_triangle_count;
  return result;
}

FaceScene withZeroArea(uint32_t* count) {
  FaceScene faces = furnishedRoom();
  Random random(41);
  for (*count = 0; *count < 60; ++*count) {
    const glm::dvec3 a(random.uniform(0, 4), random.uniform(0, 3), random.uniform(0, 4)), b(random.uniform(0, 4), 1.0, 1.0);
    // a point, a line there and back
    faces.addTriangle(a, *count % 2 == 0 ? a : b, a);
  }
  return faces;
}

FaceScene withDuplicates() {
  FaceScene faces = furnishedRoom();
  faces.add(furnishedRoom().finish());
  return faces;
}

FaceScene withSlivers() {
  FaceScene faces = furnishedRoom();
  Random random(43);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 a(random.uniform(0, 3), random.uniform(0, 2), random.uniform(0, 3));
    // 1 m long, a micrometre wide
    faces.addTriangle(a, a + glm::dvec3(1.0, 0.3, 0.2), a + glm::dvec3(0.0, 1e-6, 0.0),
                      i % 2 ? FaceScene::Sides::one : FaceScene::Sides::two);
  }
  return faces;
}

// Every face of share `share` turned round.
FaceScene flipped(double share) {
  FaceScene faces = furnishedRoom();
  Random random(47);
  for (size_t t = 0; t < faces.triangleCount(); ++t) {
    if (random.chance(share)) std::swap(faces.positions()[3 * t + 1], faces.positions()[3 * t + 2]);
  }
  return faces;
}

// Every fifth triangle is missing.
FaceScene open() {
  FaceScene whole = furnishedRoom(), faces;
  for (size_t t = 0; t < whole.triangleCount(); ++t) {
    const glm::dvec3* corners = &whole.positions()[3 * t];
    if (t % 5 != 2) faces.addTriangle(corners[0], corners[1], corners[2]);
  }
  return faces;
}

// Probes on a lattice of 1 m whose planes are the planes of sheets, and vertices that are probes.
StabilityResult measureOnProbes(const StabilityInputs&) {
  FaceScene faces;
  using Sides = FaceScene::Sides;
  faces.addBox({-3, -3, -3}, {3, 3, 3}, true);
  faces.addQuad({-2, 0, -2}, {-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, Sides::two);  // through nine probes
  faces.addQuad({1, -2, -2}, {1, -2, 2}, {1, 2, 2}, {1, 2, -2}, Sides::one);
  faces.addTriangle({-1, 1, -1}, {-1, 1, 1}, {-1, 2, 0}, Sides::two);  // two corners are probes
  const Scene scene = faces.finish();
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 125; ++i) positions.push_back(glm::dvec3(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2) - scene.origin_m);
  const ProbeFunctions once = functionsAt(scene, positions, 1.0f), again = functionsAt(scene, positions, 1.0f);
  uint64_t lit_through = 0;
  // row of a function in the sheet y = 0, inside its rim: lit on one side at most
  uint64_t row = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (once.outcomes[i] != ProbeOutcome::function) continue;
    const glm::dvec3 at = positions[i] + scene.origin_m;
    uint64_t above = 0, below = 0;
    for (int p = 0; p < kSupportPointCount; ++p) {
      const bool lit = once.functions.phi[row * kSupportPointCount + p] > 0;
      above += lit && supportPattern().points[p][1] > 0.001f;
      below += lit && supportPattern().points[p][1] < -0.001f;
    }
    if (at.y == 0.0 && std::fabs(at.x) < 1.0 && std::fabs(at.z) < 1.0) lit_through += std::min(above, below);
    ++row;
  }
  StabilityResult result;
  result.holds = once.broken == 0 && difference(once, again).same_bits() && lit_through == 0;
  result.measured = fmt::format("{}; {} points lit on a second side of a sheet through the probe", describe(once), lit_through);
  addFigures(once, &result);
  result.figures["lit_through"] = static_cast<double>(lit_through);
  return result;
}

StabilityCase soundCase(const std::string& name, StabilityDepth depth, const std::function<FaceScene()>& make) {
  return {"scenes", name,  kSoundMustHold,
          depth,    false, [make](const StabilityInputs& inputs) { return measureSound(inputs, make()); }};
}

}  // namespace

std::vector<StabilityCase> strangeTriangleCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  const std::string unchanged_must_hold = "the functions are bit for bit those of the room without the additions";
  return {
      {"scenes", "triangles of zero area", "all of them are dropped and counted, and " + unchanged_must_hold, brief, false,
       [](const StabilityInputs& inputs) {
         uint32_t count = 0;
         const FaceScene faces = withZeroArea(&count);
         return measureUnchanged(inputs, faces, count);
       }},
      {"scenes", "duplicated triangles", unchanged_must_hold, full, false,
       [](const StabilityInputs& inputs) { return measureUnchanged(inputs, withDuplicates(), 0); }},
      soundCase("slivers of 1e6 to 1", full, withSlivers),
      soundCase("all triangles flipped", full, [] { return flipped(1.0); }),
      soundCase("half of the triangles flipped", full, [] { return flipped(0.5); }),
      soundCase("open geometry, every fifth triangle missing", full, open),
      {"scenes", "coplanar with the probe planes, and exactly on probes",
       "every phi is in [0, 1] and 0 in solid, a second run gives the same bits, and no probe in a sheet lights both sides of it",
       brief, false, measureOnProbes},
  };
}

}  // namespace nlg
