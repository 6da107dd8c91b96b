#include "light/light_transport.h"

#include <algorithm>
#include <cmath>

#include "light/direction_guide.h"
#include "light/directions.h"
#include "light/emitters.h"
#include "light/sunlight.h"
#include "light/surface_cache.h"
#include "runtime_eval/numbers/random.h"
#include "scene/model/scene_light.h"
#include "scene/model/surface_look.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kLeastLampRadiusM = 0.002f;  // of one that touches a surface
constexpr int kSetCount = 8;                 // of directions, whose means say how sure the whole is
constexpr int kSurePathVertices = 3;         // no roulette before
constexpr float kSurvival = 0.95f;           // at most
// Samples of one light at a place. They differ only in its penumbra: elsewhere one would do.
constexpr int kRaysPerSample = 4, kMostOfSun = 32, kMostOfLamp = 64;
// In bakes, where many places are averaged, a lamp has one sample at least for so many rays, and a small sun one for so many.
constexpr int kRaysPerFewest = 64, kRaysPerSmallSun = 16;
constexpr float kSmallSun = 0.02f;  // radius, radians: no probe resolves its penumbra
constexpr uint64_t kPathStream = 0x70617468, kEmitterStream = 0x656d6974, kLampStream = 0x6c616d70, kSunStream = 0x73756e,
                   kSkyStream = 0x736b79;

// What of a spot's intensity goes this way.
float spotShare(const Lamp& lamp, const glm::vec3& from_lamp) {
  if (lamp.cos_outer <= -1.0f) return 1.0f;
  const float cosine = glm::dot(lamp.direction, from_lamp);
  const float share = (cosine - lamp.cos_outer) / std::max(1e-4f, lamp.cos_inner - lamp.cos_outer);
  const float clamped = std::clamp(share, 0.0f, 1.0f);
  return clamped * clamped;
}

using Arriving = ArrivingLight;

// Where the rays of a place go: ray i of count, with its density per steradian; the density of any direction; and what its last ray met.
struct DrawnDirection {
  glm::vec3 direction;
  float density;
};

struct EvenDirections {
  static constexpr bool kIsGuided = false;
  Lattice lattice;

  DrawnDirection draw(int i, int count) {
    const auto [u, v] = lattice.point(i, count);
    return {sphereDirection(u, v), density({})};
  }
  float density(const glm::vec3&) const { return 0.25f / kPi; }
  void met(float) {}
};

struct GuidedDirections {
  static constexpr bool kIsGuided = true;
  Lattice lattice;
  DirectionGuide& guide;
  size_t bin = 0;

  DrawnDirection draw(int i, int count) {
    const auto [u, v] = lattice.point(i, count);
    const DirectionGuide::Drawn drawn = guide.draw(u, v);
    bin = drawn.bin;
    return {drawn.direction, drawn.density};
  }
  float density(const glm::vec3& direction) const { return guide.density(direction); }
  void met(float radiance) { guide.learn(bin, radiance); }
};

struct CosineDirections {
  static constexpr bool kIsGuided = false;
  Lattice lattice;
  const glm::vec3& normal;

  DrawnDirection draw(int i, int count) {
    const auto [u, v] = lattice.point(i, count);
    const glm::vec3 direction = cosineDirection(normal, u, v);
    return {direction, density(direction)};
  }
  float density(const glm::vec3& direction) const { return std::max(1e-6f, glm::dot(direction, normal) / kPi); }
  void met(float) {}
};

}  // namespace

struct LightTransport::Impl {
  const Scene& scene;
  const RayScene& rays;
  std::vector<Lamp> lamps;               // the scene's, none so large that a surface cuts through it
  std::vector<glm::vec3> factor_albedo;  // by material: all there is of one without images
  Emitters emitters;
  SkySampler sky;         // of a sky that is an image; empty otherwise
  float nudge_m = 1e-4f;  // off a surface, so that the next ray does not meet it again
  size_t group_count;

