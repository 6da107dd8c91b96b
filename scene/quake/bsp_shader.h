// Reads of Quake III shader scripts which faces are not geometry, which have two sides, a texture for colour, and what is
// emissive.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "scene/archive/pk3_archive.h"

namespace nlg {

// A line q3map_sun, q3map_sunExt or sun: numbers as written.
struct ScriptSun {
  glm::dvec3 colour{1.0};
  double intensity = 0.0;
  double degrees = 0.0;    // from the file's x axis towards its y axis
  double elevation = 0.0;  // degrees above the horizon
  double deviance = 0.0;   // degrees: half of what the sun is across
};

// What the level's compiler takes from a shader for light; 0 and empty where the script says nothing. Numbers are within 2^20.
struct ScriptLight {
  double surface_light = 0.0;        // q3map_surfacelight
  double sky_light = 0.0;            // q3map_skylight
  std::optional<glm::dvec3> colour;  // q3map_lightRGB
  std::string image;                 // q3map_lightimage: whose average is the light's colour
  std::string sky_box;               // skyparms: stem of the six images _up, _dn, _rt, _lf, _ft, _bk
  std::vector<ScriptSun> suns;       // at most 8
};

// A stage that shows only part of its texture: alphaFunc GT0 or GE128.
struct ScriptCut {
  std::string texture;  // empty: the script has no such stage
  int least_code = 0;   // opacity, of 255, from which on it is shown
};

struct ShaderScript {
  uint32_t surface_flags = 0, content_flags = 0;  // bits of BspShader that its surfaceparm lines set
  bool double_sided = false;                      // cull none, disable or twosided
  // in the order of trust: qer_editorimage, then the maps of stages that are the surface's colour: no light, reflections and details
  std::vector<std::string> textures;
  std::string light_page;  // of a stage with tcGen lightmap: a file that compilers wrote with -external
  ScriptCut cut;           // of the first such stage
  ScriptLight light;
};

// Scripts by the shader's name: lower case, forward slashes, without .tga, .jpg or .png.
using ShaderScripts = std::map<std::string, ShaderScript>;

std::string shaderKey(std::string_view name);

// Adds the shaders of one script's text; one that is there already stays. Lines that are not known are skipped, and a text that
// ends too early ends the shader: games accept such scripts.
void parseShaderScript(std::string_view text, ShaderScripts& scripts);

// All scripts/*.shader. A shader of a later archive hides that of an earlier one; within an archive the first one in the order of
// the scripts' names holds.
// throws   InputError on a script of more than 4 MiB, more than 64 MiB of them, more than 2^16 shaders, or a script that
//          cannot be read
ShaderScripts readShaderScripts(const Pk3Archives& archives);

// Why a face with these flags is no geometry: "sky", "nodraw", "fog", "liquid", "clip" or "translucent", by the first that holds;
// null for a face that is.
const char* dropReason(uint32_t surface_flags, uint32_t content_flags);

}  // namespace nlg
