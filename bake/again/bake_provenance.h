// Provenance of a bake in the file of its light grid.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "bake/prepared_scene.h"
#include "tool/command/options.h"

namespace nlg {

// Roles of inputs. That of light has another name whenever the list of what the hashes are of becomes another one (scene/model/scene.cpp).
inline constexpr const char* kWeightsRole = "weights of ";
inline constexpr const char* kLightRole = "scene and light";
inline constexpr const char* kUngroupedRole = "scene and light without groups";  // of scenes that have any
inline constexpr const char* kSearchedRole = "cells searched for air";           // PreparedScene::searched_sha256

// The settings that what a grid holds depends on.
nlohmann::ordered_json bakedOptions(const OptionTable& table);

// Settings that no relight changes and none can ask for: what functions took, on which machine.
inline constexpr const char* kOfFunctions[] = {"refine_seconds", "simd"};
// Settings that functions do not depend on, and those.
std::set<std::string> lightSettings(const OptionTable& table);

// options   as bakedOptions has them
// weights   SHA-256 by kWeightsRole + representation
GridMetadata bakeMetadata(const PreparedScene& scene, const nlohmann::ordered_json& options,
                          const std::map<std::string, std::string>& weights);

// Finest distance between the probes of a baked grid, metres, outside boxes with a spacing of their own (nlg_density).
double bakedSpacing(const LightGrid& grid, const GridMetadata& metadata);

}  // namespace nlg