  Impl(const Scene& s, const RayScene& r)
      : scene(s), rays(r), emitters(s), sky(s.light.sky.image), group_count(s.light.groups.count()) {
    // of a sphere that is half behind a ceiling that half's light would be lost, and what comes close to it would be too dark
    for (Lamp lamp : scene.light.lamps) {
      const float clearance = lamp.radius_m > 0.0f ? rays.clearance(lamp.position, 2.0f * lamp.radius_m) : 0.0f;
      lamp.radius_m = std::clamp(0.5f * clearance, std::min(lamp.radius_m, kLeastLampRadiusM), lamp.radius_m);
      lamps.push_back(lamp);
    }
    for (const Material& material : scene.materials) factor_albedo.push_back(albedoOf(material, material.base_color));
    // larger than the rounding of positions at the scene's furthest vertex
    float furthest = 0.0f;
    for (const glm::vec3& p : scene.positions) furthest = std::max({furthest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    nudge_m = std::max(2e-5f, furthest * 0x1p-20f);
  }

  bool isBaked() const { return !scene.light.baked.empty(); }

  glm::vec3 corner(uint32_t t, int k) const { return scene.positions[scene.triangles[t][k]]; }
  glm::vec3 crossOf(uint32_t t) const { return glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)); }

  glm::vec3 albedo(const LightHit& hit) const {
    const uint32_t idx = scene.triangle_material[hit.triangle];
    const Material& material = scene.materials[idx];
    if (material.transmissive != Transmissive::none)
      return albedoOf(material, transmissiveAt(scene, hit.triangle, hit.u, hit.v).reflects);
    if (!material.base_image.isThere() && scene.vertex_colours.empty()) return factor_albedo[idx];
    return albedoOf(material, baseColourAt(scene, hit.triangle, hit.u, hit.v));
  }

  glm::vec3 emission(const LightHit& hit) const {
    const bool shines = hit.is_front || materialOf(scene, hit.triangle).double_sided;
    return shines ? emissionAt(scene, hit.triangle, hit.u, hit.v) : glm::vec3(0.0f);
  }

  // What transmissive surfaces let through of light that goes so far.
  glm::vec3 passing(const glm::vec3& from, const glm::vec3& direction, float reach) const {
    glm::vec3 share(1.0f);
    for (float near = 0.0f; rays.hasTransmissive();) {
      const LightHit pane = rays.transmissiveHit(from, direction, near, reach);
      if (pane.kind == LightHit::Kind::nothing) break;
      share *= transmissiveAt(scene, pane.triangle, pane.u, pane.v).passes;
      near = RayScene::justBehind(pane);
    }
    return share;
  }

  const LightGroups& groups() const { return scene.light.groups; }
  uint8_t groupOfTriangle(uint32_t triangle) const {
    return LightGroups::of(groups().of_material, scene.triangle_material[triangle]);
  }

  glm::vec3 sumOf(const GroupedLight& light) const {
    glm::vec3 sum = light[0];
    for (size_t g = 1; g < group_count; ++g) sum += light[g];
    return sum;
  }

  // Flux of one emitter point that the place draws; by multiple importance sampling with directions of this density (per
  // steradian). u   in [0, 1): which emitters it comes from; group   of lights, of that emitter
  template <class Density>
  bool emitterLight(const Emitters::Draws& draws, double u, const glm::vec3& from, Random& random, const Density& density,
                    Arriving* arriving, uint8_t* group) const {
    if (emitters.empty()) return false;
    const EmitterPoint point = draws.draw(u, random);
    const glm::vec3 way = point.position - from;
    const float distance = glm::length(way);
    if (!(distance > 2.0f * nudge_m)) return false;
    arriving->direction = way / distance;
    float cosine = -glm::dot(glm::normalize(crossOf(point.triangle)), arriving->direction);
    if (materialOf(scene, point.triangle).double_sided) cosine = std::fabs(cosine);
    if (!(cosine > 0.0f) || rays.isOpaqueBetween(from, from + way * (1.0f - 2.0f * nudge_m / distance))) return false;
    // from a density by area to one by solid angle
    const float solid_density = point.area_density * distance * distance / cosine;
    arriving->flux = emissionAt(scene, point.triangle, point.u, point.v) / (solid_density + density(arriving->direction));
    arriving->flux *= passing(from, arriving->direction, distance - 2.0f * nudge_m);
    *group = groupOfTriangle(point.triangle);
    return true;
  }

