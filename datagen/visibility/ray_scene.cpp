#include "datagen/visibility/ray_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include <embree3/rtcore.h>

#include "datagen/visibility/air_regions.h"
#include "scene/solid/triangle_distance.h"
#include "tool/error.h"
#include "tool/progress.h"

namespace nlg {

namespace {

// One for all scenes, and never released: with a device goes the limit that "threads=1" puts on TBB, which then starts a thread in passing
// that nobody needs, and aborts where the system refuses it.
RTCDevice embree() {
  static const RTCDevice device = rtcNewDevice("threads=1");
  return device;
}

}  // namespace

// Which of a scene's triangles a geometry holds.
struct TriangleChoice {
  bool is_all = true;
  std::vector<uint32_t> ids;  // unless it is all: by primitive, the scene's triangle

  uint32_t operator[](uint32_t primitive) const { return is_all ? primitive : ids[primitive]; }
};

struct RayScene::Impl {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<uint8_t> double_sided;           // by triangle
  TriangleChoice walls, opaque, transmissive;  // all but thin transmissive ones, all but transmissive ones, those alone
  RTCScene scene = nullptr;                    // of walls
  RTCScene opaque_scene = nullptr;             // null without dense transmissive surfaces: then it is `scene`
  RTCScene light_scene = nullptr;              // of opaque ones, and sky faces as geometry 1; null without sky faces
  RTCScene transmissive_scene = nullptr;       // null without transmissive surfaces
  std::vector<glm::vec3> sky_normals;          // by sky face, not normalised
  double cavity_m = 0.0;
  std::optional<AirRegions> air_regions;

  // What a ray meets within a short stretch, all of it.
  struct FacingCollector {
    RTCIntersectContext context;  // first: Embree hands it to the filter
    const Impl* scene;
    const TriangleChoice* surfaces;
    glm::vec3 direction;
    bool front = false, back = false, both = false;
  };
  static Facing facingOfHit(const RTCFilterFunctionNArguments* arguments);
  static void collectFacing(const RTCFilterFunctionNArguments* arguments);
  static void passBacks(const RTCFilterFunctionNArguments* arguments);

  static void attach(RTCScene to, unsigned number, const std::vector<glm::vec3>& corners, const std::vector<glm::uvec3>& faces);
  RTCScene newScene(const TriangleChoice& choice) const;
  glm::vec3 normal(uint32_t triangle) const;  // not normalised
  RTCScene opaqueScene() const { return opaque_scene != nullptr ? opaque_scene : scene; }
  RTCScene lightScene() const { return light_scene != nullptr ? light_scene : opaqueScene(); }
  LightHit surfaceHit(const RTCRayHit& hit, uint32_t triangle, const glm::vec3& direction) const;
  // geometry, primitive   of a hit; surfaces   that the geometry kSurfaces holds
  Facing facing(unsigned geometry, unsigned primitive, const TriangleChoice& surfaces, const glm::vec3& direction) const;
  Facing firstFacing(RTCScene against, const TriangleChoice& surfaces, const glm::vec3& origin, const glm::vec3& direction) const;
  // What the filter makes of all that is met where a ray ended.
  static RTCRayHit retrace(RTCScene against, RTCRayHit hit, RTCFilterFunctionN filter, FacingCollector* collector);
  Facing allFacing(RTCScene against, const TriangleChoice& surfaces, const RTCRayHit& hit, const glm::vec3& direction) const;
  LightHit lightHit(const glm::vec3& origin, const glm::vec3& direction, float far) const;

  ~Impl() {
    for (const RTCScene made : {scene, opaque_scene, light_scene, transmissive_scene}) {
      if (made != nullptr) rtcReleaseScene(made);
    }
  }
};

namespace {

constexpr unsigned kSurfaces = 0, kSky = 1;  // numbers of geometries: they tell what a ray met

struct TriangleCollector {
  const TriangleChoice& surfaces;
  std::vector<uint32_t>* triangles;
};

bool collectTriangle(RTCPointQueryFunctionArguments* arguments) {
  const TriangleCollector& collector = *static_cast<TriangleCollector*>(arguments->userPtr);
  collector.triangles->push_back(collector.surfaces[arguments->primID]);
  return false;
}

struct NearestSurface {
  const TriangleChoice& surfaces;
  const std::vector<glm::vec3>& positions;
  const std::vector<glm::uvec3>& triangles;
  float distance;
};

bool findNearer(RTCPointQueryFunctionArguments* arguments) {
  NearestSurface& nearest = *static_cast<NearestSurface*>(arguments->userPtr);
  const RTCPointQuery& at = *arguments->query;
  const glm::uvec3& corners = nearest.triangles[nearest.surfaces[arguments->primID]];
  const float distance = distanceToTriangle({at.x, at.y, at.z}, nearest.positions[corners.x], nearest.positions[corners.y],
                                            nearest.positions[corners.z]);
  if (!(distance < nearest.distance)) return false;
  nearest.distance = arguments->query->radius = distance;
  return true;
}

bool findSky(RTCPointQueryFunctionArguments* arguments) {
  if (arguments->geomID == kSky) *static_cast<bool*>(arguments->userPtr) = true;
  return false;
}

// The sphere around a cube, and what rounding of far positions could take away.
RTCPointQuery queryAroundCube(const glm::vec3& center, float half_side) {
  const float reach = std::max({std::fabs(center.x), std::fabs(center.y), std::fabs(center.z)});
  return {center.x, center.y, center.z, 0.0f, half_side * 1.7330509f + reach * 0x1p-20f};
}

// Calls `visit` for the triangles whose boxes come near the place of the query.
void visitNear(RTCScene scene, RTCPointQuery query, RTCPointQueryFunction visit, void* result) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, visit, result);
}

