// The average colour of a texture: all that a scene here needs of an image.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

namespace nlg {

// The mean over all pixels, in linear light, of an sRGB image: JPEG by its first bytes, otherwise Targa (true colour or grey,
// plain or run-length encoded). Of a JPEG: the mean over blocks of 8 x 8 pixels.
//
// returns   each channel in [0, 1]; nothing for an image that is damaged, of another kind (a progressive JPEG among them), or
//           larger than 8192 pixels a side
std::optional<glm::vec3> averageColour(std::string_view bytes);

// The same mean of the codes themselves, over 255: what Quake III's compilers take for the colour of a light.
std::optional<glm::vec3> averageCode(std::string_view bytes);

}  // namespace nlg
