// Average colour of an image, for skies and for lights that name one.
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

// pixels        its pixels are taken from this, as decodeImage does
// path, place   of the image, for errors
// returns       nothing for an image that decodeImage does not decode
// throws        InputError on more pixels, times scans, than the budget holds: as soon as that many would be decoded
std::optional<ImageMeans> imageMeans(std::string_view bytes, SceneBudget& pixels, const std::string& path,
                                     const std::string& place);

}  // namespace nlg
