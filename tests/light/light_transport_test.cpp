#include "light/light_transport.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "light/directions.h"
#include "light/sunlight.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tool/error.h"

namespace nlg {
namespace {

Scene ground(float albedo, float half_side) {
  SceneOfFaces faces;
  const float s = half_side;
  faces.addQuad({-s, 0, s}, {s, 0, s}, {s, 0, -s}, {-s, 0, -s});
  Scene scene = faces.finish();
  scene.materials[0].base_color = glm::vec3(albedo);
  return scene;
}

// Ground, a roof 5 m above it, and between them a face of sky that looks down.
Scene roofBehindSky() {
  SceneOfFaces faces;
  faces.addQuad({-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10});
  faces.addQuad({-10, 5, -10}, {10, 5, -10}, {10, 5, 10}, {-10, 5, 10});
  Scene scene = faces.finish();
  scene.light.sky_faces.positions = {{-10, 4, -10}, {10, 4, -10}, {10, 4, 10}, {-10, 4, 10}};
  scene.light.sky_faces.triangles = {{0, 1, 2}, {0, 2, 3}};
  return scene;
}

Lamp& addLamp(Scene& scene, const glm::vec3& position, const glm::vec3& intensity) {
  Lamp& lamp = scene.light.lamps.emplace_back();
  lamp.position = position;
  lamp.intensity = intensity;
  return lamp;
}

struct Lit {
  explicit Lit(const Scene& s) : scene(s), rays(scene), transport(scene, rays) {}
  glm::vec3 at(const glm::dvec3& position, const glm::vec3& normal, int ray_count = 4096) const {
    return transport.gatherIrradiance(position, glm::normalize(normal), {ray_count, 64}, 5).irradiance;
  }
  Scene scene;
  RayScene rays;
  LightTransport transport;
};

// Furnace: everything emits e and reflects ρ, so that radiance is e / (1 - ρ) everywhere and irradiance pi times that.
TEST(LightTransport, ClosedFurnaceIsConstant) {
  const glm::vec3 albedo(0.5f, 0.2f, 0.0f), emission(1.0f, 2.0f, 3.0f);
  const Lit lit(room(albedo, emission));
  for (const glm::dvec3& place : {glm::dvec3(0.0), glm::dvec3(1.9, -0.9, 2.5), glm::dvec3(-1.99, 1.4, -2.9)}) {
    for (const glm::vec3& normal : {glm::vec3(0, 1, 0), glm::vec3(1, 1, 1)}) {
      const GatheredIrradiance gathered = lit.transport.gatherIrradiance(place, glm::normalize(normal), {4096, 64}, 3);
      for (int c = 0; c < 3; ++c) {
        const float expected = kPi * emission[c] / (1.0f - albedo[c]);
        EXPECT_NEAR(gathered.irradiance[c], expected, 4.0f * gathered.deviation[c] + 0.002f * expected);
        EXPECT_LT(gathered.deviation[c], 0.02f * expected);
      }
      GatherOptions reflected{4096, 64};
      reflected.direct = DirectLight::reflected;
      const GatheredIrradiance sent_back = lit.transport.gatherIrradiance(place, glm::normalize(normal), reflected, 3);
      for (int c = 0; c < 3; ++c) {
        const float expected = kPi * emission[c] * albedo[c] / (1.0f - albedo[c]);
        EXPECT_NEAR(sent_back.irradiance[c], expected, 4.0f * sent_back.deviation[c] + 0.002f * expected);
      }
    }
    float mean = 0.0f;  // one gather has a standard deviation of .07
    for (uint64_t seed = 0; seed < 8; ++seed)
      mean += irradiance(lit.transport.gather(place, {4096, 64}, seed).light, {0, 0, 1}).r / 8.0f;
    EXPECT_NEAR(mean, kPi * 2.0f, 0.1f);
  }
}

// A sun and a lamp above white ground: left out, they still shine on the ground and it sends their light up.
TEST(LightTransport, LeavesDirectLightOutWhereAsked) {
  Scene scene = ground(0.5f, 1000.0f);
  scene.light.suns.emplace_back().irradiance = glm::vec3(2.0f);
  addLamp(scene, {0, 10, 0}, glm::vec3(300.0f)).radius_m = 0.05f;
  const Lit lit(scene);
  const auto from = [&](const glm::vec3& normal, DirectLight direct) {
    GatherOptions options{4096, 64};
    options.direct = direct;
    return lit.transport.gatherIrradiance({0, 1, 0}, normal, options, 5).irradiance.g;
  };
  const glm::vec3 up(0, 1, 0), down(0, -1, 0);
  const float of_lamp = 300.0f / (9.0f * 9.0f);
  EXPECT_NEAR(from(up, DirectLight::all), 2.0f + of_lamp, 0.01f * (2.0f + of_lamp));
  EXPECT_NEAR(from(up, DirectLight::no_suns), of_lamp, 0.01f * of_lamp);
  EXPECT_EQ(from(up, DirectLight::none), 0.0f);
  // the ground's own light from below: the sun's alone is half of 2, the lamp's comes on top
  const float below = from(down, DirectLight::all);
  EXPECT_GT(below, 1.0f);
  EXPECT_EQ(from(down, DirectLight::none), below);
  EXPECT_EQ(from(down, DirectLight::reflected), below);
  EXPECT_EQ(from(up, DirectLight::reflected), 0.0f);
  EXPECT_THROW(directLightFromName("some"), UsageError);
}

TEST(LightTransport, UniformSkyLightsAPlaneAndItsUnderside) {
  Scene scene = ground(0.5f, 1e4f);
  scene.light.sky = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  const Lit lit(scene);
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, 1, 0}).r, kPi, 1e-3f * kPi);
  // the plane sends back half of pi, as radiance 1/2
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, -1, 0}).r, 0.5f * kPi, 2e-3f * kPi);
  EXPECT_NEAR(lit.at({0, 1, 0}, {1, 0, 0}).r, 0.75f * kPi, 4e-3f * kPi);
  // harmonics of order 2 are exact for the cosine of a half-space's edge to within their own order: 1 %
  const GatheredLight gathered = lit.transport.gather({0, 1, 0}, {4096, 64}, 9);
  EXPECT_NEAR(irradiance(gathered.light, {0, 1, 0}).r, kPi, 0.02f * kPi);
}

