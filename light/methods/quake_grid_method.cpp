#include "light/methods/quake_grid_method.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"

namespace nlg {

QuakeGridLight::Light QuakeGridLight::lightAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
  std::array<int, 3> low{};
  glm::vec3 share;
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = (position_m[axis] - double{grid_.first_m[axis]}) / double{grid_.step_m[axis]};
    const double inside = std::clamp(cells, 0.0, static_cast<double>(grid_.count[axis] - 1));
    low[axis] = std::min(static_cast<int>(inside), std::max(0, grid_.count[axis] - 2));
    share[axis] = static_cast<float>(inside - low[axis]);
  }
  Light light;
  glm::vec3 direction(0.0f), directed(0.0f);
  float weights = 0.0f;
  for (int corner = 0; corner < 8; ++corner) {
    float weight = 1.0f;
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = corner >> axis & 1;
      weight *= high ? share[axis] : 1.0f - share[axis];
      at[axis] = std::min(low[axis] + static_cast<int>(high), grid_.count[axis] - 1);
    }
    const QuakeGrid::Cell& cell = grid_.cells[(static_cast<size_t>(at[2]) * grid_.count[1] + at[1]) * grid_.count[0] + at[0]];
    if (cell.ambient == glm::vec3(0.0f)) continue;  // in solid
    weights += weight;
    light.ambient += weight * cell.ambient;
    directed += weight * cell.directed;
    direction += weight * cell.to_light;
  }
  if (!(weights > 0.0f)) return light;
  light.is_lit = true;
  light.ambient /= weights;
  const float length = glm::length(direction);
  const float cosine = length > 0.0f ? std::max(0.0f, glm::dot(normal, direction / length)) : 0.0f;
  light.directed = directed / weights * cosine;
  return light;
}

void QuakeGridLight::fit(const std::vector<glm::dvec3>& positions_m, const std::vector<glm::vec3>& normals,
                         const std::vector<glm::vec3>& irradiance) {
  NLG_CHECK(positions_m.size(), ==, normals.size());
  NLG_CHECK(positions_m.size(), ==, irradiance.size());
  double aa = 0.0, ad = 0.0, dd = 0.0, ae = 0.0, de = 0.0;
  const auto dot = [](const glm::vec3& a, const glm::vec3& b) { return glm::dot(glm::dvec3(a), glm::dvec3(b)); };
  for (size_t i = 0; i < positions_m.size(); ++i) {
    const Light light = lightAt(positions_m[i], normals[i]);
    aa += dot(light.ambient, light.ambient);
    ad += dot(light.ambient, light.directed);
    dd += dot(light.directed, light.directed);
    ae += dot(light.ambient, irradiance[i]);
    de += dot(light.directed, irradiance[i]);
  }
  const double determinant = aa * dd - ad * ad;
  double ambient = 0.0, directed = 0.0;
  if (determinant > 0.0) {
    ambient = (ae * dd - de * ad) / determinant;
    directed = (de * aa - ae * ad) / determinant;
  }
  // one alone where the two together would take the other below 0
  if (!(determinant > 0.0) || ambient < 0.0 || directed < 0.0) {
    const bool by_ambient = aa > 0.0 && (!(dd > 0.0) || ae * ae / aa >= de * de / dd);
    ambient = by_ambient ? std::max(0.0, ae / aa) : 0.0;
    directed = !by_ambient && dd > 0.0 ? std::max(0.0, de / dd) : 0.0;
  }
  ambient_scale_ = static_cast<float>(ambient);
  directed_scale_ = static_cast<float>(directed);
}

LightAnswer QuakeGridLight::irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
  const Light light = lightAt(position_m, normal);
  return {ambient_scale_ * light.ambient + directed_scale_ * light.directed, light.is_lit ? Reach::lit : Reach::unlit};
}

}  // namespace nlg
