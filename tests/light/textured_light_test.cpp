// Light of scenes with images, vertex colours and transmissive surfaces: against closed forms, and against the same scene with
// factors.
#include <gtest/gtest.h>

#include <cmath>

#include "light/directions.h"
#include "light/emitters.h"
#include "light/light_transport.h"
#include "light/surface_cache.h"
#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

// An image of width x height texels: colour as sRGB codes, and alpha.
template <class TexelOf>
TextureImage imageOf(int width, int height, const TexelOf& texel_of) {
  TextureImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.texels.push_back(texel_of(x, y));
  }
  return image;
}

std::array<uint8_t, 4> grey(int code) {
  const auto channel = static_cast<uint8_t>(code);
  return {channel, channel, channel, 255};
}

// Every face of quads (a, b, c, d as SceneOfFaces has them) gets the whole image.
void spreadImages(Scene* scene) {
  const glm::vec2 corners[6] = {{0, 1}, {1, 1}, {1, 0}, {0, 1}, {1, 0}, {0, 0}};
  for (size_t v = 0; v < scene->positions.size(); ++v) scene->base_places.push_back(corners[v % 6]);
  scene->emissive_places = scene->base_places;
}

struct TexturedLit {
  explicit TexturedLit(const Scene& s) : scene(s), rays(scene), transport(scene, rays) {}
  GatheredIrradiance at(const glm::dvec3& position, const glm::vec3& normal, int ray_count = 4096) const {
    return transport.gatherIrradiance(position, glm::normalize(normal), {ray_count, 64}, 5);
  }
  Scene scene;
  RayScene rays;
  LightTransport transport;
};

// A square of side 2 s at height y that faces up.
Scene plate(float s, float y) {
  SceneOfFaces faces;
  faces.addQuad({-s, y, s}, {s, y, s}, {s, y, -s}, {-s, y, -s});
  return faces.finish();
}

Scene underSky(Scene scene) {
  scene.light.sky = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  return scene;
}

// A black box, open above but for a lid of this material; the sky is 1.
Scene boxUnderLid(const Material& lid) {
  SceneOfFaces faces;
  faces.addBox({-1, 0, -1}, {1, 1, 1}, true);
  Scene scene = faces.finish();
  scene.materials[0].base_color = glm::vec3(0.0f);
  scene.materials.push_back(lid);
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    const glm::uvec3& corners = scene.triangles[t];
    if (std::min({scene.positions[corners.x].y, scene.positions[corners.y].y, scene.positions[corners.z].y}) > 0.9f)
      scene.triangle_material[t] = 2;
  }
  return underSky(std::move(scene));
}

TEST(TexturedLight, AnImageOfOneColourIsItsFactorBitForBit) {
  const uint8_t code = 140;
  Scene factor = room(glm::vec3(linearFromSrgb(code)), glm::vec3(3.0f * linearFromSrgb(code)));
  Scene image = room(glm::vec3(1.0f), glm::vec3(3.0f));
  spreadImages(&image);
  image.images = {imageOf(8, 8, [&](int, int) { return grey(code); })};
  image.materials[0].base_image.image = 0;
  image.vertex_colours.assign(image.positions.size(), glm::vec4(1.0f));
  // emission by a factor: patches of an image draw other points
  image.materials[0].emissive = factor.materials[0].emissive;
  const TexturedLit a(factor), b(image);
  const glm::vec3 one = a.at({0.3, 0.2, 1}, {0, 1, 0}).irradiance, other = b.at({0.3, 0.2, 1}, {0, 1, 0}).irradiance;
  for (int c = 0; c < 3; ++c) EXPECT_EQ(one[c], other[c]);
}

