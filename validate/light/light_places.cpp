#include "validate/light/light_places.h"

#include <algorithm>
#include <cmath>

#include "datagen/probes/nearby_triangles.h"
#include "light/air.h"
#include "light/directions.h"
#include "light/sunlight.h"
#include "runtime_eval/numbers/random.h"
#include "scene/model/scene_light.h"
#include "validate/light/rooms.h"

namespace nlg {
namespace {

constexpr uint64_t kAirStream = 1, kSurfaceStream = 2, kTurnStream = 3, kWalkStream = 4, kEdgeStream = 5;  // of the seed
constexpr float kReachM = 1000.0f;     // of rays that look for walls and roofs
constexpr float kAcrossCosine = 0.5f;  // surfaces whose normals are at least 60 degrees apart stand across each other

glm::vec3 anyDirection(Random& random) {
  const double u = random.uniform(), v = random.uniform();
  return sphereDirection(u, v);
}

glm::dvec3 anyPosition(const ExtentBox& extent, Random& random) {
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) position[axis] = random.uniform(extent.low_m[axis], extent.high_m[axis]);
  return position;
}

bool isInside(const ExtentBox& extent, const glm::dvec3& p) {
  return glm::all(glm::greaterThanEqual(p, extent.low_m)) && glm::all(glm::lessThanEqual(p, extent.high_m));
}

// Points on a scene's surfaces, uniform in their area.
class SurfacePoints {
 public:
  explicit SurfacePoints(const Scene& scene) : scene_(scene) {
    double sum = 0.0;
    for (const glm::uvec3& t : scene.triangles) area_sums_.push_back(sum += 0.5 * glm::length(cross(t)));
  }
  bool empty() const { return area_sums_.empty() || !(area_sums_.back() > 0.0); }

  // normal   of the side that light is asked for: the front, either one of a double-sided face
  void draw(Random& random, glm::dvec3* point, glm::vec3* normal) const {
    const double at = random.uniform() * area_sums_.back();
    const auto found = std::upper_bound(area_sums_.begin(), area_sums_.end(), at);
    const size_t t = std::min<size_t>(found - area_sums_.begin(), area_sums_.size() - 1);
    const glm::uvec3& corners = scene_.triangles[t];
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    *point = glm::dvec3(scene_.positions[corners.x]) * (1.0 - u - v) + glm::dvec3(scene_.positions[corners.y]) * u +
             glm::dvec3(scene_.positions[corners.z]) * v;
    *normal = glm::vec3(glm::normalize(cross(corners)));
    const bool turns = random.chance(0.5);
    if (turns && scene_.materials[scene_.triangle_material[t]].double_sided) *normal = -*normal;
  }

 private:
  glm::dvec3 cross(const glm::uvec3& t) const {
    const glm::dvec3 a(scene_.positions[t.x]), b(scene_.positions[t.y]), c(scene_.positions[t.z]);
    return glm::cross(b - a, c - a);
  }
  const Scene& scene_;
  std::vector<double> area_sums_;
};

// What a scene is lit by from inside: lamps, the brightest of its faces, and what shines without being geometry, as lava does.
class Sources {
 public:
  Sources(const Scene& scene, double distance_m)
      : scene_(scene), shining_(shiningOf(scene)), faces_(shining_), distance_m_(distance_m) {}

  bool isNear(const glm::dvec3& place) const {
    if (!(distance_m_ > 0.0)) return false;
    for (const Lamp& lamp : scene_.light.lamps) {
      if (glm::distance(place, glm::dvec3(lamp.position)) < distance_m_ + lamp.radius_m) return true;
    }
    return !shining_.triangles.empty() && faces_.anyCloser(place, place, distance_m_);
  }

 private:
  static Scene shiningOf(const Scene& scene) {
    float brightest = 0.0f;
    const auto shine = [&](size_t t) { return luminance(scene.materials[scene.triangle_material[t]].emissive); };
    for (size_t t = 0; t < scene.triangles.size(); ++t) brightest = std::max(brightest, shine(t));
    Scene shining;
    shining.positions = scene.positions;
    for (size_t t = 0; t < scene.triangles.size(); ++t) {
      if (shine(t) > 0.0f && shine(t) >= kSourceShare * brightest) shining.triangles.push_back(scene.triangles[t]);
    }
    const SkyFaces& faces = scene.light.sky_faces;
    const auto first = glm::uvec3(static_cast<uint32_t>(shining.positions.size()));
    shining.positions.insert(shining.positions.end(), faces.positions.begin(), faces.positions.end());
    for (uint32_t t = 0; t < faces.triangles.size(); ++t) {
      if (faces.shines(t)) shining.triangles.push_back(faces.triangles[t] + first);
    }
    return shining;
  }

