// The light grid that a Quake III level's file ships, as the engine reads it (R_SetupEntityLightingGrid).
//
// Eight cells around are blended, those without any ambient light left out; a plane gets the ambient light, and the directed one by
// the cosine. What that means in irradiance is not known, since it is a light for models of its own: two scales, one for each, are
// fitted to the scene.
#pragma once

#include "light/methods/light_method.h"

namespace nlg {

class QuakeGridLight {
 public:
  // grid   must outlive this object; not empty
  explicit QuakeGridLight(const QuakeGrid& grid) : grid_(grid) {}

  // The scales that come closest to this irradiance; both sums of squares over places and channels. Neither is below 0.
  void fit(const std::vector<glm::dvec3>& positions_m, const std::vector<glm::vec3>& normals,
           const std::vector<glm::vec3>& irradiance);

  // Outside the grid the nearest cells answer, as in the engine; unlit where all eight are in solid.
  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const;

  float ambientScale() const { return ambient_scale_; }
  float directedScale() const { return directed_scale_; }

 private:
  struct Light {
    glm::vec3 ambient{0.0f}, directed{0.0f};  // directed: by the cosine already
    bool is_lit = false;
  };
  Light lightAt(const glm::dvec3& position_m, const glm::vec3& normal) const;

  const QuakeGrid& grid_;
  float ambient_scale_ = 1.0f, directed_scale_ = 1.0f;
};

}  // namespace nlg
