// Where a scene comes from: the one text by which users, configurations and shards name it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "datagen/scene/scene.h"

namespace nlg {

struct SceneSource {
  std::string family = "level";  // procedural family, name of a built-in scene, or "level"
  std::string id;                // "house_3", the file's stem, or the map's name in lower case
  std::string sha256;            // of the scene as it was read: sceneSha256; empty for a procedural one
  Scene scene;
  std::map<std::string, uint32_t> dropped_faces;  // of a .bsp, by why: bsp_reader.h
  uint32_t materials_without_texture = 0;         // of a .bsp: these have the default colour
  std::vector<std::string> light_notes;           // what its light lost in reading (bsp_reader.h), or was given (light_options.h)
};

// request   FAMILY:SEED for a procedural scene (house:3), NAME or NAME:SEED for a built-in one (cornell, two_rooms:1);
//           PATH:MAP for a level in archives, PATH a .pk3 file or a folder of them (baseoa:kaos2 is maps/kaos2.bsp);
//           otherwise the path of a .glb, .gltf or .bsp file
// throws    UsageError on a seed that is no decimal number; whatever the reader throws
SceneSource loadScene(const std::string& request);

}  // namespace nlg