  // Flux of a point of a lamp, and of a sun. places   two numbers in [0, 1)
  bool lampLight(const Lamp& lamp, const glm::vec3& from, double place_u, double place_v, Arriving* arriving) const {
    const glm::vec3 way = lamp.position - from;
    const float to_centre = glm::length(way);
    const float distance = std::max(to_centre, 1.001f * lamp.radius_m);
    const glm::vec3 axis = to_centre > 0.0f ? way / to_centre : glm::vec3(0.0f, 1.0f, 0.0f);
    const float sine = lamp.radius_m / distance;
    // 1 - cosine, without losing small lamps to rounding
    const float cap = sine * sine / (1.0f + std::sqrt(1.0f - sine * sine));
    arriving->direction = coneDirection(axis, cap, place_u, place_v);
    const float solid_angle = 2.0f * kPi * cap;
    arriving->flux = lamp.intensity * (spotShare(lamp, -axis) * solid_angle / (kPi * lamp.radius_m * lamp.radius_m));
    if (luminance(arriving->flux) <= 0.0f) return false;
    // up to the sphere's front
    const float reach = std::max(0.0f, to_centre - lamp.radius_m);
    if (rays.isOpaqueBetween(from, from + arriving->direction * reach)) return false;
    arriving->flux *= passing(from, arriving->direction, reach);
    return true;
  }

  bool sunLight(const Sun& sun, const glm::vec3& from, double place_u, double place_v, Arriving* arriving) const {
    const float sine = std::sin(sun.angular_radius);
    const float cap = sine * sine / (1.0f + std::sqrt(1.0f - sine * sine));
    arriving->direction = coneDirection(sun.to_sun, cap, place_u, place_v);
    arriving->flux = sun.irradiance;
    return comesFromSky(from, arriving);
  }

  // Whether nothing but transmissive surfaces stands between a place and the sky: flux loses what these stop.
  bool comesFromSky(const glm::vec3& from, Arriving* arriving) const {
    const bool is_open = comesFromOpenSky(scene, rays, from, arriving->direction);
    if (is_open) arriving->flux *= passing(from, arriving->direction, INFINITY);
    return is_open;
  }

  // Flux of a direction that the sky's image draws; by multiple importance sampling as emitterLight. places   in [0, 1)
  template <class Density>
  bool skyLight(const glm::vec3& from, double place_u, double place_v, const Density& density, Arriving* arriving) const {
    const SkySampler::Drawn drawn = sky.draw(place_u, place_v);
    arriving->direction = drawn.direction;
    arriving->flux = drawn.radiance / (sky.density(drawn.radiance) + density(drawn.direction));
    return comesFromSky(from, arriving);
  }

  // What of the sky's radiance a ray of this density counts for: the rest is skyLight's.
  float skyShare(const glm::vec3& radiance, float density) const {
    return density > 0.0f && !sky.empty() ? density / (density + sky.density(radiance)) : 1.0f;
  }

  // Adds what a surface there sends back of lamps and suns that shine on it, times a factor: one lamp, drawn by what it would give
  // without shadows.
  void addReflectedDirect(const glm::vec3& from, const glm::vec3& normal, const glm::vec3& factor, Random& random,
                          GroupedLight* light) const {
    Arriving arriving;
    const auto addArriving = [&](uint8_t group, float weight) { (*light)[group] += factor * (arriving.flux * (weight / kPi)); };
    const auto cosine = [&] { return std::max(0.0f, glm::dot(arriving.direction, normal)); };
    for (size_t s = 0; s < scene.light.suns.size(); ++s) {
      if (sunLight(scene.light.suns[s], from, random.uniform(), random.uniform(), &arriving))
        addArriving(LightGroups::of(groups().of_sun, s), cosine());
    }
    float total = 0.0f;
    for (const Lamp& lamp : lamps) total += openLight(lamp, from);
    if (total > 0.0f) {
      float at = static_cast<float>(random.uniform()) * total;
      const Lamp* chosen = nullptr;
      float share = 0.0f;
      for (const Lamp& lamp : lamps) {
        const float open = openLight(lamp, from);
        if (open <= 0.0f) continue;
        chosen = &lamp;
        share = open / total;
        if ((at -= open) < 0.0f) break;
      }
      if (chosen != nullptr && lampLight(*chosen, from, random.uniform(), random.uniform(), &arriving))
        addArriving(LightGroups::of(groups().of_lamp, static_cast<size_t>(chosen - lamps.data())), cosine() / share);
    }
    // the density of the path's next direction: emitters and sky are weighed against it
    const auto density = [&](const glm::vec3& direction) { return std::max(0.0f, glm::dot(direction, normal)) / kPi; };
    uint8_t group = 0;
    if (emitterLight({emitters, from}, random.uniform(), from, random, density, &arriving, &group)) addArriving(group, cosine());
    if (!sky.empty() && skyLight(from, random.uniform(), random.uniform(), density, &arriving))
      addArriving(groups().of_sky, cosine());
  }