TEST(LightTransport, SmallLampFallsOffWithTheSquare) {
  Scene scene = ground(0.0f, 10.0f);
  addLamp(scene, {0, 3, 0}, {4.0f, 8.0f, 0.0f}).radius_m = 0.05f;
  const Lit lit(scene);
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, 1, 0}).r, 4.0f / 4.0f, 2e-3f);
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, 1, 0}).g, 8.0f / 4.0f, 4e-3f);
  EXPECT_NEAR(lit.at({4, 0.01, 0}, {0, 1, 0}).r, 4.0f * (2.99f / std::sqrt(24.94f)) / 24.94f, 1e-3f);
  EXPECT_EQ(lit.at({0, 1, 0}, {0, -1, 0}).r, 0.0f);
  // behind a wall it is not seen
  EXPECT_EQ(lit.at({0, -1, 0}, {0, 1, 0}).r, 0.0f);
}

TEST(LightTransport, SpotEndsAtItsOuterCone) {
  Scene scene = ground(0.0f, 10.0f);
  Lamp& lamp = addLamp(scene, {0, 2, 0}, glm::vec3(1.0f));
  lamp.cos_inner = std::cos(0.3f);
  lamp.cos_outer = std::cos(0.5f);
  const Lit lit(scene);
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, 1, 0}).r, 1.0f, 2e-2f);
  EXPECT_EQ(lit.at({0.9, 1, 0}, {0, 1, 0}).r, 0.0f);
}

TEST(LightTransport, SunIsItsIrradiance) {
  Scene scene = ground(0.5f, 1e3f);
  scene.light.suns.push_back({glm::normalize(glm::vec3(0, 1, 1)), glm::vec3(2.0f), 0.00465f});
  const Lit lit(scene);
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, 1, 0}).r, std::sqrt(2.0f), 2e-3f);
  EXPECT_NEAR(lit.at({0, 1, 0}, {0, -1, 0}).r, 0.5f * std::sqrt(2.0f), 4e-3f);
}

