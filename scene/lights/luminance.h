// Luminance of a colour.
#pragma once

#include <glm/glm.hpp>

namespace nlg {

// Of linear red, green and blue by ITU-R BT.709.
inline float luminance(const glm::vec3& rgb) { return 0.2126f * rgb.r + 0.7152f * rgb.g + 0.0722f * rgb.b; }

}  // namespace nlg
