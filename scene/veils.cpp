#include "scene/veils.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scene/surface_look.h"

namespace nlg {
namespace {

constexpr double kWhole = 0.995;
// Points of a material, over all of its triangles, and of one of them.
constexpr uint64_t kMaterialPoints = 65536, kLeastPoints = 16, kMostPoints = 4096;
constexpr size_t kMostNames = 6;

double areaOf(const Scene& scene, uint32_t triangle) {
  const glm::uvec3& t = scene.triangles[triangle];
  const glm::dvec3 a(scene.positions[t.x]);
  return 0.5 * glm::length(glm::cross(glm::dvec3(scene.positions[t.y]) - a, glm::dvec3(scene.positions[t.z]) - a));
}

// The mean over one triangle, by points that fill it evenly: http://extremelearning.com.au/evenly-distributing-points-in-a-triangle
double stoppedBy(const Scene& scene, uint32_t triangle, uint64_t point_count) {
  double sum = 0.0;
  for (uint64_t i = 0; i < point_count; ++i) {
    const auto fraction = [](double x) { return x - std::floor(x); };
    const auto n = static_cast<double>(i);
    double u = fraction(0.5 + 0.7548776662466927 * n), v = fraction(0.5 + 0.5698402909980532 * n);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    sum += stoppedAt(scene, triangle, static_cast<float>(u), static_cast<float>(v));
  }
  return sum / static_cast<double>(point_count);
}

}  // namespace

std::vector<std::string> judgeVeils(Scene& scene, const std::vector<std::string>& names, double dense_veil) {
  const auto isCandidate = [&](uint32_t material) { return scene.materials[material].veil != Veil::none; };
  std::vector<uint64_t> triangle_count(scene.materials.size());
  std::vector<double> area(scene.materials.size()), stopped(scene.materials.size());
  for (const uint32_t material : scene.triangle_material) ++triangle_count[material];
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const uint32_t material = scene.triangle_material[i];
    if (!isCandidate(material)) continue;
    const uint64_t points = std::clamp(kMaterialPoints / triangle_count[material], kLeastPoints, kMostPoints);
    const double triangle_area = areaOf(scene, i);
    area[material] += triangle_area;
    stopped[material] += triangle_area * stoppedBy(scene, i, points);
  }
  std::vector<std::string> veils;
  for (uint32_t i = 0; i < scene.materials.size(); ++i) {
    if (!isCandidate(i)) continue;
    Material& material = scene.materials[i];
    const double share = area[i] > 0.0 ? stopped[i] / area[i] : 1.0;
    if (share >= kWhole) {
      material.veil = Veil::none;
      material.opacity = 1.0f;
      material.transmission = 0.0f;
      material.transmission_image = {};
      continue;
    }
    material.veil = share >= dense_veil ? Veil::dense : Veil::thin;
    material.double_sided = true;
    const std::string name = i < names.size() && !names[i].empty() ? names[i].substr(0, 60) : fmt::format("material {}", i);
    veils.push_back(fmt::format("{} ({}, stops {:.0f} %)", name, material.veil == Veil::dense ? "dense" : "thin", 100.0 * share));
  }
  if (veils.empty()) return {};
  std::string line = fmt::format("{} {} light through: ", veils.size(), veils.size() == 1 ? "material lets" : "materials let");
  for (size_t i = 0; i < std::min(veils.size(), kMostNames); ++i) line += (i > 0 ? ", " : "") + veils[i];
  if (veils.size() > kMostNames) line += fmt::format(" and {} more", veils.size() - kMostNames);
  return {line};
}

}  // namespace nlg
