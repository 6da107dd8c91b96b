// Scenes of extreme size and place, and of triangles that no modeller meant: every probe has an outcome, every function is sound.

#include <sys/resource.h>

#include <algorithm>
#include <bitset>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "datagen/functions/function_collector.h"
#include "datagen/probes/probe_placement.h"
#include "datagen/probes/shuffled_order.h"
#include "runtime_eval/numbers/random.h"
#include "scene/procedural/procedural.h"
#include "validate/stability/face_scene.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

constexpr double kRoomSpacing_m = 0.7;
constexpr uint64_t kSeed = 1;

// What the probes of a scene gave, in one order.
struct ProbeFunctions {
  std::vector<ProbeOutcome> outcomes;
  FunctionRows functions;  // quantised; one row for every outcome `function`
  uint64_t unsound = 0;    // functions with a value that is not in [0, 1], or not 0 at an invalid point
  uint64_t disputed = 0;   // functions whose votes about solid were disputed

  double functionCount() const {
    return static_cast<double>(std::count(outcomes.begin(), outcomes.end(), ProbeOutcome::function));
  }
};

bool isSound(const GeneratedFunction& function) {
  for (size_t p = 0; p < function.phi.size(); ++p) {
    if (!(function.phi[p] >= 0.0f && function.phi[p] <= 1.0f) || (function.valid[p] == 0 && function.phi[p] != 0.0f))
      return false;
  }
  return true;
}

// The functions of up to max_probes probes of a scene, drawn from all by a fixed seed.
ProbeFunctions probeFunctions(const Scene& scene, double spacing_m, uint64_t max_probes) {
  ProbePlacementOptions options;
  options.spacing_min_m = options.spacing_max_m = spacing_m;
  const ProbeTree tree = placeProbes(scene, options, kSeed);
  const RayScene rays(scene);
  WeightingBuilder builder(rays, stabilityLinks(), {});
  ProbeFunctions result;
  result.functions.point_count = kSupportPointCount;
  ShuffledOrder order(tree.probeCount(), kSeed);
  for (uint64_t index = 0; result.outcomes.size() < max_probes && order.next(&index);) {
    const auto [x, y, z] = tree.probePosition(index);
    GeneratedFunction function;
    result.outcomes.push_back(builder.build({x, y, z}, tree.probeSpacing(index), &function));
    result.unsound += !isSound(function);
    if (result.outcomes.back() != ProbeOutcome::function) continue;
    result.disputed += function.open_shell;
    appendFunction(function, {x, y, z}, tree.probeSpacing(index), &result.functions);
  }
  return result;
}

// A scene, and another whose functions its own must be.
struct SceneTrial {
  FaceScene faces;
  std::function<FaceScene()> other;   // none: the same scene, a second time
  double spacing_m = kRoomSpacing_m;  // of the scene; the other's is kRoomSpacing_m
  double share_apart = 0.0;        // of points, how many may differ by more than one byte or in validity; 0: all bits are alike
  uint32_t dropped_triangles = 0;  // by the scene's reader
};

void measureTrial(const StabilityInputs& inputs, const SceneTrial& trial, StabilityFigures* figures) {
  const uint64_t most = inputs.isBrief() ? 24 : 200;
  // the other scene, or the same once more: both runs must agree
  const Scene scene = trial.faces.finish();
  const ProbeFunctions probes = probeFunctions(scene, trial.spacing_m, most);
  const ProbeFunctions others =
      trial.other ? probeFunctions(trial.other().finish(), kRoomSpacing_m, most) : probeFunctions(scene, trial.spacing_m, most);
  figures->show("probes", static_cast<double>(probes.outcomes.size()));
  // every probe has an outcome, and every function is sound
  figures->atLeast("functions", probes.functionCount(), 1);
  figures->show("functions_with_disputed_solid", static_cast<double>(probes.disputed));
  figures->equals("unsound_functions", static_cast<double>(probes.unsound), 0);
  figures->equals("dropped_triangles", scene.dropped_triangle_count, trial.dropped_triangles);
  figures->require(probes.outcomes == others.outcomes, "the two runs have other outcomes");
  if (probes.outcomes != others.outcomes) return;

  // phi in bytes, validity in bits; one byte may differ by rounding
  const FunctionRows &a = probes.functions, &b = others.functions;
  uint64_t apart = 0;
  int largest = 0;
  for (size_t i = 0; i < a.phi.size(); ++i) {
    largest = std::max(largest, std::abs(a.phi[i] - b.phi[i]));
    apart += std::abs(a.phi[i] - b.phi[i]) > 1;
  }
  for (size_t i = 0; i < a.validity.size(); ++i) apart += std::bitset<8>(a.validity[i] ^ b.validity[i]).count();
  figures->show("points_compared", static_cast<double>(a.phi.size()));
  figures->atMost("points_apart", static_cast<double>(apart), trial.share_apart * static_cast<double>(a.phi.size()));
  if (trial.share_apart == 0.0) figures->equals("largest_byte_difference", largest, 0);
}

FaceScene moved(FaceScene faces, double scale, const glm::dvec3& shift) {
  for (glm::dvec3& position : faces.positions()) position = scale * position + shift;
  return faces;
}

// Rounding a position to float moves it by 6e-8 of its size; only points whose link or ray passes an edge so closely may change.
constexpr double kGrazingShare = 1e-4;

SceneTrial scaledRoom(double scale) {
  return {moved(furnishedRoom(), scale, glm::dvec3(0.0)), furnishedRoom, kRoomSpacing_m * scale, kGrazingShare};
}

