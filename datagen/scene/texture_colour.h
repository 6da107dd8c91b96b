// The average colour of a texture: all that a scene here needs of an image.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

namespace nlg {

// The mean over all pixels, in linear light, of an sRGB image: JPEG by its first bytes, otherwise Targa (true colour or grey,
// plain or run-length encoded). JPEG: mean over blocks of 8 x 8 pixels. returns   each channel in [0, 1]; nothing for an image
// that is damaged, of another kind, or larger than 8192 pixels a side
std::optional<glm::vec3> averageColour(std::string_view bytes);

}  // namespace nlg
