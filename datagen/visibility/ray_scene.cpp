#include "datagen/visibility/ray_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <embree3/rtcore.h>

#include "tool/error.h"

namespace nlg {

namespace {

// One for all scenes, and never released: with a device goes the limit that "threads=1" puts on TBB, which then starts a thread in passing
// that nobody needs, and aborts where the system refuses it.
RTCDevice embree() {
  static const RTCDevice device = rtcNewDevice("threads=1");
  return device;
}

}  // namespace

struct RayScene::Impl {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<uint8_t> double_sided;  // by triangle
  RTCScene scene = nullptr;
  RTCScene light_scene = nullptr;      // with sky faces as geometry 1; null without any
  std::vector<glm::vec3> sky_normals;  // by sky face, not normalised

  // What a ray meets within a short stretch, all of it.
  struct FacingCollector {
    RTCIntersectContext context;  // first: Embree hands it to the filter
    const Impl* scene;
    glm::vec3 direction;
    bool front = false, back = false, both = false;
  };
  static void collectFacing(const RTCFilterFunctionNArguments* arguments);

  void attach(RTCScene to, unsigned number, const std::vector<glm::vec3>& corners, const std::vector<glm::uvec3>& faces);
  glm::vec3 normal(uint32_t triangle) const;  // not normalised
  RTCScene lightScene() const { return light_scene != nullptr ? light_scene : scene; }
  // geometry   kSurfaces or kSky
  Facing facing(unsigned geometry, uint32_t triangle, const glm::vec3& direction) const;
  Facing firstFacing(RTCScene against, const glm::vec3& origin, const glm::vec3& direction) const;

