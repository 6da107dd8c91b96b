// What matters here of Quake III shader scripts: which faces are no geometry, which have two sides, and a texture for colour.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "datagen/scene/pk3_archive.h"

namespace nlg {

struct ShaderScript {
  uint32_t surface_flags = 0, content_flags = 0;  // bits of bsp_file.h that its surfaceparm lines set
  bool double_sided = false;                      // cull none, disable or twosided
  std::vector<std::string> textures;              // in the order of trust: qer_editorimage, then the stages' maps; no $lightmap
};

// Scripts by the shader's name: lower case, forward slashes, without .tga or .jpg.
using ShaderScripts = std::map<std::string, ShaderScript>;

std::string shaderKey(std::string_view name);

// Adds the shaders of one script's text; one that is there already stays. Lines that are not known are skipped, and a text that
// ends too early ends the shader: games accept such scripts.
void parseShaderScript(std::string_view text, ShaderScripts& scripts);

// All scripts/*.shader. A shader of a later archive hides that of an earlier one; within an archive the first one in the order of
// the scripts' names holds.
// throws   InputError on a script of more than 4 MiB, more than 64 MiB of them, or one that cannot be read
ShaderScripts readShaderScripts(const Pk3Archives& archives);

// Why a face with these flags is no geometry: "sky", "nodraw", "fog", "liquid", "clip" or "translucent", by the first that holds;
// null for a face that is.
const char* dropReason(uint32_t surface_flags, uint32_t content_flags);

}  // namespace nlg
