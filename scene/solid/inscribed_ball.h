// Whether a ball fits into what faces enclose: what tells rooms from walls.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

using Facet = std::array<glm::vec3, 3>;  // wound outward; those of an inner surface inward

// Whether a ball fits between faces, inside what they enclose: where their winding number is over a half, so that holes matter
// little. It finds every ball of a sixteenth more.
//
// diameter_m   above 0
// cost_left    faces that may still be looked at; lowered by those that were
// returns      nothing where they are too few
std::optional<bool> ballFits(const std::vector<Facet>& faces, double diameter_m, uint64_t* cost_left);

}  // namespace nlg