  // A lamp's irradiance if nothing stood between.
  static float openLight(const Lamp& lamp, const glm::vec3& from) {
    const glm::vec3 way = from - lamp.position;
    const float squared = std::max(glm::dot(way, way), lamp.radius_m * lamp.radius_m);
    return luminance(lamp.intensity) * spotShare(lamp, way / std::sqrt(squared)) / squared;
  }

  // A path's way through the transmissive surfaces before what it meets: it goes on through each, or back from it, by chance, as
  // much as goes either way. throughput loses what does not go the way that it took.
  // hit   what the ray meets behind all transmissive surfaces; where one of them ends it, that one
  // returns   whether a transmissive surface ended it; then reflectance is of light that it scatters back
  template <class AddShine>
  bool endsAtTransmissive(const glm::vec3& origin, const glm::vec3& direction, Random& random, const AddShine& addShine,
                          LightHit* hit, glm::vec3* throughput, glm::vec3* reflectance) const {
    const float reach = hit->kind == LightHit::Kind::nothing ? INFINITY : hit->distance;
    for (float near = 0.0f;;) {
      const LightHit pane = rays.transmissiveHit(origin, direction, near, reach);
      if (pane.kind == LightHit::Kind::nothing) return false;
      addShine(pane);
      const TransmissiveLook look = transmissiveAt(scene, pane.triangle, pane.u, pane.v);
      const glm::vec3 reflects = albedoOf(materialOf(scene, pane.triangle), look.reflects);
      const float back = luminance(reflects), all = back + luminance(look.passes);
      if (static_cast<float>(random.uniform()) * all < back || !(all > 0.0f)) {
        *throughput *= all > 0.0f ? all / back : 0.0f;
        *reflectance = reflects;
        *hit = pane;
        return true;
      }
      *throughput *= look.passes * (all / (all - back));
      near = RayScene::justBehind(pane);
    }
  }

  // Adds the radiance that comes along a ray, but for lamps and suns as seen from its origin.
  // density   of the ray's own direction, per steradian: emitters at its end were sampled too. 0: they were not
  void addRadiance(glm::vec3 origin, glm::vec3 direction, const GatherOptions& options, float density, Random& random,
                   GroupedLight* light, SurfacePoint* hits = nullptr) const {
    glm::vec3 throughput(1.0f);
    for (int vertex = 0;; ++vertex) {
      LightHit hit = rays.lightHit(origin, direction);
      const auto addShine = [&](const LightHit& at) {
        if (vertex == 0 && options.direct == DirectLight::reflected) return;
        const glm::vec3 shine = emission(at);
        if (!(luminance(shine) > 0.0f)) return;
        // emission that a sample of emitters also finds counts by the balance heuristic (Veach 1995)
        float share = 1.0f;
        if (density > 0.0f) {
          const float cosine = std::fabs(glm::dot(at.normal, direction));
          const float other = Emitters::Draws(emitters, origin).areaDensity(at.triangle, at.u, at.v) * at.distance * at.distance /
                              std::max(cosine, 1e-6f);
          share = density / (density + other);
        }
        (*light)[groupOfTriangle(at.triangle)] += throughput * shine * share;
      };
      glm::vec3 reflectance;
      if (!rays.hasTransmissive() || !endsAtTransmissive(origin, direction, random, addShine, &hit, &throughput, &reflectance)) {
        if (hit.kind == LightHit::Kind::sky && scene.light.sky_faces.shines(hit.triangle)) {
          (*light)[groups().of_shine] += throughput * scene.light.sky_faces.radiance(hit.triangle, direction, scene.light.sky);
          return;
        }
        if (hit.kind != LightHit::Kind::surface) {
          const glm::vec3 shine = scene.light.sky.radiance(direction);
          (*light)[groups().of_sky] += throughput * shine * skyShare(shine, density);
          return;
        }
        reflectance = albedo(hit);
        addShine(hit);
      }
      // baked light holds all bounces
      if (isBaked()) {
        (*light)[groups().of_baked] += throughput * bakedLight(scene, hit.triangle, hit.u, hit.v) * reflectance;
        return;
      }
      throughput *= reflectance;
      if (hits != nullptr && vertex == 0) *hits = {origin + direction * hit.distance, hit.normal, throughput};
      if (vertex >= options.max_bounces) return;
      // a cell of the cache holds all further bounces
      if (options.cache != nullptr) {
        const glm::vec3 point = origin + direction * hit.distance;
        if (const glm::vec3* stored = options.cache->irradiance(point, hit.normal)) {
          for (size_t g = 0; g < group_count; ++g) (*light)[g] += throughput * stored[g] / kPi;
          return;
        }
      }
      const float most = std::max({throughput.r, throughput.g, throughput.b});
      if (!(most > 0.0f)) return;
      // Russian roulette, beyond the first bounces
      if (vertex + 1 >= kSurePathVertices) {
        const float survival = std::min(kSurvival, most);
        if (random.uniform() >= survival) return;
        throughput /= survival;
      }
      // the next vertex: direct light by a sample of each kind, all else by the path's next ray
      origin = origin + direction * hit.distance + hit.normal * nudge_m;
      addReflectedDirect(origin, hit.normal, throughput, random, light);
      direction = cosineDirection(hit.normal, random.uniform(), random.uniform());
      density = std::max(1e-6f, glm::dot(direction, hit.normal) / kPi);
    }
  }

