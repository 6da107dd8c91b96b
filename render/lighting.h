// What lights a picture: irradiance at receivers, by ground truth, by a light grid, or by any other method (light/methods/).
#pragma once

#include <functional>
#include <span>
#include <string>

#include "light/methods/light_method.h"
#include "render/sight.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

struct ReceivedLight {
  glm::vec3 irradiance{0.0f};  // >= 0
  glm::vec3 deviation{0.0f};   // standard deviation of its noise, where any is known
  bool is_lit = true;          // false: no light is known there, and irradiance is 0
};

struct Lighting {
  std::string name;
  // Fills received, as many as there are receivers; a pure function of each. Any number of threads may ask at once.
  std::function<void(std::span<const Receiver> receivers, ReceivedLight* received)> light_at;
};

// Ground truth: gathered or path traced at every receiver by itself.
// transport   must outlive the result
Lighting truthLighting(const LightTransport& transport, const GatherOptions& options, uint64_t seed);

// A light grid's look-up.
// grid       that holds light, in the world's coordinates; must outlive the result
// origin_m   the scene's
Lighting gridLighting(const LightGrid& grid, const glm::dvec3& origin_m);

// The share that one probe takes of the grid's blend at every receiver, as a grey irradiance.
Lighting probeShareLighting(const LightGrid& grid, const glm::dvec3& origin_m, uint32_t probe);

// Any other method.
// method   must outlive the result
Lighting measuredLighting(const std::string& name, const LightMethod& method);

}  // namespace nlg