// A square of side 1 that shines downward, 4 m above: the form factor of a small far square, to its own second order.
TEST(LightTransport, ShiningSquareIsFoundBySampling) {
  SceneOfFaces faces;
  faces.addQuad({-0.5f, 4, -0.5f}, {0.5f, 4, -0.5f}, {0.5f, 4, 0.5f}, {-0.5f, 4, 0.5f});
  Scene scene = faces.finish();
  scene.materials[0].base_color = glm::vec3(0.0f);
  scene.materials[0].emissive = glm::vec3(10.0f);
  const Lit lit(scene);
  // exact form factor of a centred parallel rectangle: 4 corners of half sides 1/2 at distance 4
  const double a = 0.125, corner = a / std::sqrt(1 + a * a) * std::atan(a / std::sqrt(1 + a * a)) * 2.0 / (2.0 * M_PI);
  EXPECT_NEAR(lit.at({0, 0, 0}, {0, 1, 0}).r, 10.0f * kPi * static_cast<float>(4.0 * corner), 0.01f * 10.0f * kPi * 0.0195f);
  EXPECT_EQ(lit.at({0, 5, 0}, {0, -1, 0}).r, 0.0f);  // its back is dark
}

TEST(LightTransport, BakedLightIsWhatOneRayMeets) {
  Scene scene = room(glm::vec3(0.5f), glm::vec3(0.25f));
  scene.light.baked.triangle_page.assign(scene.triangles.size(), BakedLight::kByVertex);
  scene.light.baked.vertex_place.resize(scene.positions.size());
  scene.light.baked.vertex_light.assign(scene.positions.size(), glm::vec3(3.0f, 2.0f, 1.0f));
  const Lit lit(scene);
  const glm::vec3 result = lit.at({0, 0, 0}, {0, 1, 0});
  // the share that shines by itself is sampled in two ways: a little noise
  EXPECT_NEAR(result.r, kPi * (1.5f + 0.25f), 0.01f * kPi * 0.25f);
  EXPECT_NEAR(result.b, kPi * (0.5f + 0.25f), 0.01f * kPi * 0.25f);
}

TEST(LightTransport, BakedPagesAreReadBetweenTexelCentres) {
  Scene scene = ground(1.0f, 1.0f);
  BakedLight& baked = scene.light.baked;
  baked.page_side = 2;
  baked.texels = {glm::vec3(0.0f), glm::vec3(1.0f), glm::vec3(2.0f), glm::vec3(3.0f)};
  baked.triangle_page.assign(scene.triangles.size(), 0);
  for (const glm::vec3& p : scene.positions) baked.vertex_place.emplace_back(0.5f + 0.5f * p.x, 0.5f + 0.5f * p.z);
  baked.vertex_light.resize(scene.positions.size());
  const Lit lit(scene);
  const auto below = [&](float x, float z) { return lit.transport.radianceAlong({x, 1, z}, {0, -1, 0}, 8, 1).r; };
  // base colour 1 sends back nine tenths
  EXPECT_NEAR(below(-0.5f, -0.5f), 0.0f, 1e-4f);
  EXPECT_NEAR(below(0.5f, -0.5f), 0.9f, 1e-4f);
  EXPECT_NEAR(below(0.0f, 0.0f), 0.9f * 1.5f, 1e-4f);
  EXPECT_NEAR(below(0.9f, 0.9f), 0.9f * 3.0f, 1e-4f);
}

TEST(LightTransport, SkyFacesShineInFrontAndLetThroughFromBehind) {
  Scene roofed = roofBehindSky();
  roofed.light.sky = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  const RayScene rays(roofed);
  EXPECT_EQ(rays.lightHit({0, 1, 0}, {0, 1, 0}).kind, LightHit::Kind::sky);
  const LightHit from_behind = rays.lightHit({0, 4.5f, 0}, {0, -1, 0});
  EXPECT_EQ(from_behind.kind, LightHit::Kind::surface);
  EXPECT_NEAR(from_behind.distance, 4.5f, 1e-5f);
  EXPECT_FALSE(rays.isBlocked({0, 1, 0}, {0, 4.5f, 0}));  // no geometry for anybody else
}

