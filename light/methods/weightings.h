// Weights of the 8 probes around a point: by target φ, trilinear, and by the light grid.
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "datagen/visibility/ray_scene.h"
#include "datagen/weighting/weighting_builder.h"
#include "light/methods/light_method.h"
#include "light/probe_light.h"
#include "nlg/look_up.h"

namespace nlg {

// What the probes around a place should weigh there: target φ itself, not what stands for it.
inline constexpr int kCornerCount = 8;

// Of one place, by corner as ProbesAround has them; none normalised.
struct TrueWeights {
  std::array<uint32_t, kCornerCount> probe{};
  // target φ, by the formula at this very place, times tent_ratio; 0 for a probe in solid without an eye
  std::array<float, kCornerCount> target{};
};

// The function of every probe that a place reads is generated once.
// positions_m, rays, tree   in the scene's coordinates
// returns                   by position
std::vector<TrueWeights> trueWeights(const std::vector<glm::dvec3>& positions_m, const ProbeTree& tree, const RayScene& rays,
                                     const DiffusionOptions& diffusion, int thread_count);

// Trilinear blends: of all probes, of those in air, of those that see the place.
enum class TrilinearKind {
  all,      // whatever the probe stands in
  valid,    // probes in air; places around which none is are unlit
  visible,  // probes in air that the place sees, by a ray each: what no stored form does better with these shares. Where it sees
            // none, those in air
};

class Trilinear : public Weighting {
 public:
  // Both must outlive this object.
  Trilinear(TrilinearKind kind, const ProbeSet& probes, const RayScene& rays) : kind_(kind), probes_(probes), rays_(rays) {}
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  const TrilinearKind kind_;
  const ProbeSet& probes_;
  const RayScene& rays_;
};

// Blends by target φ itself, at places that are known beforehand: what functions would give if they were stored without error.
class TargetFunctions : public Weighting {
 public:
  // Makes the function of every probe that a place reads.
  // places   relative to the scene's origin; blendAt knows these and no others
  TargetFunctions(const std::vector<glm::dvec3>& places, const ProbeSet& probes, const RayScene& rays,
                  const DiffusionOptions& diffusion, int thread_count);
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  struct PlaceHash {
    size_t operator()(const glm::dvec3& place) const;
  };
  std::unordered_map<glm::dvec3, ProbeBlend, PlaceHash> blends_;
};

// What our own light grid's look-up gives (nlg/look_up.h): shares, the weights that a bake solves with, and light.
class GridWeighting : public Weighting {
 public:
  // grid   in the world's coordinates, positions relative to the scene's origin; must outlive this object
  GridWeighting(const LightGrid& grid, const glm::dvec3& origin_m)
      : grid_(grid), origin_m_(origin_m), weights_of_grid_(weightsOf(grid, origin_m)) {}
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;
  ProbeWeights weightsAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  const LightGrid& grid_;
  const glm::dvec3 origin_m_;
  const WeightsAt weights_of_grid_;
};

// A light grid's look-up. Where its weights know nothing, its light decides who answers.
// grid       that holds light, in the world's coordinates; must outlive the result
// origin_m   the scene's
LightAt gridLight(const LightGrid& grid, const glm::dvec3& origin_m);

}  // namespace nlg
