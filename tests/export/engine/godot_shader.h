// light.gdshaderinc as C++: the few types and functions of Godot's shading language that it uses.
#pragma once

#include <algorithm>
#include <array>

#include "export/engine/texture_3d.h"
#include "runtime_eval/light_grid/resampled_light.h"

namespace nlg {
namespace godot {

struct vec3 {
  double x = 0, y = 0, z = 0;
  vec3(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  explicit vec3(double all) : vec3(all, all, all) {}
};
struct vec4 {
  double x = 0, y = 0, z = 0, w = 0;
};
template <class Function>
vec3 each(const vec3& a, const vec3& b, const Function& of) {
  return {of(a.x, b.x), of(a.y, b.y), of(a.z, b.z)};
}
inline vec3 operator-(const vec3& a, const vec3& b) {
  return each(a, b, [](double p, double q) { return p - q; });
}
inline vec3 operator/(const vec3& a, const vec3& b) {
  return each(a, b, [](double p, double q) { return p / q; });
}
inline vec3 operator-(double a, const vec3& b) { return vec3(a) - b; }
inline vec3 operator/(double a, const vec3& b) { return vec3(a) / b; }
inline vec3 operator*(double a, const vec3& b) { return {a * b.x, a * b.y, a * b.z}; }
inline vec3& operator+=(vec3& a, const vec3& b) { return a = {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline vec3 max(const vec3& a, const vec3& b) {
  return each(a, b, [](double p, double q) { return std::max(p, q); });
}
inline vec3 clamp(const vec3& a, const vec3& low, const vec3& high) {
  return max(low, each(a, high, [](double p, double q) { return std::min(p, q); }));
}
inline vec4 textureLod(const Texture3d* texture, const vec3& uvw, double) {
  const Rgba four = sampleLinear(*texture, {uvw.x, uvw.y, uvw.z});
  return {four[0], four[1], four[2], four[3]};
}

// what the exporter writes before the function
inline const Texture3d* nlg_light = nullptr;
inline vec3 NLG_LOW_M(0.0), NLG_HIGH_M(0.0), NLG_RESOLUTION(0.0);

inline
#include "export/engine/light.gdshaderinc"

}  // namespace godot

inline std::array<double, 3> godotShaderIrradiance(const Texture3d& texture, const LightBox& box, const PositionM& position_m,
                                                   const std::array<float, 3>& normal) {
  const auto three = [](const auto& of) {
    return godot::vec3(static_cast<double>(of[0]), static_cast<double>(of[1]), static_cast<double>(of[2]));
  };
  godot::nlg_light = &texture;
  godot::NLG_LOW_M = three(box.low_m), godot::NLG_HIGH_M = three(box.high_m), godot::NLG_RESOLUTION = three(box.texel_count);
  const godot::vec3 rgb = godot::nlg_irradiance(three(position_m), three(normal));
  return {rgb.x, rgb.y, rgb.z};
}

}  // namespace nlg
