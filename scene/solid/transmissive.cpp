#include "scene/solid/transmissive.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scene/model/oddities.h"
#include "scene/model/surface_look.h"

namespace nlg {
namespace {

constexpr double kWhole = 0.995;

// Points of a material, over all of its triangles, and of one of them. A triangle goes on where the one before it ended: one
// point of each of many fills their image as evenly as many points of one.
constexpr uint64_t kMaterialPoints = 65536, kMostPoints = 4096;

double areaOf(const Scene& scene, uint32_t triangle) {
  const glm::uvec3& t = scene.triangles[triangle];
  const glm::dvec3 a(scene.positions[t.x]);
  return 0.5 * glm::length(glm::cross(glm::dvec3(scene.positions[t.y]) - a, glm::dvec3(scene.positions[t.z]) - a));
}

// The sequence R2, folded: http://extremelearning.com.au/evenly-distributing-points-in-a-triangle
glm::vec2 pointOf(uint64_t i) {
  const auto fraction = [](double x) { return x - std::floor(x); };
  const auto n = static_cast<double>(i);
  const glm::dvec2 p(fraction(0.5 + 0.7548776662466927 * n), fraction(0.5 + 0.5698402909980532 * n));
  return glm::vec2(p.x + p.y > 1.0 ? 1.0 - p : p);
}

}  // namespace

std::vector<std::string> judgeTransmissive(Scene& scene, const std::vector<std::string>& names, double dense_transmissive) {
  // share of light that a material stops, the mean over its area
  std::vector<bool> is_candidate;
  for (const Material& material : scene.materials) is_candidate.push_back(material.transmissive != Transmissive::none);
  const std::vector<glm::dvec4> stopped = meansOfMaterials(
      scene, is_candidate, [&](uint32_t triangle, float u, float v) { return glm::dvec3(stoppedAt(scene, triangle, u, v)); });
  std::vector<std::string> transmissive;
  for (uint32_t i = 0; i < scene.materials.size(); ++i) {
    if (!is_candidate[i]) continue;
    Material& material = scene.materials[i];
    const double share = stopped[i].w > 0.0 ? stopped[i].x : 1.0;
    // an alpha channel that cuts nothing out leaves an opaque material
    if (share >= kWhole) {
      material.transmissive = Transmissive::none;
      material.opacity = 1.0f;
      material.transmission = 0.0f;
      material.transmission_image = {};
      continue;
    }
    // dense: blocks links and rays; thin: counts as air
    material.transmissive = share >= dense_transmissive ? Transmissive::dense : Transmissive::thin;
    // the back of a sheet is no evidence of solid
    material.double_sided = true;
    const std::string name = i < names.size() && !names[i].empty() ? names[i].substr(0, 60) : fmt::format("material {}", i);
    transmissive.push_back(fmt::format("{} ({}, stops {:.0f} %)", name,
                                       material.transmissive == Transmissive::dense ? "dense" : "thin", 100.0 * share));
  }
  if (transmissive.empty()) return {};
  return {counted(transmissive.size(), "material lets", "materials let") + " light through: " + listed(transmissive)};
}

std::vector<glm::dvec4> meansOfMaterials(const Scene& scene, const std::vector<bool>& is_wanted,
                                         const std::function<glm::dvec3(uint32_t triangle, float u, float v)>& at) {
  std::vector<uint64_t> triangle_count(scene.materials.size());
  for (const uint32_t material : scene.triangle_material) ++triangle_count[material];
  std::vector<glm::dvec4> means(scene.materials.size(), glm::dvec4(0.0));
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const uint32_t material = scene.triangle_material[i];
    if (!is_wanted[material]) continue;
    const uint64_t point_count = std::clamp<uint64_t>(kMaterialPoints / triangle_count[material], 1, kMostPoints);
    glm::dvec3 sum(0.0);
    for (uint64_t k = 0; k < point_count; ++k) {
      const glm::vec2 point = pointOf(i * point_count + k);
      sum += at(i, point.x, point.y);
    }
    means[material] += areaOf(scene, i) * glm::dvec4(sum / static_cast<double>(point_count), 1.0);
  }
  for (glm::dvec4& mean : means) {
    if (mean.w > 0.0) mean = glm::dvec4(glm::dvec3(mean) / mean.w, mean.w);
  }
  return means;
}

}  // namespace nlg