FaceScene house() {
  FaceScene faces;
  faces.add(makeProceduralScene("house", 3));
  return faces;
}

SceneTrial withZeroArea() {
  constexpr uint32_t kCount = 60;
  SceneTrial trial{furnishedRoom(), furnishedRoom};
  trial.dropped_triangles = kCount;
  Random random(41);
  for (uint32_t i = 0; i < kCount; ++i) {
    const glm::dvec3 a(random.uniform(0, 4), random.uniform(0, 3), random.uniform(0, 4)), b(random.uniform(0, 4), 1.0, 1.0);
    trial.faces.addTriangle(a, i % 2 == 0 ? a : b, a);  // a point; a line there and back
  }
  return trial;
}

SceneTrial withDuplicates() {
  SceneTrial trial{furnishedRoom(), furnishedRoom};
  trial.faces.add(furnishedRoom().finish());
  return trial;
}

SceneTrial withSlivers() {
  SceneTrial trial{furnishedRoom()};
  Random random(43);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 a(random.uniform(0, 3), random.uniform(0, 2), random.uniform(0, 3));
    // 1 m long, a micrometre wide
    trial.faces.addTriangle(a, a + glm::dvec3(1.0, 0.3, 0.2), a + glm::dvec3(0.0, 1e-6, 0.0),
                            i % 2 ? FaceScene::Sides::one : FaceScene::Sides::two);
  }
  return trial;
}

// This share of the faces turned round.
SceneTrial flipped(double share) {
  SceneTrial trial{furnishedRoom()};
  Random random(47);
  for (size_t t = 0; t < trial.faces.triangleCount(); ++t) {
    if (random.chance(share)) std::swap(trial.faces.positions()[3 * t + 1], trial.faces.positions()[3 * t + 2]);
  }
  return trial;
}

// Every fifth triangle is missing.
SceneTrial open() {
  FaceScene whole = furnishedRoom();
  SceneTrial trial;
  for (size_t t = 0; t < whole.triangleCount(); ++t) {
    const glm::dvec3* corners = &whole.positions()[3 * t];
    if (t % 5 != 2) trial.faces.addTriangle(corners[0], corners[1], corners[2]);
  }
  return trial;
}

SceneTrial oneTriangle() {
  SceneTrial trial;
  trial.faces.addTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, FaceScene::Sides::two);
  return trial;
}

// Rolling ground of 2 x 2237² triangles, 100 m across.
Scene tenMillionTriangles() {
  constexpr int kSide = 2237;
  const auto at = [](int x, int z) {
    const double u = 100.0 * x / kSide, v = 100.0 * z / kSide;
    return glm::dvec3(u, 2.0 * std::sin(0.31 * u) * std::cos(0.23 * v) + 0.05 * std::sin(9.0 * u + 7.0 * v), v);
  };
  FaceScene faces;
  for (int z = 0; z < kSide; ++z) {
    for (int x = 0; x < kSide; ++x) faces.addQuad(at(x, z), at(x, z + 1), at(x + 1, z + 1), at(x + 1, z));
  }
  return faces.finish();
}

void measureTenMillion(const StabilityInputs&, StabilityFigures* figures) {
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = tenMillionTriangles();
  const ProbeFunctions probes = probeFunctions(scene, 1.0, 60);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  figures->atLeast("triangles", static_cast<double>(scene.triangles.size()), 1e7);
  figures->atLeast("functions", probes.functionCount(), 1);
  figures->equals("unsound_functions", static_cast<double>(probes.unsound), 0);
  figures->show("elapsed_s", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  figures->show("peak_memory_gb", static_cast<double>(usage.ru_maxrss) * 1024 * 1e-9);  // of the process so far
}

StabilityCase trialCase(const std::string& name, const std::string& must_hold, StabilityDepth depth, SceneTrial (*make)()) {
  return {"scenes",  name,
          must_hold, depth,
          false,     [make](const StabilityInputs& inputs, StabilityFigures* figures) {
            measureTrial(inputs, make(), figures); }};
}

}  // namespace

std::vector<StabilityCase> sceneCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  const std::string scaled =
                        "the functions are those of a room of 4 m but for one point in ten thousand, whose links graze an edge",
                    unchanged = "the functions are bit for bit those of the room without the additions",
                    sound =
                        "every probe has an outcome, every phi is in [0, 1] and 0 in solid, and a second run gives the same bits";
  return {
      trialCase("1 mm across", scaled, brief, [] { return scaledRoom(0.00025); }),
      trialCase("100 km across", scaled, full, [] { return scaledRoom(25000.0); }),
      trialCase("100 km from the origin", "the functions are bit for bit those at the origin", brief,
                [] {
                  return SceneTrial{moved(house(), 1.0, {-100000.0, 3000.0, 70001.0}), house};
                }),
      trialCase("triangles of zero area", "all of them are dropped and counted, and " + unchanged, brief, withZeroArea),
      trialCase("duplicated triangles", unchanged, full, withDuplicates),
      trialCase("slivers of 1e6 to 1", sound, full, withSlivers),
      trialCase("all triangles flipped", sound, full, [] { return flipped(1.0); }),
      trialCase("half of the triangles flipped", sound, full, [] { return flipped(0.5); }),
      trialCase("open geometry, every fifth triangle missing", sound, full, open),
      trialCase("one triangle", sound, brief, oneTriangle),
      {"scenes", "ten million triangles", "functions are made, all of them sound", StabilityDepth::lengthy, false,
       measureTenMillion},
  };
}

}  // namespace nlg
