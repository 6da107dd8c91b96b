// nlg-datagen info SCENE: what a scene holds, without a bake.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "scene/scene_source.h"

namespace nlg {

// Whether `info` takes a request for a shard: a file that ends in .h5, and whatever other file is none that scenes are read from.
bool isShardRequest(const std::string& request);

// Triangles, size, materials, images, what is solid, lights in their units, and what was not read.
// throws   as loadScene does
nlohmann::ordered_json describeScene(const std::string& request, const SceneReading& reading);

// The same for people, on a dozen lines and one for each thing that was not read.
std::string sceneText(const nlohmann::ordered_json& scene);

}  // namespace nlg
