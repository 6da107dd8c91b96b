// Where a texture of light stands in a level: light.json, beside the texture of every format, and texts inside of KTX2 files.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "export/engine/texture_3d.h"
#include "runtime_eval/light_grid/resampled_light.h"

namespace nlg {

// {"low_m", "high_m": three numbers; "resolution", "texture_size": three integers}
nlohmann::ordered_json placeJson(const LightBox& box, const TextureSize& texture_size);

// The box of such a text; other keys are not read.
// name     of the file, for errors
// throws   InputError where one of the keys is missing or a number is not one of a box
LightBox boxOfPlace(const std::string& name, const std::string& json);

// Texts of a KTX2 file: KTXwriter, nlg.low_m, nlg.high_m and nlg.resolution, three numbers each, with spaces between them.
std::map<std::string, std::string> placeTexts(const LightBox& box);

}  // namespace nlg
