#include "light/baked_light.h"

#include <algorithm>

namespace nlg {
namespace {

// The lower of the two texels around a place, and how far the place is on the way to the other.
void splitPlace(float place, int side, int* low, float* share) {
  const float texel = std::clamp(place * static_cast<float>(side) - 0.5f, 0.0f, static_cast<float>(side - 1));
  *low = std::min(static_cast<int>(texel), side - 2);
  *share = texel - static_cast<float>(*low);
}

}  // namespace

glm::vec3 bakedLight(const Scene& scene, uint32_t triangle, float u, float v) {
  const BakedLight& baked = scene.light.baked;
  const glm::uvec3& t = scene.triangles[triangle];
  const float w = 1.0f - u - v;
  const int32_t page = baked.triangle_page[triangle];
  if (page == BakedLight::kByVertex)
    return baked.vertex_light[t.x] * w + baked.vertex_light[t.y] * u + baked.vertex_light[t.z] * v;
  const glm::vec2 place = baked.vertex_place[t.x] * w + baked.vertex_place[t.y] * u + baked.vertex_place[t.z] * v;
  const int side = baked.page_side;
  int x, y;
  float sx, sy;
  splitPlace(place.x, side, &x, &sx);
  splitPlace(place.y, side, &y, &sy);
  const glm::vec3* row = &baked.texels[static_cast<size_t>(page) * side * side] + static_cast<size_t>(y) * side + x;
  return (row[0] * (1.0f - sx) + row[1] * sx) * (1.0f - sy) + (row[side] * (1.0f - sx) + row[side + 1] * sx) * sy;
}

}  // namespace nlg
