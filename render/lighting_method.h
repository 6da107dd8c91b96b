// What lights a picture: irradiance at receivers, by ground truth, by a light grid, or by any other method.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "render/sight.h"
#include "runtime_eval/light_grid/light_grid.h"
#include "validate/light/light_method.h"

namespace nlg {

struct ReceivedLight {
  glm::vec3 irradiance{0.0f};  // >= 0
  glm::vec3 deviation{0.0f};   // standard deviation of its noise, where the method knows any
  bool is_lit = true;          // false: the method knows no light there, and irradiance is 0
};

struct LightingMethod {
  std::string name;
  // Fills received, as many as there are receivers; a pure function of each. Any number of threads may ask at once.
  std::function<void(std::span<const Receiver> receivers, ReceivedLight* received)> light_at;
};

// Ground truth: gathered or path traced at every receiver by itself.
// transport   must outlive the method
LightingMethod truthMethod(const LightTransport& transport, const GatherOptions& options, uint64_t seed);

// A light grid's look-up.
// grid       that holds light, in the world's coordinates; must outlive the method
// origin_m   the scene's
LightingMethod gridMethod(const LightGrid& grid, const glm::dvec3& origin_m);

// The share that one probe takes of the grid's blend at every receiver, as a grey irradiance.
LightingMethod probeShareMethod(const LightGrid& grid, const glm::dvec3& origin_m, uint32_t probe);

// A method that nlg-validate light measures.
// method   must outlive the result
LightingMethod measuredMethod(const std::string& name, const LightMethod& method);

}  // namespace nlg
