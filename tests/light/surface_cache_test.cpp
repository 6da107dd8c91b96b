#include "light/surface_cache.h"

#include <gtest/gtest.h>

#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

Scene withLamp(const SceneOfFaces& faces, const glm::vec3& position) {
  Scene scene = faces.finish();
  scene.materials[0].base_color = glm::vec3(0.5f);
  Lamp lamp;
  lamp.position = position;
  lamp.intensity = glm::vec3(10.0f);
  scene.light.lamps.push_back(lamp);
  return scene;
}

// Two rooms of 4 x 3 x 4 m side by side, walls of 10 cm between and around; a lamp in the first one.
Scene twoRooms() {
  SceneOfFaces faces;
  faces.addRoom({-4.05f, 0, -2}, {-0.05f, 3, 2}, 0.1f);
  faces.addRoom({0.05f, 0, -2}, {4.05f, 3, 2}, 0.1f);
  return withLamp(faces, {-2, 2, 0.5f});
}

// One room of 8 m whose floor and walls run on behind a partition that reaches from wall to wall, and from low_m to the ceiling.
Scene dividedRoom(float half_m = 0.05f, float low_m = -0.05f) {
  SceneOfFaces faces;
  faces.addRoom({-4, 0, -2}, {4, 3, 2}, 0.1f);
  faces.addBox({-half_m, low_m, -2.05f}, {half_m, 3.05f, 2.05f});
  return withLamp(faces, {-1, 1.5f, 0});
}

std::vector<glm::dvec3> placesIn(const glm::dvec3& low, const glm::dvec3& high, int count, uint64_t seed) {
  Random random(seed);
  std::vector<glm::dvec3> places;
  for (int i = 0; i < count; ++i)
    places.emplace_back(random.uniform(low.x, high.x), random.uniform(low.y, high.y), random.uniform(low.z, high.z));
  return places;
}

class CachedScene {
 public:
  explicit CachedScene(const Scene& scene, const std::vector<glm::dvec3>& places)
      : scene_(scene), rays_(scene_), transport_(scene_, rays_), cache_(transport_, places, {}, 2) {}

  glm::vec3 irradiance(const glm::dvec3& place, const glm::vec3& normal, bool cached, glm::vec3* deviation = nullptr) const {
    const GatheredIrradiance result = transport_.gatherIrradiance(place, normal, {4096, 64, cached ? &cache_ : nullptr}, 11);
    if (deviation) *deviation = result.deviation;
    return result.irradiance;
  }
  const SurfaceCache& cache() const { return cache_; }
  const LightTransport& transport() const { return transport_; }

 private:
  Scene scene_;
  RayScene rays_;
  LightTransport transport_;
  SurfaceCache cache_;
};

TEST(SurfaceCache, GivesWhatPathsGive) {
  const std::vector<glm::dvec3> places = placesIn({-3.9, 0.1, -1.9}, {-0.2, 2.9, 1.9}, 200, 3);
  const CachedScene scene(twoRooms(), places);
  EXPECT_GT(scene.cache().cellCount(), 500u);
  double error = 0.0, reference = 0.0;
  for (int i = 0; i < 20; ++i) {
    const glm::vec3 normal(0, i % 2 ? 1 : -1, 0);
    glm::vec3 deviation;
    const float traced = scene.irradiance(places[i], normal, false, &deviation).r;
    const float cached = scene.irradiance(places[i], normal, true).r;
    error += (cached - traced) * (cached - traced);
    reference += traced * traced;
    // cells blur what they hold over their quarter of a metre
    EXPECT_NEAR(cached, traced, 0.05f * traced + 4.0f * deviation.r) << "place " << i;
  }
  EXPECT_LT(error, 0.02 * 0.02 * reference);
}

