#include "light/closure.h"

#include <algorithm>
#include <cmath>

#include "datagen/visibility/ray_scene.h"
#include "light/air.h"
#include "light/baked_light.h"
#include "light/light_transport.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;
constexpr uint64_t kPlaceStream = 0x636c6f73;

double luminance(const glm::vec3& rgb) { return 0.2126 * rgb.r + 0.7152 * rgb.g + 0.0722 * rgb.b; }

enum class Part { surfaces, emission, sky, lamps, suns };

// The scene with one part of its light.
Scene sceneWith(const Scene& scene, Part part) {
  Scene only = scene;
  SceneLight& light = only.light;
  if (part != Part::surfaces) light.baked = {};
  if (part != Part::emission) {
    for (Material& material : only.materials) material.emissive = glm::vec3(0.0f);
    std::fill(light.sky_faces.shine.begin(), light.sky_faces.shine.end(), glm::vec3(0.0f));
  }
  if (part != Part::sky) light.sky = {};
  if (part != Part::lamps) light.lamps.clear();
  if (part != Part::suns) light.suns.clear();
  return only;
}

// Triangles with a lightmap, and their areas' running sum.
struct LitTriangles {
  std::vector<uint32_t> triangles;
  std::vector<double> area_sums;

  explicit LitTriangles(const Scene& scene) {
    const std::vector<int32_t>& pages = scene.light.baked.triangle_page;
    double sum = 0.0;
    for (uint32_t t = 0; t < pages.size(); ++t) {
      if (pages[t] == BakedLight::kByVertex) continue;
      const glm::uvec3& corners = scene.triangles[t];
      const glm::vec3 a = scene.positions[corners.x];
      sum += 0.5 * glm::length(glm::cross(scene.positions[corners.y] - a, scene.positions[corners.z] - a));
      triangles.push_back(t);
      area_sums.push_back(sum);
    }
  }
};

class ClosureMeasurement {
 public:
  ClosureMeasurement(const Scene& scene, const ClosureOptions& options, uint64_t seed)
      : scene_(scene), options_(options), seed_(seed), rays_(scene) {}

  Closure measure() {
    choosePlaces();
    // what shines is looked for from each place: no bounce, so that no light counts twice
    add(Part::surfaces, [](ClosurePlace& place) -> glm::vec3& { return place.surfaces; });
    add(Part::emission, [](ClosurePlace& place) -> glm::vec3& { return place.emission; });
    add(Part::sky, [](ClosurePlace& place) -> glm::vec3& { return place.sky; });
    add(Part::lamps, [](ClosurePlace& place) -> glm::vec3& { return place.lamps; });
    add(Part::suns, [](ClosurePlace& place) -> glm::vec3& { return place.suns; });
    correlate();
    return std::move(result_);
  }

 private:
  void choosePlaces() {
    const LitTriangles lit(scene_);
    if (lit.triangles.empty() || !(lit.area_sums.back() > 0.0)) return;
    for (int i = 0; i < options_.places; ++i) {
      Random random(mixSeed(seed_, kPlaceStream, i));
      const double at = random.uniform() * lit.area_sums.back();
      const size_t found = std::upper_bound(lit.area_sums.begin(), lit.area_sums.end(), at) - lit.area_sums.begin();
      addPlace(lit.triangles[std::min(found, lit.triangles.size() - 1)], random);
    }
  }

  void addPlace(uint32_t triangle, Random& random) {
    float u = static_cast<float>(random.uniform()), v = static_cast<float>(random.uniform());
    if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
    const glm::uvec3& t = scene_.triangles[triangle];
    const glm::vec3 a = scene_.positions[t.x], ab = scene_.positions[t.y] - a, ac = scene_.positions[t.z] - a;
    ClosurePlace place;
    place.normal = glm::normalize(glm::cross(ab, ac));
    place.position = a + ab * u + ac * v + place.normal * static_cast<float>(options_.before_m);
    place.baked = bakedLight(scene_, triangle, u, v);
    if (isInAir(rays_, glm::dvec3(place.position))) {
      result_.places.push_back(place);
    } else {
      ++result_.in_solid;
    }
  }

  template <class Target>
  void add(Part part, const Target& target) {
    const Scene only = sceneWith(scene_, part);
    const LightTransport transport(only, rays_);
    const GatherOptions options{options_.rays, 0};
    for (size_t i = 0; i < result_.places.size(); ++i) {
      ClosurePlace& place = result_.places[i];
      const GatheredIrradiance gathered = transport.gatherIrradiance(glm::dvec3(place.position), place.normal, options,
                                                                     mixSeed(seed_, static_cast<uint64_t>(part), i));
      target(place) = gathered.irradiance / kPi;
    }
  }

  void correlate() {
    double n = 0.0, p = 0.0, b = 0.0, pp = 0.0, pb = 0.0, bb = 0.0;
    for (const ClosurePlace& place : result_.places) {
      const double predicted = luminance(place.predicted(scene_.light.baked.ambient)), baked = luminance(place.baked);
      n += 1.0, p += predicted, b += baked;
      pp += predicted * predicted, pb += predicted * baked, bb += baked * baked;
    }
    if (n < 2.0) return;
    const double spread = std::sqrt(std::max(0.0, (pp - p * p / n) * (bb - b * b / n)));
    result_.correlation = spread > 0.0 ? (pb - p * b / n) / spread : 0.0;
    result_.scale = pp > 0.0 ? pb / pp : 0.0;
  }

  const Scene& scene_;
  const ClosureOptions options_;
  const uint64_t seed_;
  const RayScene rays_;
  Closure result_;
};

}  // namespace

Closure measureClosure(const Scene& scene, const ClosureOptions& options, uint64_t seed) {
  return ClosureMeasurement(scene, options, seed).measure();
}

}  // namespace nlg
