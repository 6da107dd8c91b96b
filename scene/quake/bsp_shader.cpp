#include "scene/quake/bsp_shader.h"

#include <algorithm>

#include "scene/quake/bsp_entities.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kMaxScriptBytes = size_t{4} << 20;
constexpr size_t kMaxAllScriptBytes = size_t{64} << 20;
constexpr size_t kMaxShaders = size_t{1} << 16;
constexpr size_t kMaxTextures = 8;
constexpr size_t kMaxSuns = 8;

// What a surfaceparm of a script sets, which is what the game's compiler stores, and why such faces are no geometry: of a face
// with several of these flags the first line says.
struct SurfaceParm {
  std::string_view name;
  uint32_t surface_flags, content_flags;
  const char* drop_reason;
};
constexpr SurfaceParm kSurfaceParms[] = {{"sky", 0x4, 0, "sky"},
                                         {"nodraw", 0x80, 0, "nodraw"},
                                         {"hint", 0x100, 0, "nodraw"},
                                         {"skip", 0x200, 0, "nodraw"},
                                         {"fog", 0, 0x40, "fog"},
                                         {"lava", 0, 0x8, "liquid"},
                                         {"slime", 0, 0x10, "liquid"},
                                         {"water", 0, 0x20, "liquid"},
                                         {"playerclip", 0, 0x10000, "clip"},
                                         {"monsterclip", 0, 0x20000, "clip"},
                                         {"trans", 0, 0x20000000, "translucent"},
                                         {"translucent", 0, 0x20000000, "translucent"}};

void addTexture(std::string_view name, ShaderScript& script) {
  if (name.empty() || name[0] == '$' || name[0] == '*' || name == "-" || script.textures.size() >= kMaxTextures) return;
  script.textures.push_back(shaderKey(name));
}

// The number that a line's next word begins with; 0 when there is none, as the compiler reads it.
double nextNumber(QuakeTokens& tokens) {
  std::string_view word;
  return tokens.nextOnLine(&word) ? leadingNumber(word).value_or(0.0) : 0.0;
}

glm::dvec3 nextColour(QuakeTokens& tokens) {
  glm::dvec3 colour;
  for (int channel = 0; channel < 3; ++channel) colour[channel] = std::max(0.0, nextNumber(tokens));
  return colour;
}

void addSun(bool is_extended, QuakeTokens& tokens, ScriptLight& light) {
  ScriptSun sun;
  sun.colour = nextColour(tokens);
  sun.intensity = std::max(0.0, nextNumber(tokens));
  sun.degrees = nextNumber(tokens);
  sun.elevation = nextNumber(tokens);
  if (is_extended) sun.deviance = std::clamp(nextNumber(tokens), 0.0, 90.0);
  if (light.suns.size() < kMaxSuns) light.suns.push_back(sun);
}

// false for a line that says nothing about light
bool readLightLine(const std::string& keyword, QuakeTokens& tokens, ScriptLight& light) {
  std::string_view word;
  if (keyword == "q3map_surfacelight") {
    light.surface_light = std::max(0.0, nextNumber(tokens));
  } else if (keyword == "q3map_skylight") {
    light.sky_light = std::max(0.0, nextNumber(tokens));
  } else if (keyword == "q3map_lightrgb") {
    light.colour = nextColour(tokens);
  } else if (keyword == "q3map_lightimage") {
    if (tokens.nextOnLine(&word)) light.image = shaderKey(word);
  } else if (keyword == "skyparms") {
    if (tokens.nextOnLine(&word) && word != "-") light.sky_box = shaderKey(word);
  } else if (keyword == "sun" || keyword == "q3map_sun" || keyword == "q3map_sunext") {
    addSun(keyword == "q3map_sunext", tokens, light);
  } else {
    return false;
  }
  return true;
}

// One line inside a shader, outside its stages.
void readGeneralLine(const std::string& keyword, QuakeTokens& tokens, ShaderScript& script) {
  std::string_view word;
  if (readLightLine(keyword, tokens, script.light)) return;
  if (!tokens.nextOnLine(&word)) return;
  const std::string value = lowerCase(word);
  if (keyword == "surfaceparm") {
    for (const SurfaceParm& parm : kSurfaceParms) {
      if (parm.name != value) continue;
      script.surface_flags |= parm.surface_flags;
      script.content_flags |= parm.content_flags;
    }
  } else if (keyword == "cull") {
    script.double_sided = value == "none" || value == "disable" || value == "twosided";
  } else if (keyword == "qer_editorimage") {
    std::vector<std::string> others;
    std::swap(others, script.textures);
    addTexture(word, script);
    for (const std::string& other : others) addTexture(other, script);
  }
}

