// The points at which small scenes are solved: the same pattern in every cell between eight probes, less what is in solid.
//
// Because the pattern repeats, its points are at the same local coordinates for every probe: as "test points" of one LinkTable
// they get generated functions too, so that solved and generated ones are compared at the same places.
#pragma once

#include <array>

#include "datagen/visibility/ray_scene.h"
#include "runtime_eval/support/support_pattern.h"
#include "validate/solved/small_scenes.h"

namespace nlg {

// test: no solve sees it; slice: on the plane of the pictures; probe: where a probe stands
enum class PointUse : uint8_t { fit, test, slice, probe };

inline constexpr int kCornerCount = 8;        // probes around a point; bit 0, 1, 2 of a corner: on the upper side in x, y, z
inline constexpr int kSlicePixelsACell = 16;  // along each side

struct SampleOptions {
  int fit_points = 96;  // a cell
  int test_points = 48;
};

struct SamplePoints {
  // of one cell, coordinates in [0, 1), in lengths of the spacing
  std::vector<LocalPoint> cell_points;
  std::vector<PointUse> cell_use;

  // N points in air with at least one probe around them
  std::vector<glm::vec3> position_m;
  std::vector<PointUse> use;
  std::vector<uint32_t> cell_point;                           // which of cell_points each of them is
  std::vector<std::array<int, kCornerCount>> probe;           // the probes around it; -1: that one stands in solid
  std::vector<glm::vec3> probe_position_m;                    // of the probes in air
  std::vector<std::array<float, kCornerCount>> tent() const;  // the bare tent of each probe, 0 for -1

  size_t count() const { return position_m.size(); }
};

SamplePoints makeSamplePoints(const SmallScene& small, const SampleOptions& options);

// All local coordinates that cell points have for the probes around them: entry 8 c + corner is cell point c as the probe of
// that corner sees it.
std::vector<LocalPoint> localPoints(const SamplePoints& points);

// Pairs of near points that see each other.
struct PointLinks {
  struct Link {
    uint32_t a, b;  // a < b
    float distance_m;
  };
  std::vector<Link> links;
  std::vector<uint32_t> first;  // N + 1: links of point i are of[first[i]] … of[first[i + 1] - 1]
  std::vector<uint32_t> of;     // indices into links
  uint32_t other(uint32_t link, uint32_t point) const { return links[link].a == point ? links[link].b : links[link].a; }
};

// Each point with its 16 nearest among those off the slice, and each slice point with its 8 nearest on the slice.
PointLinks linkPoints(const RayScene& rays, const SamplePoints& points);

// Which of the segments from a[i] to b[i] meet nothing.
std::vector<uint8_t> seeEachOther(const RayScene& rays, const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b);

}  // namespace nlg
