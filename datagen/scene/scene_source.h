// Where a scene comes from: the one text by which users, configurations and shards name it.
#pragma once

#include <string>

#include "datagen/scene/scene.h"

namespace nlg {

struct SceneSource {
  std::string family = "level";  // procedural family, or "level"
  std::string id;                // "house_3", or the file's stem
  std::string sha256;            // of the file; empty for a procedural scene
  Scene scene;
};

// request   FAMILY:SEED for a procedural scene (house:3), otherwise the path of a .glb or .gltf file
// throws    UsageError on a seed that is no decimal number; whatever the reader throws
SceneSource loadScene(const std::string& request);

}  // namespace nlg
