// Learns where light comes from, from place to place, and draws directions by it: under a bright sky half as many rays give the same
// noise.
//
// The sphere is cut into bins of equal solid angle. Half of the rays are spread evenly; the others go to bins by the root mean
// square of the radiance that was met there, which gives sums of radiance the least variance. A place does not learn from its own
// rays, so that what it measures has no bias.
#pragma once

#include <array>
#include <cstddef>

#include <glm/glm.hpp>

namespace nlg {

class DirectionGuide {
 public:
  // Draws evenly.
  DirectionGuide();

  struct Drawn {
    glm::vec3 direction;
    float density;  // of drawing it, per steradian
    size_t bin;
  };
  // Evenly spread points give directions that are evenly spread within bins and over them. u, v   in [0, 1)
  Drawn draw(double u, double v) const;
  // Of drawing a direction, per steradian.
  float density(const glm::vec3& direction) const;

  // What a ray of this bin met. radiance   luminance, >= 0
  void learn(size_t bin, float radiance);
  // Ends a place: the next one is drawn by all that was learnt.
  void endPlace();

 private:
  static constexpr size_t kRows = 8, kColumns = 16, kBins = kRows * kColumns;  // sphereDirection's u and v
  using Bins = std::array<float, kBins>;

  void share(const Bins& radiance);

  Bins squares_{}, counts_{};              // of the radiance that rays met, and of these rays; they fade from place to place
  Bins share_;                             // of all rays
  std::array<float, kRows + 1> row_ends_;  // running sums of the rows' shares
  std::array<std::array<float, kColumns + 1>, kRows> column_ends_;  // by row: of its bins, over the row's share
};

}  // namespace nlg