  // Everything that arrives at a place, direction by direction: add(set, direction, flux, group). Flux is what the mean over a set's
  // directions takes: the sum over all directions of radiance times solid angle is the mean over sets.
  template <class Directions, class Add>
  void gather(const glm::vec3& from, const GatherOptions& options, uint64_t seed, uint64_t index, Directions directions,
              const Add& add, std::vector<SurfacePoint>* hits = nullptr) const {
    const auto density = [&](const glm::vec3& direction) { return directions.density(direction); };
    const int rays_per_set = std::max(1, options.rays / kSetCount);
    const int count = rays_per_set * kSetCount;
    const auto share = 1.0f / static_cast<float>(rays_per_set);
    const Emitters::Draws draws(emitters, from);
    const Lattice sky_lattice(mixSeed(seed, kSkyStream), index);
    if (hits != nullptr) hits->assign(static_cast<size_t>(count), {});
    Arriving arriving;
    uint8_t group = 0;
    // one for all rays: to make one costs a tenth of a ray. Emitters have their own, so that paths are the same without them
    Random random(mixSeed(seed, kPathStream, index)), emitter_random(mixSeed(seed, kEmitterStream, index));
    for (int i = 0; i < count; ++i) {
      const int set = i % kSetCount;
      const auto [direction, direction_density] = directions.draw(i, count);
      GroupedLight light;
      std::fill_n(light.begin(), group_count, glm::vec3(0.0f));  // most scenes have one group of sixteen
      addRadiance(from, direction, options, direction_density, random, &light, hits != nullptr ? &(*hits)[i] : nullptr);
      directions.met(luminance(sumOf(light)));
      for (size_t g = 0; g < group_count; ++g) {
        if (light[g] != glm::vec3(0.0f)) add(set, direction, light[g] * (share / direction_density), g);
      }
      // each set goes evenly through all emitters
      if (options.direct != DirectLight::reflected &&
          emitterLight(draws, (i + emitter_random.uniform()) / count, from, emitter_random, density, &arriving, &group))
        add(set, arriving.direction, arriving.flux * share, group);
      if (sky.empty()) continue;
      const auto [u, v] = sky_lattice.point(i, count);
      if (skyLight(from, u, v, density, &arriving)) add(set, arriving.direction, arriving.flux * share, groups().of_sky);
    }
    // suns and lamps have samples of their own, spread over their discs and over all sets. With fewer samples than sets, which only
    // bakes have, the spread of the sets is no measure of noise; there nobody reads it
    const auto sampleAll = [&](int samples, uint64_t stream, size_t of_group, const auto& light) {
      const Lattice lattice(mixSeed(seed, stream), index);
      for (int i = 0; i < samples; ++i) {
        const auto [u, v] = lattice.point(i, samples);
        if (light(u, v))
          add(i % kSetCount, arriving.direction, arriving.flux * (static_cast<float>(kSetCount) / samples), of_group);
      }
    };
    const bool is_of_many = Directions::kIsGuided || hits != nullptr;
    // part   of the rays; fewest: of the samples, where a place is one of many
    const auto sampleCount = [&](float part, int fewest, int most) {
      const int in_sets = kSetCount * static_cast<int>(part * static_cast<float>(options.rays) / (kRaysPerSample * kSetCount));
      if (in_sets >= kSetCount || !is_of_many) return std::clamp(in_sets, kSetCount, most);
      return std::clamp(std::max(fewest, static_cast<int>(part * static_cast<float>(options.rays) / kRaysPerSample)), 1, most);
    };
    for (size_t s = 0; s < scene.light.suns.size() && options.direct == DirectLight::all; ++s) {
      const Sun& sun = scene.light.suns[s];
      const bool is_small = is_of_many && sun.angular_radius < kSmallSun;
      sampleAll(sampleCount(is_small ? static_cast<float>(kRaysPerSample) / kRaysPerSmallSun : 1.0f, 1, kMostOfSun),
                mixSeed(kSunStream, s), LightGroups::of(groups().of_sun, s),
                [&](double u, double v) { return sunLight(sun, from, u, v, &arriving); });
    }
    if (options.direct == DirectLight::none || options.direct == DirectLight::reflected) return;
    float total = 0.0f;
    for (const Lamp& lamp : lamps) total += openLight(lamp, from);
    for (size_t l = 0; l < lamps.size() && total > 0.0f; ++l) {
      const Lamp& lamp = lamps[l];
      const float part = openLight(lamp, from) / total;
      if (part <= 0.0f) continue;
      // in proportion to its part
      sampleAll(sampleCount(part, options.rays / kRaysPerFewest, kMostOfLamp), mixSeed(kLampStream, l),
                LightGroups::of(groups().of_lamp, l), [&](double u, double v) { return lampLight(lamp, from, u, v, &arriving); });
    }
  }