// A sun straight above: the level's own roof ends in a face of sky, or in one of lava.
TEST(Sunlight, FallsThroughFacesOfSkyAndNotThroughThoseThatShineThemselves) {
  Scene scene = roofBehindSky();
  scene.light.suns.emplace_back().to_sun = {0, 1, 0};
  const RayScene rays(scene);
  EXPECT_TRUE(isInSunlight(scene, rays, {0, 1, 0}, {0, 1, 0}));
  EXPECT_FALSE(isInSunlight(scene, rays, {0, 1, 0}, {0, -1, 0})) << "the sun stands behind its plane";
  EXPECT_FALSE(isInSunlight(scene, rays, {0, 4.5, 0}, {0, 1, 0})) << "a roof stands above";
  scene.light.sky_faces.shine = {glm::vec3(1.0f), glm::vec3(1.0f)};
  EXPECT_FALSE(isInSunlight(scene, rays, {0, 1, 0}, {0, 1, 0}));
}

// Nothing but a speck far below: all of the sky is seen.
Scene openAir() {
  SceneOfFaces faces;
  faces.addQuad({-0.01f, -50, 0.01f}, {0.01f, -50, 0.01f}, {0.01f, -50, -0.01f}, {-0.01f, -50, -0.01f});
  return faces.finish();
}

SkyImage skyImage(const std::function<glm::vec3(const glm::vec3& direction)>& radiance) {
  SkyImage image{256, 128, {}};
  for (int row = 0; row < 128; ++row) {
    for (int column = 0; column < 256; ++column)
      image.texels.push_back(radiance(skyDirection((column + 0.5) / 256, (row + 0.5) / 128)));
  }
  return image;
}

TEST(LightTransport, AnImageOfOneColourIsTheSkyOfThatColour) {
  // under a sky's face with a roof behind it, over ground that sends light on: each way by which a sky is met
  for (Scene scene : {ground(0.5f, 1e4f), roofBehindSky()}) {
    const glm::vec3 colour(1.0f, 2.0f, 0.5f);
    scene.light.sky = {colour, colour, colour};
    const Lit plain(scene);
    scene.light.sky = skyOfImage(skyImage([&](const glm::vec3&) { return colour; }));
    const Lit image(scene);
    for (const glm::vec3& normal : {glm::vec3(0, 1, 0), glm::vec3(1, 0, 0), glm::vec3(0, -1, 0)}) {
      const glm::vec3 expected = plain.at({0, 1, 0}, normal, 8192), got = image.at({0, 1, 0}, normal, 8192);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], expected[c], 0.01f * expected[c]) << normal.x << " " << normal.y;
    }
  }
}

TEST(LightTransport, HalfABrightDomeGivesHalfOfPi) {
  Scene scene = openAir();
  scene.light.sky = skyOfImage(skyImage([](const glm::vec3& d) { return glm::vec3(d.z > 0.0f ? 2.0f : 0.0f); }));
  const Lit lit(scene);
  EXPECT_NEAR(lit.at({0, 0, 0}, {0, 1, 0}).r, kPi, 0.005f * kPi);
  EXPECT_NEAR(lit.at({0, 0, 0}, {0, 0, 1}).r, 2.0f * kPi, 0.005f * kPi);
  EXPECT_NEAR(lit.at({0, 0, 0}, {0, 0, -1}).r, 0.0f, 1e-6f);
  EXPECT_NEAR(lit.at({0, 0, 0}, {1, 0, 0}).r, kPi, 0.005f * kPi);
}

TEST(LightTransport, IrradianceUnderASkysImageIsItsIntegral) {
  Scene scene = openAir();
  scene.light.sky = skyOfImage(skyImage([](const glm::vec3& d) {
    const float bump = glm::dot(d, glm::normalize(glm::vec3(1, 2, -1))) > 0.98f ? 200.0f : 0.0f;
    return glm::vec3(1.0f + bump, 1.0f + d.x, 1.0f + 0.5f * bump + d.y);
  }));
  const SkyImage& image = scene.light.sky.image;
  const Lit lit(scene);
  for (const glm::vec3& normal :
       {glm::vec3(0, 1, 0), glm::normalize(glm::vec3(1, 1, 0)), glm::normalize(glm::vec3(-1, 0.2f, 1))}) {
    glm::dvec3 sum(0.0);
    // nine places a texel; the cosine's edge costs less than a thousandth of the whole
    for (int row = 0; row < 3 * image.height; ++row) {
      for (int column = 0; column < 3 * image.width; ++column) {
        const glm::vec3 direction = skyDirection((column + 0.5) / (3.0 * image.width), (row + 0.5) / (3.0 * image.height));
        sum += glm::dvec3(image.texels[static_cast<size_t>(row / 3) * image.width + column / 3]) *
               (image.solidAngle(row / 3) / 9.0 * std::max(0.0f, glm::dot(direction, normal)));
      }
    }
    const GatheredIrradiance got = lit.transport.gatherIrradiance({0, 0, 0}, normal, {4096, 64}, 7);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(got.irradiance[c], sum[c], 4.0 * got.deviation[c] + 0.002 * sum[c]) << normal.x << " " << normal.y;
      EXPECT_LT(got.deviation[c], 0.01 * sum[c]);
    }
  }
}

