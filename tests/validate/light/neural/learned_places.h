// Places with made-up light, for tests of what learns it.
#pragma once

#include "runtime_eval/numbers/random.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

// count places by chance in a box of 8 x 3 x 5 m, away from the origin.
template <class LightAt>
LitPlaces placesWithLight(size_t count, LightAt light_at) {
  LitPlaces lit;
  Random random(11);
  for (size_t i = 0; i < count; ++i) {
    lit.position_m.emplace_back(random.uniform(20.0, 28.0), random.uniform(-1.0, 2.0), random.uniform(3.0, 8.0));
    lit.light.push_back(light_at(lit.position_m.back()));
  }
  return lit;
}

// Light from all sides alike: irradiance is pi times this radiance for every normal.
inline LightSh ambient(const glm::vec3& radiance) {
  LightSh light{};
  light[0] = 3.5449077f * radiance;  // √(4 pi)
  return light;
}

}  // namespace nlg