  template <class Add>
  void gatherFromAllSides(const glm::vec3& from, const GatherOptions& options, uint64_t seed, uint64_t index,
                          DirectionGuide* guide, const Add& add) const {
    const Lattice lattice(seed, index);
    if (guide == nullptr) {
      gather(from, options, seed, index, EvenDirections{lattice}, add);
      return;
    }
    gather(from, options, seed, index, GuidedDirections{lattice, *guide}, add);
    guide->endPlace();
  }
};

DirectLight directLightFromName(const std::string& name) {
  if (name == "all") return DirectLight::all;
  if (name == "no_suns") return DirectLight::no_suns;
  if (name == "none") return DirectLight::none;
  if (name == "reflected") return DirectLight::reflected;
  throw UsageError("light_direct", "all, no_suns, none or reflected", "'" + name + "'");
}

glm::vec3 irradiance(const LightSh& light, const glm::vec3& normal) {
  const std::array<float, kShCount> basis = shBasis(normal.x, normal.y, normal.z);
  glm::vec3 sum(0.0f);
  for (int i = 0; i < kShCount; ++i) sum += light[i] * (kCosineBand[i] * basis[i]);
  return sum;
}

glm::vec3 flooredIrradiance(const LightSh& light, const glm::vec3& normal) {
  return glm::max(irradiance(light, normal), glm::max(kFloorOfMean * light[0], glm::vec3(0.0f)));
}

LightTransport::LightTransport(const Scene& scene, const RayScene& rays) : impl_(std::make_unique<Impl>(scene, rays)) {}
LightTransport::~LightTransport() = default;

const Scene& LightTransport::scene() const { return impl_->scene; }
const RayScene& LightTransport::rays() const { return impl_->rays; }
bool LightTransport::isBaked() const { return impl_->isBaked(); }
size_t LightTransport::groupCount() const { return impl_->group_count; }

std::vector<ArrivingLight> LightTransport::arriving(const glm::dvec3& position_m, const GatherOptions& options,
                                                    uint64_t seed) const {
  std::vector<ArrivingLight> result;
  impl_->gatherFromAllSides(glm::vec3(position_m), options, seed, 0, nullptr,
                            [&](int, const glm::vec3& direction, const glm::vec3& flux, size_t) {
                              result.push_back({direction, flux / static_cast<float>(kSetCount)});
                            });
  return result;
}

