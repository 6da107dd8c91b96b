// Hostile shader scripts of Quake III: every text is one, and what comes of it stays within what bsp_shader.h promises.
#include <cmath>

#include "scene/quake/bsp_shader.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

constexpr double kFarthest = 1048576.0;

void checkNumber(double value) { FUZZ_CHECK(std::abs(value) <= kFarthest, std::to_string(value)); }

void checkLight(const ScriptLight& light) {
  FUZZ_CHECK(light.suns.size() <= 8, std::to_string(light.suns.size()));
  for (const double value : {light.surface_light, light.sky_light}) {
    checkNumber(value);
    FUZZ_CHECK(value >= 0.0, std::to_string(value));
  }
  for (const ScriptSun& sun : light.suns) {
    for (const double value : {sun.colour.x, sun.colour.y, sun.colour.z, sun.intensity, sun.degrees, sun.elevation, sun.deviance})
      checkNumber(value);
    FUZZ_CHECK(sun.deviance >= 0.0 && sun.deviance <= 90.0, std::to_string(sun.deviance));
  }
}

}  // namespace

void readOne(std::string_view bytes) {
  ShaderScripts scripts;
  parseShaderScript(bytes, scripts);
  for (const auto& [name, script] : scripts) {
    FUZZ_CHECK(name == lowerCase(name), name);
    FUZZ_CHECK(script.textures.size() <= 8, name);
    checkLight(script.light);
    dropReason(script.surface_flags, script.content_flags);
  }
}

Seeds seeds() {
  return {{"grate", R"(textures/base/grate
{
  surfaceparm trans
  cull twosided
  qer_editorimage textures/base/grate_editor.jpg
  { map $lightmap }
  { animMap 0.5 textures/a.tga textures/b.tga }
}
)"},
          {"sky", R"(textures/skies/dusk // behind the name
{
  surfaceparm sky
  q3map_sunExt 1 0.9 0.8 65 -30 60 1.5 16
  q3map_skylight 80 4
  skyparms env/dusk 512 -
}
)"},
          {"lava",
           "x\\lava.tga { q3map_lightimage textures/lava.jpg\nq3map_surfacelight 1500\nq3map_lightRGB 1 .5 0\n"
           "surfaceparm lava\n{ clampmap x } } y { /* a comment */ cull none\n}"}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
