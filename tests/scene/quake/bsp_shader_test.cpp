#include "scene/quake/bsp_shader.h"

#include <gtest/gtest.h>

#include "hand_built_bsp.h"
#include "scene/quake/bsp_entities.h"
#include "scene/quake/bsp_file.h"
#include "scene/quake/bsp_looks.h"
#include "tests/scene/image/hand_built_images.h"

namespace nlg {
namespace {

ShaderScripts parse(const std::string& text) {
  ShaderScripts scripts;
  parseShaderScript(text, scripts);
  return scripts;
}

TEST(QuakeTokens, SplitsWordsQuotesBracesAndComments) {
  QuakeTokens tokens("one // two\n\"three four\"{five} /* six \n */ se//ven \"eight");
  std::vector<std::string> words;
  for (std::string_view word; tokens.next(&word);) words.emplace_back(word);
  EXPECT_EQ(words, (std::vector<std::string>{"one", "three four", "{", "five", "}", "se//ven", "eight"}));
}

TEST(ShaderScript, ReadsParametersSidesAndTextures) {
  const ShaderScripts scripts = parse(R"(
// a comment { with a brace
Textures\Base/Grate.TGA
{
  SurfaceParm trans   // behind the value
  surfaceparm nonsolid
  cull TwoSided
  {
    map $lightmap
    rgbGen identity
  }
  { map textures/base/grate.tga
    blendFunc GL_ONE GL_ZERO }
  qer_editorimage textures/base/Grate_Editor.jpg
}
textures/base/plain { cull back { animMap 0.5 textures/a.tga textures/b.tga } { clampmap textures/c } }
)");
  ASSERT_EQ(scripts.size(), 2u);
  const ShaderScript& grate = scripts.at("textures/base/grate");
  EXPECT_EQ(grate.content_flags, 0x20000000u);
  EXPECT_EQ(grate.surface_flags, 0u);
  EXPECT_TRUE(grate.double_sided);
  EXPECT_EQ(grate.textures, (std::vector<std::string>{"textures/base/grate_editor", "textures/base/grate"}));
  const ShaderScript& plain = scripts.at("textures/base/plain");
  EXPECT_FALSE(plain.double_sided);
  EXPECT_EQ(plain.textures, (std::vector<std::string>{"textures/a", "textures/c"}));
}

TEST(ShaderScript, StagesThatAreNoColourOfTheSurfaceAreNoTextures) {
  const ShaderScript script = parse(
                                  "x {\n{ map chrome\n tcGen environment\n}\n{\n map maps/x/lm_0000.tga\n rgbGen identity\n "
                                  "TCGEN LightMap\n}\n{\n detail\n map grain\n}\n"
                                  "{\n map stone.PNG\n blendFunc filter\n}\n{ map $lightmap\n tcGen lightmap }\n{\n map "
                                  "maps/x/lm_0001.tga\n tcgen lightmap\n}\n}")
                                  .at("x");
  EXPECT_EQ(script.textures, std::vector<std::string>{"stone"});
  EXPECT_EQ(script.light_page, "maps/x/lm_0000");
  EXPECT_EQ(parse("x {\n{ map chrome\n tcGen environment").at("x").textures, std::vector<std::string>{});
  EXPECT_EQ(parse("x {\n{ map stone").at("x").textures, std::vector<std::string>{"stone"}) << "a text that ends too early";
}

TEST(ShaderScript, TheFirstDefinitionHoldsAndBrokenOnesEndSomewhere) {
  EXPECT_TRUE(parse("x { cull none\n} x { cull back\n}").at("x").double_sided);
  EXPECT_TRUE(parse("} } { cull none } y stray x { cull none\n").at("x").double_sided);
  EXPECT_TRUE(parse("").empty());
  EXPECT_TRUE(parse("x").empty());
  EXPECT_EQ(parse("x {{{{{{").size(), 1u);
}

TEST(ShaderScripts, LaterArchivesHideEarlierOnes) {
  TemporaryFolder folder;
  writeZip(folder / "pak1.pk3", {{"scripts/a.shader", "x { cull none\n} only_old { cull none\n}"}});
  writeZip(folder / "pak2.pk3", {{"scripts/z.shader", "x { cull back\n}"}, {"scripts/b.shader", "y { cull none\n}"}});
  const ShaderScripts scripts = readShaderScripts(Pk3Archives(folder.string()));
  EXPECT_FALSE(scripts.at("x").double_sided);
  EXPECT_TRUE(scripts.at("y").double_sided);
  EXPECT_TRUE(scripts.at("only_old").double_sided);
}

// --- colours

glm::vec3 averageColour(const std::string& bytes) {
  SceneBudget pixels = SceneBudgets().pixels;
  return imageMeans(bytes, pixels, "a.pk3", "image").value().linear;
}

// sRGB code 188 is 0.5029 in linear light, 0 is 0, 255 is 1
constexpr float kHalf = 0.5029f;

TEST(TextureColour, AveragesInLinearLight) {
  EXPECT_FLOAT_EQ(averageColour(targa(2, 2, 1, 24, std::string("\0\0\0\xff\xff\xff", 6))).x, 0.5f);
  EXPECT_EQ(averageColour(targa(2, 1, 1, 32, std::string("\xff\0\0\x80", 4))), glm::vec3(0, 0, 1));
  EXPECT_NEAR(averageColour(targa(3, 1, 2, 8, "\xbc\xbc")).y, kHalf, 1e-4);
  // a run of three red pixels, then one pixel of black as it is
  EXPECT_EQ(averageColour(targa(10, 2, 2, 24, std::string("\x82\0\0\xff\0\0\0\0", 8))), glm::vec3(0.75f, 0, 0));
}

}  // namespace
}  // namespace nlg