// A furnace whose walls shine in stripes of 0 and 2: as one that shines by their mean, 1.
TEST(TexturedLight, ShiningStripesFillARoomAsTheirMeanDoes) {
  Scene scene = room(glm::vec3(0.5f), glm::vec3(2.0f));
  spreadImages(&scene);
  scene.images = {imageOf(16, 4, [](int x, int) { return grey(x % 2 == 0 ? 255 : 0); })};
  scene.materials[0].emissive_image.image = 0;
  const GatheredIrradiance gathered = TexturedLit(scene).at({0, 0, 0}, {0, 1, 0}, 16384);
  const float expected = kPi * 1.0f / (1.0f - 0.5f);
  EXPECT_NEAR(gathered.irradiance.g, expected, 4.0f * gathered.deviation.g + 0.01f * expected);
}

// One texel of 64 x 64, and of 512 x 512 (a lamp in a large image), shines on a dark plate. Points are drawn there and nearly nowhere
// else: 512 rays tell its light within few per cent, where even points over the plate would meet it once in four thousand.
TEST(TexturedLight, ASmallBrightSpotOfAnImageIsDrawnByItsPower) {
  for (const int texels : {64, 512}) {
    const int column = 5 * texels / 16, row = 10 * texels / 16;
    Scene scene = plate(2.0f, 0.0f);
    scene.materials[0].base_color = glm::vec3(0.0f);
    scene.materials[0].emissive = glm::vec3(1000.0f);
    spreadImages(&scene);
    scene.images = {imageOf(texels, texels, [&](int x, int y) { return grey(x == column && y == row ? 255 : 0); })};
    scene.materials[0].emissive_image.image = 0;
    const GatheredIrradiance gathered = TexturedLit(scene).at({0, 1, 0}, {0, -1, 0}, 512);
    // area of a texel, seen from straight above but for its offset
    const float side = 4.0f / texels, x = -2.0f + (column + 0.5f) * side, z = -2.0f + (row + 0.5f) * side;
    const float squared = 1.0f + x * x + z * z;
    const float expected = 1000.0f * side * side / (squared * squared);
    EXPECT_NEAR(gathered.irradiance.r, expected, 0.1f * expected);
    EXPECT_LT(gathered.deviation.r, 0.1f * expected);
  }
}

TEST(TexturedLight, ChancesOfPatchesSumToOneOverTheEmitters) {
  Scene scene = plate(1.0f, 0.0f);
  scene.materials[0].emissive = glm::vec3(1.0f);
  spreadImages(&scene);
  scene.images = {imageOf(64, 64, [](int x, int y) { return grey(4 * ((x * 7 + y * 13) % 64)); })};
  scene.materials[0].emissive_image.image = 0;
  const Emitters emitters(scene);
  const Emitters::Draws draws(emitters, {0.3f, 1.0f, -0.2f});
  Random random(3);
  // what draw says of its point is what areaDensity says of it, and 1 / density sums to the area
  double area = 0.0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const EmitterPoint point = draws.draw((i + random.uniform()) / kDraws, random);
    ASSERT_NEAR(point.area_density, draws.areaDensity(point.triangle, point.u, point.v), 1e-4f * point.area_density);
    area += 1.0 / point.area_density / kDraws;
  }
  EXPECT_NEAR(area, 4.0, 0.05);
}

// Light under a lid that lets a share through: that share of what comes without a lid, in the lid's colour where it transmits.
TEST(TexturedLight, ATransmissiveSurfaceDimsSkySunLampAndPanelByWhatItLetsThrough) {
  Material open;
  open.transmissive = Transmissive::thin;
  open.double_sided = true;
  open.base_color = glm::vec3(0.0f);
  Material pane = open, glass = open;
  open.opacity = 0.0f;
  pane.opacity = 0.36f;
  glass.base_color = {0.9f, 0.5f, 0.25f};
  glass.transmission = 1.0f;
  const auto lit = [&](const Material& lid, int source) {
    Scene scene = boxUnderLid(lid);
    if (source > 0) scene.light.sky = {};
    if (source == 1) scene.light.suns.emplace_back().irradiance = glm::vec3(5.0f);
    Lamp lamp;
    lamp.position = {0.1f, 3.0f, 0.2f};
    lamp.intensity = glm::vec3(20.0f);
    if (source == 2) scene.light.lamps.push_back(lamp);
    return TexturedLit(scene).at({0, 0.05, 0}, {0, 1, 0}, 16384).irradiance;
  };
  for (int source = 0; source < 3; ++source) {
    const glm::vec3 whole = lit(open, source);
    ASSERT_GT(whole.r, 0.1f);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(lit(pane, source)[c] / whole[c], 0.64f, 0.015f) << source;
      EXPECT_NEAR(lit(glass, source)[c] / whole[c], glass.base_color[c], 0.015f) << source;
    }
  }
}

