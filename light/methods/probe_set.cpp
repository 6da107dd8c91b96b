#include "light/methods/probe_set.h"

#include "light/air.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"

namespace nlg {

ProbeSet makeProbeSet(const ProbeTree& tree, const LightTransport& transport, const ProbeSetOptions& options) {
  ProbeSet set;
  set.tree = tree;
  const size_t count = tree.probeCount();
  set.spacing_m.resize(count);
  set.is_in_air.resize(count);
  set.light.resize(count);
  for (size_t p = 0; p < count; ++p) {
    const PositionM at = tree.probePosition(p);
    set.position_m.emplace_back(at[0], at[1], at[2]);
    set.spacing_m[p] = tree.probeSpacing(p);
  }
  const double start = processorSeconds();
  parallelFor(count, options.thread_count, [&](uint64_t p, int) {
    set.is_in_air[p] = isInAir(transport.rays(), set.position_m[p]);
    set.light[p] = transport.gather(set.position_m[p], options.gather, mixSeed(options.seed, p)).light;
  });
  set.gather_s = processorSeconds() - start;
  for (const uint8_t in_air : set.is_in_air) set.air_count += in_air;
  return set;
}

glm::dvec3 placeInCell(const ProbeTree& tree, const ProbeCell& cell, const glm::dvec3& position_m) {
  glm::dvec3 share;
  for (int axis = 0; axis < 3; ++axis) {
    const double units = (position_m[axis] - tree.frame().first_m[axis]) / tree.frame().spacing_m;
    share[axis] = glm::clamp((units - cell.low[axis]) / cell.side, 0.0, 1.0);
  }
  return share;
}

}  // namespace nlg
