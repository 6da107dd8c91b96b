// A sky that is an image: radiance by direction, equirectangular.
//
// Rows go from the zenith down. The middle of the image looks along +x, and what stands right of it lies towards +z, as three.js and
// Blender (through its glTF exporter) have it. Radiance is constant over a texel.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

struct Sun;

inline constexpr int kMostSkyColumns = 1024;  // a texel is .35 degrees wide: less than the sun
inline constexpr int kMostSkyRows = 512;

struct SkyImage {
  int width = 0, height = 0;      // 1 … kMostSkyColumns and 1 … kMostSkyRows; 0 each: no image
  std::vector<glm::vec3> texels;  // width x height radiances, >= 0

  bool empty() const { return texels.empty(); }
  // Of any direction but 0.
  const glm::vec3& radiance(const glm::vec3& direction) const;
  // Of one texel of a row, steradians.
  double solidAngle(int row) const;
};

// Where on an image a direction lies, and the reverse. column, row   in shares of its width and height, 0 … 1 from the upper left
glm::vec2 skyPlace(const glm::vec3& direction);
glm::vec3 skyDirection(double column, double row);

struct Sky;
// A sky of that image, with the gradient that is nearest to it.
Sky skyOfImage(SkyImage image);

// The sun of an image: what stands out of a patch of 2.5 degrees around the brightest texel, when that is a twentieth or more of
// all light of the image. The patch is left as bright as what surrounds it.
// returns   nothing, and the image stays, where no patch is so bright
std::optional<Sun> takeSun(SkyImage* image);

// Makes a sky image of the rows of a larger one: every texel is the mean over its solid angle, so that no light is lost.
class SkyReduction {
 public:
  // width, height   of the source, >= 1
  // turn            in whole turns: by how much the image is turned from +x towards +z
  SkyReduction(int width, int height, double turn);
  // row   of the source, each once, in any order; rgb   3 x width numbers. What is no radiance (negative, above 1e12, NaN) is 0.
  void addRow(int row, const float* rgb);
  SkyImage finish() const;
  // Numbers that were no radiance.
  size_t mended() const { return mended_; }

 private:
  const int width_, height_;
  const double turn_;
  SkyImage image_;
  std::vector<glm::dvec3> sums_;  // by texel
  std::vector<glm::dvec3> line_;  // a row of the source, in columns of the image
  size_t mended_ = 0;
};

}  // namespace nlg