// A furnace of which a curtain hangs in the middle that scatters half and lets half through: no light is lost, and it is constant.
TEST(TexturedLight, ATransmissiveSurfaceThatLosesNothingLeavesAFurnaceAsItIs) {
  SceneOfFaces faces;
  faces.addRoom({-2, -1, -3}, {2, 1.5f, 3}, 0.2f);
  faces.addQuad({-1.5f, -0.5f, 0}, {1.5f, -0.5f, 0}, {1.5f, 1, 0}, {-1.5f, 1, 0});
  Scene scene = faces.finish();
  scene.materials[0].base_color = glm::vec3(0.5f);
  scene.materials[0].emissive = glm::vec3(1.0f);
  // it reflects 0.8 of what it stops, and shines as much as makes up for the rest: 0.5 * 0.2 of the furnace's radiance
  Material curtain;
  curtain.transmissive = Transmissive::dense;
  curtain.double_sided = true;
  curtain.opacity = 0.5f;
  curtain.base_color = glm::vec3(0.8f);
  curtain.emissive = glm::vec3(0.2f * 2.0f);
  scene.materials.push_back(curtain);
  scene.triangle_material[scene.triangles.size() - 2] = scene.triangle_material[scene.triangles.size() - 1] = 2;
  const TexturedLit lit(scene);
  const std::vector<glm::dvec3> places = {{0, 0, 1}, {0, 0, -1}, {1, 1, 2}, {-1, 0.5, -2}};
  const SurfaceCache cache(lit.transport, places, {}, 1);
  for (const SurfaceCache* used : {static_cast<const SurfaceCache*>(nullptr), &cache}) {
    GatherOptions options{8192, 64};
    options.cache = used;
    const GatheredIrradiance gathered = lit.transport.gatherIrradiance({0.2, 0.1, 0.5}, {0, 0, -1}, options, 7);
    EXPECT_NEAR(gathered.irradiance.g, 2.0f * kPi, 4.0f * gathered.deviation.g + 0.01f * 2.0f * kPi);
  }
}

// A cut-out that covers three quarters of its face lets a quarter of an even sky through.
TEST(TexturedLight, ACutOutLetsItsHolesShareThrough) {
  Material fence;
  fence.transmissive = Transmissive::dense;
  fence.double_sided = true;
  fence.base_color = glm::vec3(0.0f);
  fence.base_image.image = 0;
  Scene scene = boxUnderLid(fence);
  spreadImages(&scene);
  scene.images = {imageOf(64, 64, [](int x, int y) {
    return std::array<uint8_t, 4>{255, 255, 255, static_cast<uint8_t>(x % 8 < 4 && y % 8 < 4 ? 0 : 255)};
  })};
  Material none = fence;
  none.base_image.image = -1;
  none.opacity = 0.0f;
  const float whole = TexturedLit(boxUnderLid(none)).at({0, 0.05, 0}, {0, 1, 0}, 16384).irradiance.g;
  EXPECT_NEAR(TexturedLit(scene).at({0, 0.05, 0}, {0, 1, 0}, 65536).irradiance.g / whole, 0.25f, 0.01f);
}

}  // namespace
}  // namespace nlg
