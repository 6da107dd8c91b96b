// The average colour of a texture: all that a scene here needs of an image.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "scene/scene_budget.h"

namespace nlg {

// Means over all pixels of an sRGB image, each channel in [0, 1].
struct ImageMeans {
  glm::vec3 linear{0.0f};  // in linear light
  glm::vec3 code{0.0f};    // of the codes themselves, over 255: what Quake III's compilers take for the colour of a light
};

// Of a JPEG by its first bytes, otherwise of a Targa (true colour or grey, plain or run-length encoded). Of a JPEG: the means over
// blocks of 8 x 8 pixels.
//
// pixels        its pixels are taken from this, once for every scan that it is decoded from
// path, place   of the image, for errors
// returns       nothing for an image that is damaged, of another kind (a progressive JPEG among them), or larger than 8192 pixels
//               a side
// throws        InputError on more pixels, times scans, than the budget holds: as soon as that many would be decoded
std::optional<ImageMeans> imageMeans(std::string_view bytes, SceneBudget& pixels, const std::string& path,
                                     const std::string& place);

}  // namespace nlg