// From origin + near * direction to origin + far * direction.
RTCRay rayAlong(const glm::vec3& origin, const glm::vec3& direction, float near, float far) {
  return {origin.x, origin.y, origin.z, near, direction.x, direction.y, direction.z, 0.0f, far, ~0u, 0, 0};
}

bool isOccluded(RTCScene against, const glm::vec3& from, const glm::vec3& direction, float far) {
  RTCRay ray = rayAlong(from, direction, 0.0f, far);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(against, &context, &ray);
  return ray.tfar < 0.0f;
}

constexpr float kInfinity = std::numeric_limits<float>::infinity();

RTCRayHit firstRayHit(RTCScene against, const glm::vec3& origin, const glm::vec3& direction, float near = 0.0f,
                      float far = kInfinity) {
  RTCRayHit hit{};
  hit.ray = rayAlong(origin, direction, near, far);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(against, &context, &hit);
  return hit;
}

void* newBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t stride, size_t count) {
  return rtcSetNewGeometryBuffer(geometry, type, 0, format, stride, count);
}

}  // namespace

void RayScene::Impl::attach(RTCScene to, unsigned number, const std::vector<glm::vec3>& corners,
                            const std::vector<glm::uvec3>& faces) {
  if (faces.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(embree(), RTC_GEOMETRY_TYPE_TRIANGLE);
  void* positions_out = newBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), corners.size());
  void* triangles_out = newBuffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, sizeof(glm::uvec3), faces.size());
  if (positions_out && triangles_out) {
    std::copy(corners.begin(), corners.end(), static_cast<glm::vec3*>(positions_out));
    std::copy(faces.begin(), faces.end(), static_cast<glm::uvec3*>(triangles_out));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(to, geometry, number);
  }
  rtcReleaseGeometry(geometry);
}

RTCScene RayScene::Impl::newScene(const TriangleChoice& choice) const {
  const RTCScene made = rtcNewScene(embree());
  rtcSetSceneFlags(made, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  std::vector<glm::uvec3> chosen;
  for (const uint32_t triangle : choice.ids) chosen.push_back(triangles[triangle]);
  attach(made, kSurfaces, positions, choice.is_all ? triangles : chosen);
  return made;
}

RayScene::RayScene(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  const Progress progress("ray structures");
  impl_->positions = scene.positions;
  impl_->cavity_m = scene.cavity_m;
  impl_->triangles = scene.triangles;
  if (scene.cavity_m > 0.0) {
    const Bounds bounds = sceneBounds(scene);
    impl_->air_regions.emplace(*this, static_cast<float>(scene.cavity_m), bounds.min, bounds.max);
  }
  impl_->double_sided.reserve(scene.triangles.size());
  // three choices of triangles: what blocks functions, what blocks light, and what light passes in part
  std::array<std::vector<uint32_t>, 3> of_kind;  // none, thin, dense
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const Material& material = scene.materials[scene.triangle_material[t]];
    impl_->double_sided.push_back(material.double_sided);
    of_kind[static_cast<size_t>(material.transmissive)].push_back(t);
  }
  const SkyFaces& sky = scene.light.sky_faces;
  const auto& [none, thin, dense] = of_kind;
  const auto joined = [](const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
    TriangleChoice choice{false, {}};
    std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(choice.ids));
    return choice;
  };
  // thin surfaces are air for functions; light meets both kinds point by point
  if (!thin.empty()) impl_->walls = joined(none, dense);
  if (thin.size() + dense.size() > 0) impl_->opaque = joined(none, {});
  impl_->transmissive = joined(thin, dense);

  // a choice that equals another has no tree of its own
  impl_->scene = impl_->newScene(impl_->walls);
  if (!dense.empty()) impl_->opaque_scene = impl_->newScene(impl_->opaque);
  if (!impl_->transmissive.ids.empty()) impl_->transmissive_scene = impl_->newScene(impl_->transmissive);
  // faces of sky end rays of light, but block no function: they lie in a tree of their own
  if (!sky.triangles.empty()) {
    impl_->light_scene = impl_->newScene(impl_->opaque);
    impl_->attach(impl_->light_scene, kSky, sky.positions, sky.triangles);
    for (const glm::uvec3& t : sky.triangles)
      impl_->sky_normals.push_back(glm::cross(sky.positions[t.y] - sky.positions[t.x], sky.positions[t.z] - sky.positions[t.x]));
  }
  for (const RTCScene made : {impl_->scene, impl_->opaque_scene, impl_->light_scene, impl_->transmissive_scene}) {
    if (made != nullptr) rtcCommitScene(made);
  }
  // Embree keeps its first error until it is asked
  if (const RTCError error = rtcGetDeviceError(embree()); error != RTC_ERROR_NONE) {
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();  // of the machine, not of the file
    throw InputError(scene.id, "acceleration structure", "Embree to build it", "Embree error " + std::to_string(error));
  }
}

