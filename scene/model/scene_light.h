// Light of a scene beside emissive materials: lamps, suns, sky, and baked light.
//
// Radiance is linear and in one unit of the scene's own for all of these: glTF's are cd/m², a Quake III level's are 1 for a white
// surface that the engine shows at full brightness (docs/theory/light.md). Positions are relative to the scene's origin.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/sky_image.h"

namespace nlg {

// Luminance of linear red, green and blue by ITU-R BT.709.
inline float luminance(const glm::vec3& rgb) { return 0.2126f * rgb.r + 0.7152f * rgb.g + 0.0722f * rgb.b; }

// The largest radiance, intensity or factor that a file or an option may name: products of a few stay far inside a float.
inline constexpr double kBrightest = 1e12;

inline bool isBright(const glm::vec3& rgb) { return rgb.r > 0.0f || rgb.g > 0.0f || rgb.b > 0.0f; }

// Radiance from beyond everything: a gradient from the horizon (y = 0) up to the zenith, and one colour for what lies below; or an
// image. The gradient is then the one that is nearest to it, for whoever draws no image.
struct Sky {
  glm::vec3 zenith{0.0f}, horizon{0.0f}, ground{0.0f};  // >= 0
  SkyImage image = {};

  bool shines() const { return isBright(zenith) || isBright(horizon) || isBright(ground); }
  glm::vec3 radiance(const glm::vec3& direction) const {
    if (!image.empty()) return image.radiance(direction);
    if (direction.y < 0.0f) return ground;
    return horizon + (zenith - horizon) * direction.y;
  }
};

// A small sphere that shines; rays never meet it. A spot when cos_outer > -1: full inside the inner cone, nothing outside the
// outer one, as KHR_lights_punctual has it.
struct Lamp {
  glm::vec3 position{0.0f};
  glm::vec3 intensity{0.0f};                   // radiant intensity along the axis: irradiance is intensity / distance²
  float radius_m = 0.1f;                       // > 0
  glm::vec3 direction{0.0f, -1.0f, 0.0f};      // unit: where a spot points
  float cos_inner = -1.0f, cos_outer = -1.0f;  // cos_outer <= cos_inner; -1 for a lamp that shines all round
};

struct Sun {
  glm::vec3 to_sun{0.0f, 1.0f, 0.0f};  // unit
  glm::vec3 irradiance{0.0f};          // on a plane that faces it
  float angular_radius = 0.00465f;     // radians: half a degree across
};

// Light that the level's own compiler left on its surfaces: what leaves a surface is this times its material's base colour, and
// all bounces are in it. Empty when the scene has none: then light is traced.
struct BakedLight {
  static constexpr int32_t kByVertex = -1;
  int32_t page_side = 0;                // texels
  std::vector<glm::vec3> texels;        // all pages, page_side² each, rows from the top
  std::vector<int32_t> triangle_page;   // by triangle: its page, or kByVertex
  std::vector<glm::vec2> vertex_place;  // by vertex: on the page, [0, 1]², x along a row
  std::vector<glm::vec3> vertex_light;  // by vertex, for kByVertex
  glm::vec3 ambient{0.0f};              // what of it comes from nowhere: the compiler added it everywhere

  bool empty() const { return triangle_page.empty(); }
};

// Triangles of sky: they shine with the sky's radiance on their front, and nothing meets them from behind. They are no geometry
// of the scene's: no weighting function knows them, but they end rays of light and lie inside the scene's bounds. Behind them
// stand faces that are no geometry either and shine by themselves: lava, flames.
struct SkyFaces {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<glm::vec3> shine;  // radiance of the last shine.size() triangles; all before them are sky

  // Whether a triangle shines by itself.
  bool shines(uint32_t triangle) const { return triangle + shine.size() >= triangles.size(); }
  // What comes along a ray that meets a triangle's front.
  glm::vec3 radiance(uint32_t triangle, const glm::vec3& direction, const Sky& sky) const {
    return shines(triangle) ? shine[triangle + shine.size() - triangles.size()] : sky.radiance(direction);
  }
};

// What a file calls a light, and the group that its author puts it in; empty where nothing says.
struct LightLabel {
  std::string name, group;
};

// Light is linear: what each group gives by itself adds up to the whole (light_groups.h).
struct LightGroups {
  std::vector<std::string> names;                     // at most kMaxLightGroups (light_grid.h); none: all light is one group
  std::vector<uint8_t> of_lamp, of_sun, of_material;  // by lamp, sun, material of the scene; empty where all light is one
  uint8_t of_sky = 0, of_shine = 0, of_baked = 0;     // shine: what stands behind the faces of a sky

  size_t count() const { return names.empty() ? 1 : names.size(); }
  bool areMany() const { return !of_material.empty(); }
  static uint8_t of(const std::vector<uint8_t>& groups, size_t index) { return groups.empty() ? 0 : groups[index]; }
};

// Who wrote the file that a scene's light is of.
enum class LightWriter : uint8_t { other, gltf, blender };

// What lamps and suns of a file are beside its emission, and by what sign that is known. Blender's glTF exporter multiplies them by 683
// and divides lamps by 4 pi, or leaves out the first, or both; emission it leaves as it is. Engines in which a sun of 1 shows white at
// full brightness write theirs over pi (light_options.h).
struct LightUnit {
  enum class Kind : uint8_t {
    same,
    standard,  // Blender's
    raw,       // Blender's
    over_pi,   // of an engine that multiplies by pi
    unsure,    // of a program that may write another, which the file does not say
  } kind = Kind::same;
  std::string sign;  // empty: nothing had to be chosen
};

struct SceneLight {
  LightWriter writer = LightWriter::other;
  LightUnit unit;
  Sky sky;
  std::vector<Lamp> lamps;
  std::vector<Sun> suns;
  std::vector<LightLabel> lamp_labels, sun_labels;  // by lamp and sun; or empty: nothing is known of them
  LightGroups groups;
  SkyFaces sky_faces;
  BakedLight baked;
};

}  // namespace nlg