  const Scene& scene_;
  const Scene shining_;
  const NearbyTriangles faces_;
  const double distance_m_;
};

double sourceDistance(const ExtentBox& extent, const LightPlaceOptions& options) {
  return std::min(options.source_distance_m, kSourceDiagonalShare * glm::length(extent.high_m - extent.low_m));
}

class Drawing {
 public:
  Drawing(const Scene& scene, const RayScene& rays, const ExtentBox& extent, const LightPlaceOptions& options)
      : scene_(scene),
        rays_(rays),
        extent_(extent),
        options_(options),
        surfaces_(scene),
        sources_(scene, sourceDistance(extent, options)) {
    result_.source_distance_m = sourceDistance(extent, options);
  }

  LightPlaces draw() {
    drawAir();
    drawBeforeSurfaces();
    turn();
    drawWalks();
    drawEdges();
    return std::move(result_);
  }

 private:
  void drawAir() {
    Random random(mixSeed(options_.seed, kAirStream));
    for (uint64_t draw = 0; draw < options_.draws && result_.in_air < options_.air; ++draw) {
      LightPlace place;
      place.position_m = anyPosition(extent_, random);
      place.normal = anyDirection(random);
      ++result_.drawn;
      if (!isInAir(rays_, place.position_m)) continue;
      if (sources_.isNear(place.position_m)) {
        ++result_.near_source;
        continue;
      }
      ++result_.in_air;
      result_.places.push_back(place);
    }
  }

  void drawBeforeSurfaces() {
    if (surfaces_.empty()) return;
    Random random(mixSeed(options_.seed, kSurfaceStream));
    const uint64_t wanted = options_.surface / kSurfaceClassCount;
    for (uint64_t draw = 0; draw < options_.draws; ++draw) {
      const int c = static_cast<int>(draw % kSurfaceClassCount);
      if (result_.surface_count[c] >= wanted) {
        if (std::all_of(result_.surface_count.begin(), result_.surface_count.end(), [&](uint64_t n) { return n >= wanted; }))
          break;
        continue;
      }
      LightPlace place;
      glm::dvec3 point;
      surfaces_.draw(random, &point, &place.normal);
      const double distance = random.uniform(kSurfaceBordersM[c], kSurfaceBordersM[c + 1]);
      place.position_m = point + distance * glm::dvec3(place.normal);
      place.group = PlaceGroup::surface;
      place.surface_class = static_cast<uint8_t>(c);
      const glm::vec3 off_surface(point + 0.1 * distance * glm::dvec3(place.normal));
      if (!isInside(extent_, place.position_m) || rays_.isBlocked(off_surface, glm::vec3(place.position_m)) ||
          !isInAir(rays_, place.position_m) || sources_.isNear(place.position_m))
        continue;
      ++result_.surface_count[c];
      result_.places.push_back(place);
    }
  }

  void turn() {
    Random random(mixSeed(options_.seed, kTurnStream));
    const size_t end = result_.places.size();
    for (size_t i = 0; i < end; ++i) {
      LightPlace place = result_.places[i];
      if (place.group != PlaceGroup::surface || place.surface_class < kFirstFarClass) continue;
      place.group = PlaceGroup::turned;
      place.normal = anyDirection(random);
      result_.places.push_back(place);
    }
  }

  void drawWalks() {
    Random random(mixSeed(options_.seed, kWalkStream));
    for (uint64_t draw = 0; draw < options_.draws && result_.walk_count < options_.walks; ++draw) {
      LightPlace place;
      place.position_m = anyPosition(extent_, random);
      place.normal = anyDirection(random);
      place.group = PlaceGroup::walk;
      place.walk = static_cast<uint32_t>(result_.walk_count);
      const glm::dvec3 step = options_.step_m * glm::dvec3(anyDirection(random));
      std::vector<LightPlace> steps;
      while (static_cast<int>(steps.size()) < options_.walk_steps && isInside(extent_, place.position_m) &&
             isInAir(rays_, place.position_m)) {
        if (!steps.empty() && rays_.isBlocked(glm::vec3(steps.back().position_m), glm::vec3(place.position_m))) break;
        steps.push_back(place);
        place.position_m += step;
      }
      if (static_cast<int>(steps.size()) < options_.least_walk_steps) continue;
      ++result_.walk_count;
      result_.places.insert(result_.places.end(), steps.begin(), steps.end());
    }
  }

