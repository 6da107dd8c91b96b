#include "scene/quake/bsp_shader.h"

#include <gtest/gtest.h>

#include "hand_built_bsp.h"
#include "scene/quake/bsp_entities.h"
#include "scene/quake/bsp_file.h"
#include "scene/quake/bsp_looks.h"
#include "tests/input_error.h"
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

TEST(QuakeTokens, StopsAtTheEndOfALineWhenAsked) {
  QuakeTokens tokens("one two // three\nfour");
  std::string_view word;
  EXPECT_TRUE(tokens.nextOnLine(&word));
  EXPECT_TRUE(tokens.nextOnLine(&word));
  EXPECT_FALSE(tokens.nextOnLine(&word));
  EXPECT_FALSE(tokens.nextOnLine(&word));
  EXPECT_TRUE(tokens.next(&word));
  EXPECT_EQ(word, "four");
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
  EXPECT_EQ(grate.content_flags, kBspContentsTranslucent);
  EXPECT_EQ(grate.surface_flags, 0u);
  EXPECT_TRUE(grate.double_sided);
  EXPECT_EQ(grate.textures, (std::vector<std::string>{"textures/base/grate_editor", "textures/base/grate"}));
  const ShaderScript& plain = scripts.at("textures/base/plain");
  EXPECT_FALSE(plain.double_sided);
  EXPECT_EQ(plain.textures, (std::vector<std::string>{"textures/a", "textures/c"}));
}

TEST(ShaderScript, EveryParameterThatMattersHasAReason) {
  const std::map<std::string, const char*> reasons = {{"sky", "sky"},         {"nodraw", "nodraw"},    {"fog", "fog"},
                                                      {"water", "liquid"},    {"lava", "liquid"},      {"slime", "liquid"},
                                                      {"playerclip", "clip"}, {"trans", "translucent"}};
  for (const auto& [parm, reason] : reasons) {
    const ShaderScript script = parse("x { surfaceparm " + parm + "\n}").at("x");
    const char* got = dropReason(script.surface_flags, script.content_flags);
    ASSERT_NE(got, nullptr) << parm;
    EXPECT_STREQ(got, reason) << parm;
  }
  for (const char* parm : {"nonsolid", "metalsteps", "nomarks", "detail"}) {
    const ShaderScript script = parse("x { surfaceparm " + std::string(parm) + "\n}").at("x");
    EXPECT_EQ(dropReason(script.surface_flags, script.content_flags), nullptr) << parm;
  }
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

TEST(ShaderScripts, RefusesMoreThanAnyGameHas) {
  TemporaryFolder folder;
  std::string many;
  for (int i = 0; i < 65537; ++i) many += std::to_string(i) + "{}";
  const std::vector<std::pair<std::string, std::string>> hostile = {{"at most 65536 shaders", many},
                                                                    {"at most 4194304 bytes", std::string((4 << 20) + 1, ' ')}};
  for (const auto& [words, script] : hostile) {
    const std::string path = writeZip(folder / "a.pk3", {{"scripts/a.shader", script}});
    expectInputError(words, [&] { readShaderScripts(Pk3Archives(path)); });
  }
}

// --- colours

std::optional<glm::vec3> averageColour(const std::string& bytes) {
  SceneBudget pixels = SceneBudgets().pixels;
  const std::optional<ImageMeans> means = imageMeans(bytes, pixels, "a.pk3", "image");
  return means ? std::optional(means->linear) : std::nullopt;
}

// What reading the image takes of a budget.
uint64_t pixelsOf(const std::string& image) {
  SceneBudget pixels = SceneBudgets().pixels;
  imageMeans(image, pixels, "a.pk3", "image");
  return kMaxImagePixels - pixels.left();
}

// sRGB code 188 is 0.5029 in linear light, 0 is 0, 255 is 1
constexpr float kHalf = 0.5029f;

TEST(TextureColour, AveragesInLinearLight) {
  const auto black_and_white = averageColour(targa(2, 2, 1, 24, std::string("\0\0\0\xff\xff\xff", 6)));
  ASSERT_TRUE(black_and_white.has_value());
  EXPECT_FLOAT_EQ(black_and_white->x, 0.5f);
  const auto blue = averageColour(targa(2, 1, 1, 32, std::string("\xff\0\0\x80", 4)));
  ASSERT_TRUE(blue.has_value());
  EXPECT_EQ(*blue, glm::vec3(0, 0, 1));
  const auto grey = averageColour(targa(3, 1, 2, 8, "\xbc\xbc"));
  ASSERT_TRUE(grey.has_value());
  EXPECT_NEAR(grey->y, kHalf, 1e-4);
  // a run of three red pixels, then one pixel of black as it is
  const auto packed = averageColour(targa(10, 2, 2, 24, std::string("\x82\0\0\xff\0\0\0\0", 8)));
  ASSERT_TRUE(packed.has_value());
  EXPECT_EQ(*packed, glm::vec3(0.75f, 0, 0));
}

TEST(TextureColour, TakesItsPixelsOfTheBudgetOnceForEveryScan) {
  EXPECT_EQ(pixelsOf(targa(2, 2, 1, 24, std::string(6, 'a'))), 2u);
  EXPECT_EQ(pixelsOf(jpeg(100, 10, 20, 30)), 10000u) << "one scan";
  EXPECT_EQ(pixelsOf(jpeg(8, 10, 20, 30)), kLeastScanPixels);
  EXPECT_EQ(pixelsOf(jpegOfScans(100, 16)), 10000u) << "as many as programs write";
  EXPECT_EQ(pixelsOf(jpegOfScans(100, 18)), 30000u);
  EXPECT_EQ(pixelsOf("no image at all, but long enough"), 0u);
}

// The archive of 794 bytes that took 18 s: 2048 x 2048 pixels, 20,000 times.
TEST(TextureColour, RefusesMoreScansThanTheBudgetHolds) {
  constexpr uint64_t kPixels = 2048 * 2048;
  SceneBudget pixels = SceneBudgets().pixels;
  // it is stopped at the first scan too many
  EXPECT_EQ(inputErrorOf([&] { imageMeans(jpegOfScans(2048, 20000), pixels, "a.pk3", "big.jpg"); }),
            "a.pk3: big.jpg: expected at most 8589934592 pixels of textures, times their scans, in one scene, got " +
                std::to_string(kMaxImagePixels + kPixels));
}

}  // namespace
}  // namespace nlg
