// Connected components of triangles, and how nearly each is a closed surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/scene.h"

namespace nlg {

// For every vertex the first one with the same position, bit for bit: exporters split vertices by normals and places on images.
std::vector<uint32_t> weldedVertices(const std::vector<glm::vec3>& positions);

struct Components {
  std::vector<uint32_t> of_triangle;  // numbered by their first triangles
  uint32_t count = 0;
};

struct Shell {
  double area_m2 = 0.0;
  // Between the faces and the middle of its box. Of a closed shell: above 0 where it is wound outward, below 0 inward.
  double volume_m3 = 0.0;
  double edge_length_m = 0.0;  // of all edges of all triangles
  double open_length_m = 0.0;  // of those that no edge of the other direction cancels; exactly 0 for a shell without open edges
  double hole_area_m2 = 0.0;   // of what open edges go round; nearly 0 where vertices of one side lie on an edge of the other
  glm::dvec3 low{0.0}, high{0.0};
};

// Finds components and measures them, of any number of sets of triangles over the same vertices.
class ShellFinder {
 public:
  // same_as   V; by vertex the one that stands for all that are the same: weldedVertices
  explicit ShellFinder(std::vector<uint32_t> same_as);

  // Triangles that share a vertex are of one component. Other sets have no say.
  Components components(std::span<const glm::uvec3> triangles);

  // By component. Position is glm::vec3 or glm::dvec3.
  template <class Position>
  std::vector<Shell> measure(const std::vector<Position>& positions, std::span<const glm::uvec3> triangles,
                             const Components& components);

 private:
  uint32_t rootOf(uint32_t vertex);
  void join(uint32_t a, uint32_t b);
  // The number of a vertex's component, counted up when it is new.
  uint32_t numberOf(uint32_t vertex, uint32_t* count);
  // Every vertex by itself again.
  void release(uint32_t vertex);

  std::vector<uint32_t> same_as_, parent_, number_;
};

// Splits every object into its connected components: triangles that share a vertex position bit for bit. Triangle order within
// a component stays. A component whose largest side exceeds structure_share of the scene's largest side becomes not movable.
// An object that is not movable already stays whole.
void splitConnectedComponents(Scene& scene, double structure_share);

// Finds what can be moved without opening a level's shell: splits an object into its connected components and leaves movable only those that stand free: what looks outward round more
// than half of its box (a crate without the bottom that stands on the floor, a column between floor and ceiling), or all round
// whatever its shape is, and is not larger than 12 m. Walls, rooms, trims and terrain become structure. The other objects stay as
// they are, behind it.
//
// object_idx   below scene.objects.size()
void splitFreeStanding(Scene& scene, size_t object_idx);

}  // namespace nlg
