// What our own light grid's look-up gives (irradiance.h): shares, the weights that a bake solves with, and light.
#pragma once

#include "light/methods/light_method.h"
#include "light/probe_light.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

class GridWeighting : public Weighting {
 public:
  // grid   in the world's coordinates, positions relative to the scene's origin; must outlive this object
  GridWeighting(const LightGrid& grid, const glm::dvec3& origin_m)
      : grid_(grid), origin_m_(origin_m), weights_of_grid_(weightsOf(grid, origin_m)) {}
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;
  ProbeWeights weightsAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  const LightGrid& grid_;
  const glm::dvec3 origin_m_;
  const WeightsAt weights_of_grid_;
};

// Of a grid that holds light: where its weights know nothing, that light decides who answers. The grid must outlive it.
std::function<LightAnswer(const glm::dvec3&, const glm::vec3&)> lookedUpLight(const LightGrid& grid, const glm::dvec3& origin_m);

}  // namespace nlg
