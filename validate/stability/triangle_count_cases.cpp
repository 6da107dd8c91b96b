// Scenes of one triangle, and of ten million.

#include <sys/resource.h>

#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "validate/stability/scene_measures.h"

namespace nlg {
namespace {

StabilityResult measureOne(const StabilityInputs& inputs) {
  FaceScene faces;
  faces.addTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, FaceScene::Sides::two);
  StabilityResult result = measureSound(inputs, faces);
  result.holds = result.holds && result.figures.at("functions") > 0;
  return result;
}

// Rolling ground of 2 x 2237² triangles, 100 m across.
Scene tenMillionTriangles() {
  constexpr uint32_t kSide = 2237;
  Scene scene;
  scene.id = "ten million triangles";
  scene.materials.resize(1);
  std::vector<glm::dvec3> positions;
  positions.reserve(size_t{kSide} * kSide);
  for (uint32_t z = 0; z < kSide; ++z) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const double u = 100.0 * x / (kSide - 1), v = 100.0 * z / (kSide - 1);
      positions.emplace_back(u, 2.0 * std::sin(0.31 * u) * std::cos(0.23 * v) + 0.05 * std::sin(9.0 * u + 7.0 * v), v);
    }
  }
  for (uint32_t z = 0; z + 1 < kSide; ++z) {
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = z * kSide + x, b = a + kSide;
      scene.triangles.push_back({a, b, b + 1});
      scene.triangles.push_back({a, b + 1, a + 1});
    }
  }
  scene.triangle_material.assign(scene.triangles.size(), 0);
  scene.objects.push_back({"ground", 0, static_cast<uint32_t>(scene.triangles.size()), false});
  finishScene(scene, positions);
  return scene;
}

StabilityResult measureTenMillion(const StabilityInputs&) {
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = tenMillionTriangles();
  const ProbeFunctions probes = probeFunctions(scene, exactSpacing(1.0), 60);
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const double peak_gb = static_cast<double>(usage.ru_maxrss) * 1024 * 1e-9;
  StabilityResult result;
  result.holds = scene.triangles.size() >= 9990000 && probes.broken == 0 && probes.count(ProbeOutcome::function) > 0;
  result.measured = fmt::format("{} triangles; {}; {:.0f} s, most memory of the process so far {:.1f} GB", scene.triangles.size(),
                                describe(probes), elapsed_s, peak_gb);
  addFigures(probes, &result);
  result.figures["triangles"] = static_cast<double>(scene.triangles.size());
  result.figures["elapsed_s"] = elapsed_s;
  result.figures["peak_memory_gb"] = peak_gb;
  return result;
}

}  // namespace

std::vector<StabilityCase> triangleCountCases() {
  return {
      {"scenes", "one triangle", std::string(kSoundMustHold) + ", and some probe has a function", StabilityDepth::brief, false,
       measureOne},
      {"scenes", "ten million triangles", "functions are made, all of them sound", StabilityDepth::lengthy, false,
       measureTenMillion},
  };
}

}  // namespace nlg
