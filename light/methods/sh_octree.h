// Spherical harmonics in an octree with cells from 4 m to 25 cm, blended trilinearly inside each cell: a grid without
// weighting functions, with its probes where light needs them.
//
// Cells begin at 4 m. Those whose held-out places are farthest from what was measured there, by bytes that it would take, are divided;
// where that did not help cells of 1 m and less, it is taken back. Borders of levels are left as they are: a probe there is a probe of the finer cells alone.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "light/methods/light_method.h"
#include "light/probe_light.h"

namespace nlg {

inline constexpr double kOctreeFinestM = 0.25;
inline constexpr int kOctreeCoarsestLog2 = 4;  // of a cell's side, in units of the finest: 4 m

struct ShOctreeOptions {
  std::vector<size_t> byte_budgets;               // rising; a tree each, as large as it comes without much more
  std::function<size_t(const ProbeTree&)> bytes;  // of a tree with its probes' light
  ProbeLightOptions solve;                        // of the trees' light
  int rounds_per_budget = 6;                      // of refinement, at most
  int thread_count = 1;
  uint64_t seed = 1;
};

struct ShOctree {
  size_t byte_budget = 0;
  ProbeTree tree;              // in the scene's coordinates
  std::vector<LightSh> light;  // by probe
  double bake_s = 0.0;         // of the processor, that of smaller trees included
};

// places   in air, relative to the scene's origin, with their light; a half of them is held out while the tree grows, and light is
//          solved for with all of them. At least one
// returns  a tree for each budget but those that cells of 4 m alone go beyond and those that nothing is left to divide for. The same
//          for any number of threads
std::vector<ShOctree> growShOctrees(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                    const std::vector<LightSh>& light, const ShOctreeOptions& options);

// What a blend in its cells answers. The octree's tree must outlive it.
class ShOctreeWeighting : public Weighting {
 public:
  explicit ShOctreeWeighting(const ProbeTree& tree) : tree_(tree) {}
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  const ProbeTree& tree_;
};

}  // namespace nlg
