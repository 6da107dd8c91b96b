// A scene: triangles in metres, and the objects that jitter may move.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/scene_light.h"
#include "scene/model/texture_image.h"

namespace nlg {

// Metres from a file's origin; beyond, a double no longer holds a tenth of a micrometre.
inline constexpr double kFarthestM = 1e9;

// Whether light passes through a surface: a fence of a cut-out image, a curtain, a pane. For weighting functions and for what lies
// in solid a thin one is air, a dense one a sheet as any other (docs/theory/visibility.md). For rays of light both are what their
// images say at the point.
enum class Transmissive : uint8_t { none, thin, dense };

struct Material {
  glm::vec3 base_color{0.5f};  // linear, 0..1; times base_image and the vertices' colours (surface_look.h)
  glm::vec3 emissive{0.0f};    // radiance of its front (of both sides when double_sided), linear, >= 0; times emissive_image
  bool double_sided = false;   // faces of it are no evidence of solid: see docs/theory/visibility.md
  Transmissive transmissive = Transmissive::none;  // what is transmissive is double_sided, too
  float opacity = 1.0f;       // what does not go straight through, 0..1; times the alpha of base_image and of the vertices
  float transmission = 0.0f;  // what goes through of light that its opacity stops, in the base colour, 0..1; times the red of
                              // transmission_image
  TextureUse base_image, emissive_image, transmission_image;  // those of base and transmission lie at base_places
  LightLabel label;                                           // of what shines
};

// What jitter moves as one: a glTF node with a mesh, a connected component of one, or a part that the generator names.
// The triangles of an object are contiguous.
struct SceneObject {
  std::string name;
  uint32_t first_triangle = 0;
  uint32_t triangle_count = 0;
  bool movable = true;  // false: structure (ground, the level's shell), which jitter leaves where it is
};

// From where the scene's own authors look at it: a camera of a glTF file, a place where players of a Quake III level begin.
struct Viewpoint {
  std::string name;                                            // as the file has it
  glm::vec3 position{0.0f};                                    // relative to the scene's origin
  glm::vec3 forward{0.0f, 0.0f, -1.0f}, up{0.0f, 1.0f, 0.0f};  // unit, at a right angle
  float fov_y = 0.0f;  // radians from the lower to the upper edge; 0: no camera, only a place
};

// A box in world coordinates, metres.
struct ExtentBox {
  glm::dvec3 low_m{0.0}, high_m{0.0};
};

// Where the scene's author says how far apart probes are at most. 0: cells wholly in the box have none.
struct DensityBox {
  ExtentBox box;
  double spacing_m = 0.0;  // finite, >= 0
  std::string node;
};

// Right-handed, y up, metres. Front faces wind counter-clockwise; a mirrored node's faces have been turned to do so.
// Positions are relative to origin_m, which stands near the middle of the scene, so that a scene 100 km from the world's
// origin loses no precision: world position = origin_m + position.
struct Scene {
  std::string id;
  glm::dvec3 origin_m{0.0};
  std::vector<glm::vec3> positions;         // V, metres, finite
  std::vector<glm::uvec3> triangles;        // T, indices into positions
  std::vector<uint32_t> triangle_material;  // T, indices into materials
  std::vector<Material> materials;          // at least one when there are triangles
  std::vector<TextureImage> images;         // that materials name
  std::vector<glm::vec2> base_places;       // V, or empty where no material has a base_image: the vertices' places on it,
                                            // textures' own transforms done
  std::vector<glm::vec2> emissive_places;   // V, or empty where none has an emissive_image
  std::vector<glm::vec4> vertex_colours;    // V, or empty: linear red, green, blue, and opacity
  std::vector<SceneObject> objects;         // cover all triangles, in order, without gaps
  uint32_t dropped_triangle_count = 0;      // triangles of zero area that the source held
  SceneLight light;
  std::vector<Viewpoint> viewpoints;  // in the file's order
  double cavity_m = 0.0;              // hollows closed off from all air as wide as this are no air; 0: there are none (cavity.h)
  std::optional<ExtentBox> extent;    // where its author says that things move: a node nlg_extent of a glTF file
  std::vector<DensityBox> density;    // of nodes with an extra nlg_density, in the file's order
};

struct Bounds {
  glm::vec3 min{0.0f};
  glm::vec3 max{0.0f};
};

// Axis-aligned box around all vertices of an object, or of the scene with its sky's faces; zeros when there are none.
Bounds objectBounds(const Scene& scene, const SceneObject& object);
Bounds sceneBounds(const Scene& scene);
Bounds geometryBounds(const Scene& scene);  // without them

// Whether light comes from outside of a scene: a sky, suns, or a level's own light, which holds them.
bool hasLightFromOutside(const Scene& scene);

// SHA-256 of what weighting functions can depend on, as it was read from whatever files: positions, triangles, which of them are
// double-sided or let light through, faces of sky, objects, nlg_extent, nlg_density and the origin. Neither colours nor light count.
std::string sceneSha256(const Scene& scene);
// SHA-256 of what light can depend on: all of that, colours, emission and the scene's light.
std::string sceneLightSha256(const Scene& scene);
// The same where its lights were in these groups, or in none.
std::string sceneLightSha256(const Scene& scene, const LightGroups& groups);

// Ends the reading of a file: moves the origin to the middle of the positions, on whole metres, and drops triangles of zero area,
// counted in dropped_triangle_count, and objects that have no other. What the scene's light says of triangles stays in step with
// them here and above; places of its own are still to be moved to the origin (relativeTo).
//
// scene               all but origin and positions
// world_positions_m   V, finite
void finishScene(Scene& scene, const std::vector<glm::dvec3>& world_positions_m);

std::vector<glm::vec3> relativeTo(const glm::dvec3& origin_m, const std::vector<glm::dvec3>& world_positions_m);

}  // namespace nlg
