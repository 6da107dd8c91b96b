// Scenes of a few faces, for the cases of geometry.
#pragma once

#include <vector>

#include "datagen/weighting/weighting_builder.h"
#include "scene/model/scene.h"

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
  std::vector<glm::dvec3>& positions() { return positions_; }  // three a triangle

  // The scene as a reader of files would give it.
  Scene finish() const;

 private:
  std::vector<glm::dvec3> positions_;
  std::vector<uint32_t> materials_;
};

}  // namespace nlg