RayScene::~RayScene() = default;

Facing RayScene::Impl::facing(unsigned geometry, unsigned primitive, const TriangleChoice& surfaces,
                              const glm::vec3& direction) const {
  if (geometry == kSurfaces && double_sided[surfaces[primitive]]) return Facing::both;
  const glm::vec3 out = geometry == kSky ? sky_normals[primitive] : normal(surfaces[primitive]);
  return glm::dot(out, direction) < 0.0f ? Facing::front : Facing::back;
}

Facing RayScene::Impl::facingOfHit(const RTCFilterFunctionNArguments* arguments) {
  const auto& collector = *reinterpret_cast<const FacingCollector*>(arguments->context);
  return collector.scene->facing(RTCHitN_geomID(arguments->hit, 1, 0), RTCHitN_primID(arguments->hit, 1, 0), *collector.surfaces,
                                 collector.direction);
}

void RayScene::Impl::collectFacing(const RTCFilterFunctionNArguments* arguments) {
  FacingCollector& collector = *reinterpret_cast<FacingCollector*>(arguments->context);
  const Facing facing = facingOfHit(arguments);
  collector.front |= facing == Facing::front;
  collector.back |= facing == Facing::back;
  collector.both |= facing == Facing::both;
  arguments->valid[0] = 0;  // go on to the next one
}

void RayScene::Impl::passBacks(const RTCFilterFunctionNArguments* arguments) {
  if (facingOfHit(arguments) == Facing::back) arguments->valid[0] = 0;
}

glm::vec3 RayScene::Impl::normal(uint32_t triangle) const {
  const glm::uvec3& corners = triangles[triangle];
  return glm::cross(positions[corners.y] - positions[corners.x], positions[corners.z] - positions[corners.x]);
}

// Which of coincident faces comes first is up to the traversal.
RTCRayHit RayScene::Impl::retrace(RTCScene against, RTCRayHit hit, RTCFilterFunctionN filter, FacingCollector* collector) {
  rtcInitIntersectContext(&collector->context);
  collector->context.filter = filter;
  const float distance = hit.ray.tfar;
  hit.ray.tnear = distance * (1.0f - 0x1p-18f);
  hit.ray.tfar = distance * (1.0f + 0x1p-18f);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(against, &collector->context, &hit);
  return hit;
}

Facing RayScene::Impl::allFacing(RTCScene against, const TriangleChoice& surfaces, const RTCRayHit& hit,
                                 const glm::vec3& direction) const {
  FacingCollector collector{{}, this, &surfaces, direction};
  retrace(against, hit, collectFacing, &collector);
  if (collector.both || (collector.front && collector.back)) return Facing::both;
  return collector.back ? Facing::back : Facing::front;
}

Facing RayScene::Impl::firstFacing(RTCScene against, const TriangleChoice& surfaces, const glm::vec3& origin,
                                   const glm::vec3& direction) const {
  const RTCRayHit hit = firstRayHit(against, origin, direction);
  return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Facing::nothing : allFacing(against, surfaces, hit, direction);
}

Facing RayScene::firstFacing(const glm::vec3& origin, const glm::vec3& direction) const {
  return impl_->firstFacing(impl_->scene, impl_->walls, origin, direction);
}

bool RayScene::hasSkyFaces() const { return !impl_->sky_normals.empty(); }

Facing RayScene::firstFacingWithSky(const glm::vec3& origin, const glm::vec3& direction) const {
  return impl_->firstFacing(impl_->lightScene(), impl_->opaque, origin, direction);
}

Facing RayScene::firstBackWithSky(const glm::vec3& origin, const glm::vec3& direction) const {
  const RTCScene against = impl_->lightScene();
  const RTCRayHit hit = firstRayHit(against, origin, direction);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return Facing::nothing;
  const Facing first = impl_->facing(hit.hit.geomID, hit.hit.primID, impl_->opaque, direction);
  return first == Facing::back ? impl_->allFacing(against, impl_->opaque, hit, direction) : first;
}

