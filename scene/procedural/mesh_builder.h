// Builds the triangles of procedural scenes: closed solids with outward faces, named objects, materials.
//
// Every position is rounded to 1/1024 m, which is exact in float and hides the last bits of any rotation. Shapes share no
// vertices with each other; within one shape every edge belongs to as many faces in one direction as in the other.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/model/rotation.h"
#include "scene/model/scene.h"

namespace nlg {

// The nearest multiple of a fraction of a metre.
inline double snapped(double metres, double per_metre) { return std::floor(metres * per_metre + 0.5) / per_metre; }
inline constexpr double kVerticesPerMetre = 1024.0;

enum class Mobility { structure, movable };
enum class Axis { vertical, along_x };  // where a shape's own y axis points before the turn

// Where a shape stands: its axis is laid down or not, then turned about the vertical, then shifted.
struct Placement {
  glm::dvec3 position{0.0};
  Turn turn;
  Axis axis = Axis::vertical;

  glm::dvec3 apply(const glm::dvec3& local) const;
};

class MeshBuilder {
 public:
  uint32_t addMaterial(const Material& material);
  // Triangles that follow belong to this object.
  void beginObject(const std::string& name, Mobility mobility);

  uint32_t addVertex(const Placement& placement, const glm::dvec3& local);
  // Counter-clockwise from outside. A triangle that names a vertex twice is left out, so that quads may close to triangles.
  void addTriangle(uint32_t a, uint32_t b, uint32_t c, uint32_t material);
  void addQuad(uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint32_t material);

  // The scene so far, without objects that stayed empty; leaves the builder empty.
  Scene finish(const std::string& id);

 private:
  void closeObject();

  Scene scene_;
};

// A solid between a lower and an upper line over x, extruded along z: ramps, gables, arches, vaults.
struct ProfilePoint {
  double x = 0.0, low = 0.0, high = 0.0;
};
// profile   two points or more, x rising, low <= high; equal only at the ends, where the solid then closes to an edge
void addProfile(MeshBuilder& mesh, const Placement& placement, const std::vector<ProfilePoint>& profile, double z_min,
                double z_max, uint32_t material);

// A solid of revolution about y with flat sides: columns, barrels, pipes, cones.
struct Ring {
  double y = 0.0, radius = 0.0;
};
// rings   two or more from bottom to top, y rising or equal, radii above zero; the last may be zero (a tip)
void addLathe(MeshBuilder& mesh, const Placement& placement, const std::vector<Ring>& rings, int side_count, uint32_t material);

// An axis-aligned box in the placement's frame.
void addBox(MeshBuilder& mesh, const Placement& placement, const glm::dvec3& min, const glm::dvec3& max, uint32_t material);

// A boulder: a sphere of 320 triangles, radii in metres along its axes, dented by noise of this seed by up to a third.
void addRock(MeshBuilder& mesh, const Placement& placement, const glm::dvec3& radii_m, uint64_t seed, uint32_t material);

// A block of ground whose top follows the heights, with sides and a flat bottom.
struct Heightfield {
  int x_count = 0, z_count = 0;  // points, two or more each way
  double spacing_m = 1.0;        // the placement's position is the first point's
  double base_m = 0.0;           // height of the bottom, below every point
  std::vector<double> height_m;  // x_count * z_count, x fastest
};
void addHeightfield(MeshBuilder& mesh, const Placement& placement, const Heightfield& field, uint32_t material);

}  // namespace nlg