// Half of a lamp's light falls onto a spot of a few centimetres of the ceiling 2 cm above it, wherever that lies in its cell. Of black walls
// nothing else arrives: 2 pi (1 - h / sqrt(h² + R²)) onto the disc of radius R.
TEST(SurfaceCache, HoldsTheSpotOfALampAtTheCeiling) {
  for (const float x : {0.0f, 0.04f, 0.09f}) {
    SceneOfFaces faces;
    faces.addRoom({-2, 0, -2}, {2, 3, 2}, 0.1f);
    Scene scene = withLamp(faces, {x, 2.98f, 0.03f});
    scene.materials[0].base_color = glm::vec3(0.0f);
    const CachedScene cached(scene, placesIn({-1.9, 0.1, -1.9}, {1.9, 2.9, 1.9}, 500, 3));
    constexpr float R = 0.75f, step = 0.05f;
    double flux = 0.0;
    for (float u = -R + step / 2; u < R; u += step) {
      for (float v = -R + step / 2; v < R; v += step) {
        const glm::vec3* held = u * u + v * v < R * R ? cached.cache().irradiance({x + u, 3.0f, 0.03f + v}, {0, -1, 0}) : nullptr;
        if (held != nullptr) flux += step * step * held->r;
      }
    }
    const double whole = 10.0 * 2.0 * 3.14159265 * (1.0 - 0.02 / std::sqrt(0.02 * 0.02 + R * R));
    EXPECT_NEAR(flux, whole, 0.1 * whole) << "lamp at x = " << x;
  }
}

// Where a cell does not reach a path goes on, which takes ten times as long as the ray that found it.
TEST(SurfaceCache, HoldsWhereMostRaysEnd) {
  const std::vector<glm::dvec3> places = placesIn({-3.9, 0.1, -1.9}, {-0.2, 2.9, 1.9}, 1000, 3);
  const CachedScene scene(twoRooms(), places);
  Random random(7);
  int ended = 0, held = 0;
  for (const glm::dvec3& place : placesIn({-3.9, 0.1, -1.9}, {-0.2, 2.9, 1.9}, 2000, 4)) {
    const glm::vec3 from(place), direction = sphereDirection(random.uniform(), random.uniform());
    const LightHit hit = scene.transport().rays().lightHit(from, direction);
    if (hit.kind != LightHit::Kind::surface) continue;
    ++ended;
    held += scene.cache().irradiance(from + direction * hit.distance, hit.normal) != nullptr;
  }
  EXPECT_GT(held, 0.8 * ended) << held << " of " << ended;
}

// The floor runs on under a door with a gap of 2 cm; its light does not.
TEST(SurfaceCache, DoorsWithAGapStopWhatCellsHold) {
  const std::vector<glm::dvec3> places = placesIn({-3.9, 0.1, -1.9}, {3.9, 2.9, 1.9}, 400, 5);
  const CachedScene lit(dividedRoom(0.02f, 0.02f), places);
  double traced = 0.0, cached = 0.0;
  for (const glm::dvec3& place : places) {
    if (place.x < 0.2) continue;
    traced += lit.irradiance(place, {0, -1, 0}, false).r;
    cached += lit.irradiance(place, {0, -1, 0}, true).r;
  }
  // cells blur what shines through the gap
  EXPECT_LT(cached, 1.5 * traced) << traced;
}

TEST(SurfaceCache, DarkRoomStaysDark) {
  for (const Scene& scene : {twoRooms(), dividedRoom()}) {
    const std::vector<glm::dvec3> places = placesIn({-3.9, 0.1, -1.9}, {3.9, 2.9, 1.9}, 400, 5);
    const CachedScene lit(scene, places);
    double sum = 0.0;
    int count = 0;
    for (const glm::dvec3& place : places) {
      if (place.x < 0.2) continue;
      // the first room has about 10; what is beyond the points that a cell knows is traced
      const float leak = lit.irradiance(place, {0, -1, 0}, true).r;
      EXPECT_LT(leak, 2e-3f) << place.x << ' ' << place.y << ' ' << place.z;
      sum += leak;
      ++count;
    }
    EXPECT_LT(sum / count, 2e-4);
  }
}

}  // namespace
}  // namespace nlg