// What the lines of one stage have said so far.
struct Stage {
  std::string texture, places;  // places: tcGen
  int least_code = 0;
  bool is_detail = false;
};

void readStageLine(const std::string& keyword, QuakeTokens& tokens, Stage& stage) {
  std::string_view word;
  if (keyword == "tcgen" && tokens.nextOnLine(&word)) stage.places = lowerCase(word);
  stage.is_detail = stage.is_detail || keyword == "detail";
  if (keyword == "alphafunc" && tokens.nextOnLine(&word)) {
    const std::string function = lowerCase(word);
    stage.least_code = function == "gt0" ? 1 : function == "ge128" ? 128 : 0;
  }
  if (keyword != "map" && keyword != "clampmap" && keyword != "animmap") return;
  if (keyword == "animmap" && !tokens.nextOnLine(&word)) return;  // its frequency
  if (!tokens.nextOnLine(&word)) return;
  stage.texture = word[0] == '$' || word[0] == '*' ? std::string() : shaderKey(word);
}

void finishStage(const Stage& stage, ShaderScript& script) {
  if (stage.texture.empty()) return;
  if (stage.places == "lightmap") {
    if (script.light_page.empty()) script.light_page = stage.texture;
    return;
  }
  if (stage.places == "environment" || stage.is_detail) return;
  addTexture(stage.texture, script);
  if (script.cut.texture.empty() && stage.least_code > 0) script.cut = {stage.texture, stage.least_code};
}

// What stands between the braces of one shader; the first one has been read.
ShaderScript readBody(QuakeTokens& tokens) {
  // a script has general lines at depth 1 and a stage in braces at depth 2
  ShaderScript script;
  std::string_view word;
  Stage stage;
  int depth = 1;
  const auto open = [&] {
    if (++depth == 2) stage = {};
  };
  const auto close = [&] {
    if (--depth == 1) finishStage(stage, script);
  };
  while (depth > 0 && tokens.next(&word)) {
    if (word == "{") {
      open();
    } else if (word == "}") {
      close();
    } else {
      const std::string keyword = lowerCase(word);
      if (depth == 1) readGeneralLine(keyword, tokens, script);
      if (depth == 2) readStageLine(keyword, tokens, stage);
      // the rest of the line: braces stand on lines of their own, or end it
      while (tokens.nextOnLine(&word) && word != "{" && word != "}") continue;
      if (word == "{") open();
      if (word == "}") close();
    }
  }
  // a text that ends early still counts with what it has said
  if (depth > 1) finishStage(stage, script);
  return script;
}

}  // namespace

std::string shaderKey(std::string_view name) {
  std::string key = lowerCase(name);
  std::replace(key.begin(), key.end(), '\\', '/');
  for (const std::string_view suffix : {".tga", ".jpg", ".png"}) {
    if (key.ends_with(suffix)) key.resize(key.size() - suffix.size());
  }
  return key;
}

void parseShaderScript(std::string_view text, ShaderScripts& scripts) {
  QuakeTokens tokens(text);
  std::string_view name;
  while (tokens.next(&name)) {
    if (name == "{") {
      readBody(tokens);  // a body without a name
      continue;
    }
    std::string_view brace;
    if (name == "}" || !tokens.next(&brace)) continue;
    while (brace != "{") {
      // stray words before a body: the last one names it
      name = brace;
      if (!tokens.next(&brace)) return;
    }
    scripts.emplace(shaderKey(name), readBody(tokens));
  }
}

ShaderScripts readShaderScripts(const Pk3Archives& archives) {
  std::vector<std::string> names = archives.names("scripts/", ".shader");
  std::stable_sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return archives.archiveIndex(a) > archives.archiveIndex(b);
  });
  ShaderScripts scripts;
  size_t total = 0;
  for (const std::string& name : names) {
    const std::string text = archives.read(name, kMaxScriptBytes);
    total += text.size();
    if (total > kMaxAllScriptBytes) throw InputError(archives.path(), name, "at most 64 MiB of shader scripts", "more");
    parseShaderScript(text, scripts);
    if (scripts.size() > kMaxShaders) throw InputError(archives.path(), name, "at most 65536 shaders", "more");
  }
  return scripts;
}

const char* dropReason(uint32_t surface_flags, uint32_t content_flags) {
  for (const SurfaceParm& parm : kSurfaceParms) {
    if ((surface_flags & parm.surface_flags) != 0 || (content_flags & parm.content_flags) != 0) return parm.drop_reason;
  }
  return nullptr;
}

}  // namespace nlg
