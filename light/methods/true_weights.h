// What the probes around a place should weigh there: target φ itself, not what stands for it.
#pragma once

#include <array>
#include <vector>

#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/light_grid/probe_tree.h"

namespace nlg {

inline constexpr int kCornerCount = 8;
using CornerWeights = std::array<float, kCornerCount>;

// Of one place, by corner as ProbesAround has them; none normalised.
struct TrueWeights {
  std::array<uint32_t, kCornerCount> probe{};
  CornerWeights target{};  // target φ, by the formula at this very place, times tent_ratio; 0 for a probe in solid without an eye
  CornerWeights seen{};    // the cell's tent where the probe's eye sees the place (solid_eye.h), 0 otherwise
  std::array<bool, kCornerCount> is_seen{};
};

// The function of every probe that a place reads is generated once.
// positions_m, rays, links, tree   in the scene's coordinates
// returns                          by position
std::vector<TrueWeights> trueWeights(const std::vector<glm::dvec3>& positions_m, const ProbeTree& tree, const RayScene& rays,
                                     const LinkTable& links, const DiffusionOptions& diffusion, int thread_count);

}  // namespace nlg
