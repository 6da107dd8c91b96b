// Scenes made of a few faces, and the functions of their probes: what the cases of geometry are measured on.
#pragma once

#include <string>
#include <vector>

#include "datagen/dataset/shard.h"
#include "datagen/probes/probe_placement.h"
#include "datagen/weighting/weighting_builder.h"
#include "scene/scene.h"

namespace nlg {

// Faces in world coordinates, metres.
class FaceScene {
 public:
  enum class Sides : uint32_t { one = 0, two = 1 };  // also the material's index

  // Front side: where a, b, c run counter-clockwise.
  void addTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, Sides sides = Sides::one);
  void addQuad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, Sides sides = Sides::one);
  // A closed solid whose faces look outward; a flipped one's look inward.
  void addBox(const glm::dvec3& low, const glm::dvec3& high, bool flipped = false);
  // All triangles of another scene, where they stand in the world.
  void add(const Scene& scene);

  std::vector<glm::dvec3>& positions() { return positions_; }  // three a triangle
  std::vector<uint32_t>& materials() { return materials_; }    // one a triangle
  size_t triangleCount() const { return materials_.size(); }

  // The scene as a reader of files would give it.
  Scene finish() const;

 private:
  std::vector<glm::dvec3> positions_;
  std::vector<uint32_t> materials_;
};

// A room of 4 x 3 x 4 m with walls of 20 cm, a pillar, and a low wall in it.
FaceScene furnishedRoom();

// The links between support points, made once a process.
const LinkTable& stabilityLinks();

const char* outcomeName(ProbeOutcome outcome);

// What the probes of a scene gave, in one order.
struct ProbeFunctions {
  std::vector<ProbeOutcome> outcomes;
  FunctionRows functions;    // quantised; one row for every outcome `function`
  uint64_t broken = 0;       // functions with a value that is not in [0, 1], or not 0 at an invalid point
  uint64_t disputed = 0;     // functions whose votes about solid were disputed
  uint64_t probe_count = 0;  // of the whole tree

  uint64_t count(ProbeOutcome outcome) const;
};

// The functions of up to max_probes probes of a scene, drawn from all by a fixed seed.
ProbeFunctions probeFunctions(const Scene& scene, const ProbePlacementOptions& options, uint64_t max_probes);
// … of probes at these places, relative to the scene's origin.
ProbeFunctions functionsAt(const Scene& scene, const std::vector<glm::dvec3>& positions_m, float spacing_m);

// How far two runs over the same probes are apart.
struct FunctionDifference {
  bool same_outcomes = false;
  int largest_bytes = 0;        // of phi, 1/255
  uint64_t points = 0;          // compared
  uint64_t points_apart = 0;    // of these differ by more than one byte
  uint64_t validity_apart = 0;  // … in validity
  bool same_bits() const { return same_outcomes && largest_bytes == 0 && validity_apart == 0; }
};
FunctionDifference difference(const ProbeFunctions& a, const ProbeFunctions& b);

}  // namespace nlg
