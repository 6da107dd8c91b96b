// Writes light.json (keys: docs/reference/formats.md).
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "light/methods/light_method.h"
#include "validate/light/light_figures.h"

namespace nlg {

nlohmann::ordered_json truthJson(const LightPlaces& places, const LightTruth& truth, bool is_baked);

// origin_m   of the scene: positions of the worst places are the world's
nlohmann::ordered_json methodJson(const LightMethod& method, const LightFigures& figures, const LightPlaces& places,
                                  const LightTruth& truth, const std::vector<LightAnswer>& answers, const glm::dvec3& origin_m);

// Lines for a terminal: what of the spacings one looks at first.
std::string lightTable(const nlohmann::ordered_json& spacings);

}  // namespace nlg