  // Places beside edges, drawn along rays: off a surface, along its plane to the next one, and for corners along both to a third.
  void drawEdges() {
    if (surfaces_.empty()) return;
    Random random(mixSeed(options_.seed, kEdgeStream));
    std::vector<LightPlace> corners;
    for (uint64_t draw = 0; draw < options_.draws; ++draw) {
      if (result_.edge_count >= options_.edges && result_.corner_count >= options_.edges) break;
      LightPlace place;
      glm::dvec3 point;
      surfaces_.draw(random, &point, &place.normal);
      place.position_m = point + kEdgeOffM * glm::dvec3(place.normal);
      place.group = PlaceGroup::edge;
      glm::vec3 second(0.0f);
      if (!stepBeforeNext(random, anyAlong(random, place.normal), {place.normal}, &place.position_m, &second)) continue;
      if (result_.edge_count < options_.edges && standsAtEdge(place)) {
        ++result_.edge_count;
        result_.places.push_back(place);
      }
      const glm::vec3 along = glm::normalize(glm::cross(place.normal, second));
      place.group = PlaceGroup::corner;
      glm::vec3 third(0.0f);
      if (result_.corner_count >= options_.edges ||
          !stepBeforeNext(random, random.chance(0.5) ? along : -along, {place.normal, second}, &place.position_m, &third) ||
          !isBefore(place.position_m, second, kEdgeHighM) || !standsAtEdge(place))
        continue;
      ++result_.corner_count;
      corners.push_back(place);
    }
    result_.places.insert(result_.places.end(), corners.begin(), corners.end());
  }

  // Any direction along a surface's plane.
  static glm::vec3 anyAlong(Random& random, const glm::vec3& normal) {
    glm::vec3 along = anyDirection(random);
    along -= glm::dot(along, normal) * normal;
    const float length = glm::length(along);
    return length > 0.0f ? along / length : glm::vec3(0.0f);
  }

  // Moves a place along a direction to 1 to 10 cm before the surface that stands there, across all of the others.
  bool stepBeforeNext(Random& random, const glm::vec3& direction, std::initializer_list<glm::vec3> others, glm::dvec3* position_m,
                      glm::vec3* normal) const {
    const double distance = random.uniform(kEdgeLowM, kEdgeHighM);
    const LightHit hit = rays_.lightHit(glm::vec3(*position_m), kReachM * direction);
    if (hit.kind != LightHit::Kind::surface) return false;
    for (const glm::vec3& other : others) {
      if (std::fabs(glm::dot(hit.normal, other)) > kAcrossCosine) return false;
    }
    const double slope = -glm::dot(direction, hit.normal);
    const double way = double{hit.distance} * kReachM - distance / std::max(slope, 1e-3);
    if (way < 0.0) return false;
    *position_m += way * glm::dvec3(direction);
    *normal = hit.normal;
    return true;
  }

  // Whether the next surface against a normal's direction has that normal, and is that near.
  bool isBefore(const glm::dvec3& position_m, const glm::vec3& normal, double distance_m) const {
    const LightHit hit = rays_.lightHit(glm::vec3(position_m), -normal);
    return hit.kind == LightHit::Kind::surface && hit.distance <= distance_m + 1e-3 && glm::dot(hit.normal, normal) > 0.99f;
  }

  bool standsAtEdge(const LightPlace& place) const {
    const glm::vec3 at(place.position_m);
    return isInside(extent_, place.position_m) && isBefore(place.position_m, place.normal, kEdgeOffM) &&
           rays_.lightHit(at, {0.0f, kReachM, 0.0f}).kind == LightHit::Kind::surface &&
           !isInSunlight(scene_, rays_, place.position_m, place.normal) && isInAir(rays_, place.position_m) &&
           !sources_.isNear(place.position_m);
  }

  const Scene& scene_;
  const RayScene& rays_;
  const ExtentBox extent_;
  const LightPlaceOptions& options_;
  SurfacePoints surfaces_;
  Sources sources_;
  LightPlaces result_;
};

}  // namespace

double LightPlaces::surfaceWeight(uint8_t surface_class) const {
  if (surface_class < kFirstFarClass || surface_count[surface_class] == 0) return 0.0;
  // classes that no place was found in leave their share to the others
  double covered = 0.0;
  for (int c = kFirstFarClass; c < kSurfaceClassCount; ++c) {
    if (surface_count[c] > 0) covered += kSurfaceBordersM[c + 1] - kSurfaceBordersM[c];
  }
  const double width = kSurfaceBordersM[surface_class + 1] - kSurfaceBordersM[surface_class];
  return width / covered / static_cast<double>(surface_count[surface_class]);
}

void partIntoRooms(LightPlaces* places, const RayScene& rays, int threads) {
  std::vector<LightPlace*> parted;
  std::vector<glm::dvec3> positions;  // those in air first
  for (LightPlace& place : places->places) {
    if (place.group == PlaceGroup::walk) continue;
    parted.push_back(&place);
    positions.push_back(place.position_m);
  }
  RoomOptions options;
  options.most_places = std::min<size_t>(options.most_places, places->in_air);
  options.threads = threads;
  const std::vector<SeenRoom> rooms = findRooms(rays, positions, options);
  const std::vector<uint32_t> room = roomOfPlaces(rooms, positions.size());
  for (size_t i = 0; i < parted.size(); ++i) parted[i]->room = room[i];
  places->room_count = static_cast<uint32_t>(rooms.size());
}

LightPlaces drawLightPlaces(const Scene& scene, const RayScene& rays, const ExtentBox& extent, const LightPlaceOptions& options) {
  return Drawing(scene, rays, extent, options).draw();
}

}  // namespace nlg