LightHit RayScene::Impl::surfaceHit(const RTCRayHit& hit, uint32_t triangle, const glm::vec3& direction) const {
  const glm::vec3 out = glm::normalize(glm::vec3(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z));
  const bool is_front = glm::dot(out, direction) < 0.0f;
  return {LightHit::Kind::surface, is_front, triangle, hit.ray.tfar, hit.hit.u, hit.hit.v, is_front ? out : -out};
}

float RayScene::justBehind(const LightHit& hit) { return std::nextafter(hit.distance * (1.0f + 0x1p-20f), kInfinity); }

LightHit RayScene::Impl::lightHit(const glm::vec3& origin, const glm::vec3& direction, float far) const {
  for (float near = 0.0f;;) {
    RTCRayHit hit = firstRayHit(lightScene(), origin, direction, near, far);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    bool is_back = facing(hit.hit.geomID, hit.hit.primID, opaque, direction) == Facing::back;
    // lava has a face up and one down in the same place, and sheets are often modelled so: light is that of the one towards it
    if (is_back) {
      FacingCollector collector{{}, this, &opaque, direction};
      const RTCRayHit front = retrace(lightScene(), hit, passBacks, &collector);
      is_back = front.hit.geomID == RTC_INVALID_GEOMETRY_ID;
      if (!is_back) hit = front;
    }
    if (hit.hit.geomID != kSky) return surfaceHit(hit, opaque[hit.hit.primID], direction);
    const LightHit result{LightHit::Kind::sky, true, hit.hit.primID, hit.ray.tfar};
    if (!is_back) return result;
    // from behind: on, past this face
    near = justBehind(result);
    if (!(near <= far && std::isfinite(near))) return {};
  }
}

LightHit RayScene::lightHit(const glm::vec3& origin, const glm::vec3& direction) const {
  return impl_->lightHit(origin, direction, kInfinity);
}

bool RayScene::hasTransmissive() const { return impl_->transmissive_scene != nullptr; }

LightHit RayScene::transmissiveHit(const glm::vec3& origin, const glm::vec3& direction, float near, float far) const {
  if (impl_->transmissive_scene == nullptr || !(near < far)) return {};
  const RTCRayHit hit = firstRayHit(impl_->transmissive_scene, origin, direction, near, far);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return impl_->surfaceHit(hit, impl_->transmissive[hit.hit.primID], direction);
}

bool RayScene::isBlocked(const glm::vec3& from, const glm::vec3& to) const {
  return isOccluded(impl_->scene, from, to - from, 1.0f);
}

bool RayScene::isOpaqueBetween(const glm::vec3& from, const glm::vec3& to) const {
  return isOccluded(impl_->opaqueScene(), from, to - from, 1.0f);
}

bool RayScene::isOpaqueAlong(const glm::vec3& from, const glm::vec3& direction) const {
  return isOccluded(impl_->opaqueScene(), from, direction, kInfinity);
}

bool RayScene::isLightBlocked(const glm::vec3& from, const glm::vec3& to) const {
  if (!hasSkyFaces()) return isOpaqueBetween(from, to);
  return impl_->lightHit(from, to - from, 1.0f).kind != LightHit::Kind::nothing;
}

bool RayScene::isSkyNearCube(const glm::vec3& center, float half_side) const {
  if (!hasSkyFaces()) return false;
  bool is_near = false;
  visitNear(impl_->light_scene, queryAroundCube(center, half_side), findSky, &is_near);
  return is_near;
}

double RayScene::cavityWidth() const { return impl_->cavity_m; }

bool RayScene::isFree(const glm::vec3& center, float radius) const { return clearance(center, radius) >= radius; }

float RayScene::clearance(const glm::vec3& center, float most) const {
  NearestSurface nearest{impl_->opaque, impl_->positions, impl_->triangles, most};
  visitNear(impl_->opaqueScene(), {center.x, center.y, center.z, 0.0f, most}, findNearer, &nearest);
  return nearest.distance;
}

const AirRegions& RayScene::airRegions() const { return *impl_->air_regions; }

void RayScene::trianglesNearCube(const glm::vec3& center, float half_side, std::vector<uint32_t>* triangles) const {
  triangles->clear();
  TriangleCollector collector{impl_->walls, triangles};
  visitNear(impl_->scene, queryAroundCube(center, half_side), collectTriangle, &collector);
  std::sort(triangles->begin(), triangles->end());
}

const std::vector<glm::vec3>& RayScene::positions() const { return impl_->positions; }
const std::vector<glm::uvec3>& RayScene::triangles() const { return impl_->triangles; }

}  // namespace nlg
