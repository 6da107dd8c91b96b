#include "scene/veils.h"

#include <algorithm>

#include <fmt/format.h>

#include "scene/surface_look.h"
#include "scene/surface_means.h"

namespace nlg {
namespace {

constexpr double kWhole = 0.995;
constexpr size_t kMostNames = 6;

}  // namespace

std::vector<std::string> judgeVeils(Scene& scene, const std::vector<std::string>& names, double dense_veil) {
  std::vector<bool> is_candidate;
  for (const Material& material : scene.materials) is_candidate.push_back(material.veil != Veil::none);
  const std::vector<glm::dvec4> stopped = meansOfMaterials(
      scene, is_candidate, [&](uint32_t triangle, float u, float v) { return glm::dvec3(stoppedAt(scene, triangle, u, v)); });
  std::vector<std::string> veils;
  for (uint32_t i = 0; i < scene.materials.size(); ++i) {
    if (!is_candidate[i]) continue;
    Material& material = scene.materials[i];
    const double share = stopped[i].w > 0.0 ? stopped[i].x : 1.0;
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