  ~Impl() {
    if (light_scene) rtcReleaseScene(light_scene);
    if (scene) rtcReleaseScene(scene);
  }
};

namespace {

constexpr unsigned kSurfaces = 0, kSky = 1;  // numbers of geometries: they tell what a ray met

bool collectTriangle(RTCPointQueryFunctionArguments* arguments) {
  static_cast<std::vector<uint32_t>*>(arguments->userPtr)->push_back(arguments->primID);
  return false;
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

// From origin + near * direction to origin + far * direction.
RTCRay rayAlong(const glm::vec3& origin, const glm::vec3& direction, float near, float far) {
  return {origin.x, origin.y, origin.z, near, direction.x, direction.y, direction.z, 0.0f, far, ~0u, 0, 0};
}

RTCRayHit firstRayHit(RTCScene against, const glm::vec3& origin, const glm::vec3& direction, float near = 0.0f) {
  RTCRayHit hit{};
  hit.ray = rayAlong(origin, direction, near, std::numeric_limits<float>::infinity());
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

RayScene::RayScene(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  impl_->positions = scene.positions;
  impl_->triangles = scene.triangles;
  impl_->double_sided.reserve(scene.triangles.size());
  for (const uint32_t material : scene.triangle_material) {
    impl_->double_sided.push_back(scene.materials[material].double_sided);
  }
  impl_->scene = rtcNewScene(embree());
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  impl_->attach(impl_->scene, kSurfaces, scene.positions, scene.triangles);
  rtcCommitScene(impl_->scene);
  const SkyFaces& sky = scene.light.sky_faces;
  if (!sky.triangles.empty()) {
    impl_->light_scene = rtcNewScene(embree());
    rtcSetSceneFlags(impl_->light_scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    impl_->attach(impl_->light_scene, kSurfaces, scene.positions, scene.triangles);
    impl_->attach(impl_->light_scene, kSky, sky.positions, sky.triangles);
    rtcCommitScene(impl_->light_scene);
    for (const glm::uvec3& t : sky.triangles)
      impl_->sky_normals.push_back(glm::cross(sky.positions[t.y] - sky.positions[t.x], sky.positions[t.z] - sky.positions[t.x]));
  }
  if (const RTCError error = rtcGetDeviceError(embree()); error != RTC_ERROR_NONE) {
    throw InputError(scene.id, "acceleration structure", "Embree to build it", "Embree error " + std::to_string(error));
  }
}

RayScene::~RayScene() = default;

uint32_t RayScene::occluded(const SegmentPacket& segments, int count) const {
  alignas(64) RTCRay16 rays;
  alignas(64) int active[kPacketSize];
  for (int i = 0; i < kPacketSize; ++i) {
    active[i] = i < count ? -1 : 0;
    rays.org_x[i] = segments.origin_x[i];
    rays.org_y[i] = segments.origin_y[i];
    rays.org_z[i] = segments.origin_z[i];
    rays.dir_x[i] = segments.direction_x[i];
    rays.dir_y[i] = segments.direction_y[i];
    rays.dir_z[i] = segments.direction_z[i];
    rays.tnear[i] = 0.0f;
    rays.tfar[i] = 1.0f;
    rays.time[i] = 0.0f;
    rays.mask[i] = ~0u;
    rays.id[i] = i;
    rays.flags[i] = 0;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded16(active, impl_->scene, &context, &rays);
  uint32_t hits = 0;
  for (int i = 0; i < count; ++i) hits |= static_cast<uint32_t>(rays.tfar[i] < 0.0f) << i;
  return hits;
}

Facing RayScene::Impl::facing(unsigned geometry, uint32_t triangle, const glm::vec3& direction) const {
  if (geometry == kSurfaces && double_sided[triangle]) return Facing::both;
  const glm::vec3 out = geometry == kSky ? sky_normals[triangle] : normal(triangle);
  return glm::dot(out, direction) < 0.0f ? Facing::front : Facing::back;
}

void RayScene::Impl::collectFacing(const RTCFilterFunctionNArguments* arguments) {
  FacingCollector& collector = *reinterpret_cast<FacingCollector*>(arguments->context);
  const Facing facing =
      collector.scene->facing(RTCHitN_geomID(arguments->hit, 1, 0), RTCHitN_primID(arguments->hit, 1, 0), collector.direction);
  collector.front |= facing == Facing::front;
  collector.back |= facing == Facing::back;
  collector.both |= facing == Facing::both;
  arguments->valid[0] = 0;  // go on to the next one
}

glm::vec3 RayScene::Impl::normal(uint32_t triangle) const {
  const glm::uvec3& corners = triangles[triangle];
  return glm::cross(positions[corners.y] - positions[corners.x], positions[corners.z] - positions[corners.x]);
}

Facing RayScene::Impl::firstFacing(RTCScene against, const glm::vec3& origin, const glm::vec3& direction) const {
  RTCRayHit hit = firstRayHit(against, origin, direction);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return Facing::nothing;
  // which of coincident faces comes first is up to the traversal: ask for all of them
  FacingCollector collector{{}, this, direction};
  rtcInitIntersectContext(&collector.context);
  collector.context.filter = collectFacing;
  const float distance = hit.ray.tfar;
  hit.ray.tnear = distance * (1.0f - 0x1p-18f);
  hit.ray.tfar = distance * (1.0f + 0x1p-18f);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(against, &collector.context, &hit);
  if (collector.both || (collector.front && collector.back)) return Facing::both;
  return collector.back ? Facing::back : Facing::front;
}

Facing RayScene::firstFacing(const glm::vec3& origin, const glm::vec3& direction) const {
  return impl_->firstFacing(impl_->scene, origin, direction);
}

bool RayScene::hasSkyFaces() const { return impl_->light_scene != nullptr; }

Facing RayScene::firstFacingWithSky(const glm::vec3& origin, const glm::vec3& direction) const {
  return impl_->firstFacing(impl_->lightScene(), origin, direction);
}

LightHit RayScene::lightHit(const glm::vec3& origin, const glm::vec3& direction) const {
  for (float near = 0.0f;;) {
    const RTCRayHit hit = firstRayHit(impl_->lightScene(), origin, direction, near);
    LightHit result;
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return result;
    result.distance = hit.ray.tfar;
    result.triangle = hit.hit.primID;
    if (hit.hit.geomID == kSky) {
      result.kind = LightHit::Kind::sky;
      if (glm::dot(impl_->sky_normals[hit.hit.primID], direction) < 0.0f) return result;
      // from behind: on, past this face
      near = std::nextafter(hit.ray.tfar * (1.0f + 0x1p-20f), std::numeric_limits<float>::infinity());
      if (!std::isfinite(near)) return {};
      continue;
    }
    result.kind = LightHit::Kind::surface;
    result.u = hit.hit.u;
    result.v = hit.hit.v;
    const glm::vec3 normal = glm::normalize(impl_->normal(hit.hit.primID));
    result.is_front = glm::dot(normal, direction) < 0.0f;
    result.normal = result.is_front ? normal : -normal;
    return result;
  }
}

bool RayScene::isBlocked(const glm::vec3& from, const glm::vec3& to) const {
  RTCRay ray = rayAlong(from, to - from, 0.0f, 1.0f);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0.0f;
}

bool RayScene::isLightBlocked(const glm::vec3& from, const glm::vec3& to) const {
  if (impl_->light_scene == nullptr) return isBlocked(from, to);
  const LightHit hit = lightHit(from, to - from);
  return hit.kind != LightHit::Kind::nothing && hit.distance <= 1.0f;
}

bool RayScene::isSkyNearCube(const glm::vec3& center, float half_side) const {
  if (impl_->light_scene == nullptr) return false;
  RTCPointQuery point = queryAroundCube(center, half_side);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  bool is_near = false;
  rtcPointQuery(impl_->light_scene, &point, &context, findSky, &is_near);
  return is_near;
}

void RayScene::trianglesNearCube(const glm::vec3& center, float half_side, std::vector<uint32_t>* triangles) const {
  triangles->clear();
  RTCPointQuery point = queryAroundCube(center, half_side);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &point, &context, collectTriangle, triangles);
  std::sort(triangles->begin(), triangles->end());
}

const std::vector<glm::vec3>& RayScene::positions() const { return impl_->positions; }
const std::vector<glm::uvec3>& RayScene::triangles() const { return impl_->triangles; }

}  // namespace nlg
