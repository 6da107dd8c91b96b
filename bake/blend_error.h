// Errors of a grid's blends against its target functions, from both sides: holes, where probes are missing, and leaks, from
// probes that must have no weight. Formulas: docs/theory/errors.md.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake/prepared_scene.h"

namespace nlg {

// Sample points of a scene, with the target weights of the 8 probes around each.
//
// Points are in air: in cells that hold some, where a known place in air of the cell sees them. A probe's *target weight* is its tent
// (with its tent_ratio) where its eye sees the point, by a ray; elsewhere what diffusion brought there, as a share of the tent: the
// mean over those of the 4 nearest samples of its function that are valid and see the point. Samples are those of its octant.

// Distances between which points before surfaces are classed, metres.
inline constexpr std::array<double, 4> kBlendBordersM = {0.0, 0.02, 0.08, 0.2};
inline constexpr size_t kBlendClassCount =
    kBlendBordersM.size();  // 0: uniform in air; c: from border c - 1 to c before a surface
// Most that are drawn: as many of each class before surfaces as of the others, before points drawn by area, on either side.
inline constexpr uint64_t kBlendAirPoints = 2000, kBlendSurfacePoints = 4000;

struct BlendPoint {
  size_t blend_class = 0;
  glm::dvec3 position_m{0.0};  // world
  ProbesAround around;
  std::array<float, 8> target{};  // by corner: 0 until its probe is said to have a weight
};

class BlendTargets {
 public:
  // The same points for any number of threads. scene   must outlive it
  BlendTargets(const PreparedScene& scene, uint64_t seed, int thread_count);

  // Of a probe that has a weight; of each once, and any thread may say it.
  // eye       in its support, local coordinates
  // samples   asked for where the eye misses a point, and good until the call ends; null of free space, where it misses none
  void setTargets(uint64_t probe, const LocalPoint& eye, const std::function<StoredFunction()>& samples);

  const std::vector<BlendPoint>& points() const { return points_; }

 private:
  struct Corner {
    uint32_t point;
    uint8_t corner;
  };

  float diffusedShare(const StoredFunction& function, const ProbeAround& at, const glm::dvec3& position) const;

  const PreparedScene& scene_;
  std::vector<BlendPoint> points_;
  std::vector<uint64_t> first_corner_;  // by probe, into corners_; one more
  std::vector<Corner> corners_;
};

// Over the points of a class whose target weights add up to something. All 0 where there are none.
struct BlendFigures {
  uint64_t points = 0;
  double holes = 0.0;            // share of points: next to no weight, though target weights are there
  double leaks = 0.0;            // share of points: probes without a target weight hold more than a fifth of the light
  double total_variation = 0.0;  // [0, 1], mean: between the probes' shares and those of the target weights

  bool operator==(const BlendFigures&) const = default;
};

using BlendErrors = std::array<BlendFigures, kBlendClassCount>;

// targets   of all probes
// grid      of the same scene, in the world's coordinates
BlendErrors blendErrors(const BlendTargets& targets, const LightGrid& grid);

// Keys: docs/reference/bake_json.md.
nlohmann::ordered_json toJson(const BlendErrors& errors);

}  // namespace nlg
