// Where a Quake III level's submodels (doors, platforms) stand, from its entities' text.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

struct BspPlacement {
  std::string classname;         // of the entity that shows the model: "func_door"; empty when none does
  glm::dvec3 origin_units{0.0};  // its vertices are relative to this, in the game's units
};

// One for each model of the level; of several entities that name a model the first one counts. Model 0 stands at the origin.
//
// path     only named in errors
// throws   InputError naming the entity on: more than 2^16 entities, a model that is not there, an origin that is no three
//          numbers within 2^20 units
std::vector<BspPlacement> readPlacements(const std::string& path, std::string_view entities, size_t model_count);

}  // namespace nlg