// One texel of 32,768 holds nearly all light: directions at random meet it with 64 rays once in 500 places.
TEST(LightTransport, ASpotOfASkysImageIsFoundBySamplingAtPlacesAndAtBounces) {
  Scene scene = ground(0.5f, 1e4f);
  const size_t texel = 40 * 256 + 100;
  SkyImage image = skyImage([](const glm::vec3&) { return glm::vec3(0.01f); });
  image.texels[texel] = glm::vec3(2000.0f);
  const glm::vec3 to_spot = skyDirection(100.5 / 256, 40.5 / 128);
  const auto of_spot = static_cast<float>(2000.0 * image.solidAngle(40) * to_spot.y);
  scene.light.sky = skyOfImage(image);
  const Lit lit(scene);
  const float expected = of_spot + 0.01f * kPi;
  for (const uint64_t seed : {1, 2, 3}) {
    const GatheredIrradiance above = lit.transport.gatherIrradiance({0, 1, 0}, {0, 1, 0}, {64, 64}, seed);
    EXPECT_NEAR(above.irradiance.r, expected, 0.02f * expected) << seed;
    EXPECT_LT(above.deviation.r, 0.02f * expected);
    const GatheredIrradiance below = lit.transport.gatherIrradiance({0, 1, 0}, {0, -1, 0}, {64, 64}, seed);
    EXPECT_NEAR(below.irradiance.r, 0.5f * expected, 4.0f * below.deviation.r) << seed;
    EXPECT_LT(below.deviation.r, 0.03f * expected);
  }
}

TEST(LightTransport, SaysItsOwnNoise) {
  Scene scene = room(glm::vec3(0.6f), glm::vec3(0.0f));
  addLamp(scene, {0, 0.3f, 0}, glm::vec3(5.0f));
  const Lit lit(scene);
  const int runs = 64;
  double sum = 0.0, squares = 0.0, said = 0.0;
  for (int run = 0; run < runs; ++run) {
    const GatheredIrradiance gathered = lit.transport.gatherIrradiance({-1, 0, -1}, {0, 1, 0}, {256, 64}, 100 + run);
    sum += gathered.irradiance.r;
    squares += double(gathered.irradiance.r) * gathered.irradiance.r;
    said += gathered.deviation.r;
  }
  const double deviation = std::sqrt((squares - sum * sum / runs) / (runs - 1));
  // 64 runs know a deviation to a tenth; parts of a lattice are less even than the whole, so that it says rather too much
  EXPECT_GT(said / runs, 0.75 * deviation);
  EXPECT_LT(said / runs, 3.0 * deviation);
  EXPECT_LT(deviation, 0.1 * sum / runs);
}

// A point h before a plane sends 2 pi (1 - h / sqrt(h² + R²)) times its intensity onto the disc of radius R around its foot. Of the default
// sphere of 10 cm most would lie behind the plane.
TEST(LightTransport, LampsCloseToASurfaceLightAllOfIt) {
  constexpr double h = 0.02, R = 0.5, step = 0.005;
  Scene scene = ground(0.0f, 3.0f);
  addLamp(scene, {0.0f, static_cast<float>(h), 0.0f}, glm::vec3(1.0f));
  const Lit lit(scene);
  double flux = 0.0;
  for (double x = 0.5 * step; x < R; x += step) {
    for (double z = 0.5 * step; z < R; z += step) {
      if (x * x + z * z < R * R) flux += 4.0 * step * step * lit.at({x, 1e-4, z}, {0, 1, 0}, 8).r;
    }
  }
  EXPECT_NEAR(flux, 2.0 * kPi * (1.0 - h / std::sqrt(h * h + R * R)), 0.03 * 2.0 * kPi);
}

}  // namespace
}  // namespace nlg
