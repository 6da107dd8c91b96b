#include "export/engine/light_place.h"

#include <cmath>

#include "tool/error.h"

namespace nlg {
namespace {

template <class Three>
std::string spaced(const Three& three) {
  std::string text;
  for (const auto& number : three) text += (text.empty() ? "" : " ") + nlohmann::json(number).dump();
  return text;
}

}  // namespace

nlohmann::ordered_json placeJson(const LightBox& box, const TextureSize& texture_size) {
  return {{"low_m", box.low_m}, {"high_m", box.high_m}, {"resolution", box.texel_count}, {"texture_size", texture_size}};
}

LightBox boxOfPlace(const std::string& name, const std::string& json) {
  LightBox box;
  try {
    const nlohmann::json place = nlohmann::json::parse(json);
    box = {place.at("low_m").get<PositionM>(), place.at("high_m").get<PositionM>(), place.at("resolution").get<TextureSize>()};
  } catch (const nlohmann::json::exception& error) {
    throw InputError(name, "low_m, high_m and resolution", "three numbers each", error.what());
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    if (!(box.low_m[axis] < box.high_m[axis]) || box.texel_count[axis] == 0 || box.texel_count[axis] > kMaxTextureSide)
      throw InputError(name, "axis " + std::to_string(axis), "low below high and 1 to 2048 texels", json);
  }
  return box;
}

std::map<std::string, std::string> placeTexts(const LightBox& box) {
  return {{"KTXwriter", "nlg-export engine"},
          {"nlg.low_m", spaced(box.low_m)},
          {"nlg.high_m", spaced(box.high_m)},
          {"nlg.resolution", spaced(box.texel_count)}};
}

}  // namespace nlg