GatheredLight LightTransport::gather(const glm::dvec3& position_m, const GatherOptions& options, uint64_t seed, uint64_t index,
                                     DirectionGuide* guide) const {
  GatheredLight result;
  if (!impl_->groups().names.empty()) result.groups.resize(impl_->group_count);
  std::array<LightSh, kSetCount> sets{};
  impl_->gatherFromAllSides(glm::vec3(position_m), options, seed, index, guide,
                            [&](int set, const glm::vec3& direction, const glm::vec3& flux, size_t group) {
                              const std::array<float, kShCount> basis = shBasis(direction.x, direction.y, direction.z);
                              for (int k = 0; k < kShCount; ++k) sets[set][k] += flux * basis[k];
                              if (result.groups.empty()) return;
                              const glm::vec3 share = flux / static_cast<float>(kSetCount);
                              for (int k = 0; k < kShCount; ++k) result.groups[group][k] += share * basis[k];
                            });
  // the mean over sets, and by their spread how sure it is
  for (int k = 0; k < kShCount; ++k) {
    for (const LightSh& set : sets) result.light[k] += set[k] / static_cast<float>(kSetCount);
    glm::vec3 squares(0.0f);
    for (const LightSh& set : sets) squares += (set[k] - result.light[k]) * (set[k] - result.light[k]);
    result.deviation[k] = glm::sqrt(squares / static_cast<float>(kSetCount * (kSetCount - 1)));
  }
  return result;
}

GatheredIrradiance LightTransport::gatherIrradiance(const glm::dvec3& position_m, const glm::vec3& normal,
                                                    const GatherOptions& options, uint64_t seed,
                                                    std::vector<SurfacePoint>* hits) const {
  GatheredIrradiance result;
  std::array<glm::vec3, kSetCount> sets{};
  impl_->gather(
      glm::vec3(position_m), options, seed, 0, CosineDirections{Lattice(seed), normal},
      [&](int set, const glm::vec3& direction, const glm::vec3& flux, size_t group) {
        const glm::vec3 irradiance = flux * std::max(0.0f, glm::dot(direction, normal));
        sets[set] += irradiance;
        result.groups[group] += irradiance / static_cast<float>(kSetCount);
      },
      hits);
  // the mean over sets, and by their spread how sure it is
  for (const glm::vec3& set : sets) result.irradiance += set / static_cast<float>(kSetCount);
  glm::vec3 squares(0.0f);
  for (const glm::vec3& set : sets) squares += (set - result.irradiance) * (set - result.irradiance);
  result.deviation = glm::sqrt(squares / static_cast<float>(kSetCount * (kSetCount - 1)));
  return result;
}

glm::vec3 LightTransport::radianceAlong(const glm::vec3& origin, const glm::vec3& direction, int max_bounces,
                                        uint64_t seed) const {
  Random random(mixSeed(seed, kPathStream));
  GroupedLight light{};
  impl_->addRadiance(origin, direction, {1, max_bounces}, 0.0f, random, &light);
  return impl_->sumOf(light);
}

GroupedLight LightTransport::reflected(const SurfacePoint& point, uint64_t seed) const {
  Random random(mixSeed(seed, kPathStream));
  const glm::vec3 from = point.position + point.normal * impl_->nudge_m;
  GroupedLight light{};
  // what the surface sends back: direct light by samples, the rest by one path
  impl_->addReflectedDirect(from, point.normal, glm::vec3(1.0f), random, &light);
  const glm::vec3 direction = cosineDirection(point.normal, random.uniform(), random.uniform());
  const float density = std::max(1e-6f, glm::dot(direction, point.normal) / kPi);
  impl_->addRadiance(from, direction, {}, density, random, &light);
  for (size_t g = 0; g < impl_->group_count; ++g) light[g] *= point.reflectance;
  return light;
}

glm::vec3 LightTransport::albedo(const LightHit& hit) const { return impl_->albedo(hit); }
glm::vec3 LightTransport::emission(const LightHit& hit) const { return impl_->emission(hit); }

float LightTransport::nudge() const { return impl_->nudge_m; }

}  // namespace nlg
