#include "light/methods/true_weights.h"

#include <algorithm>
#include <memory>

#include "tool/parallel_for.h"

namespace nlg {
namespace {

// One corner of one place, as its probe sees it.
struct Reading {
  uint32_t probe, place;
  int corner;
  ProbeAround around;
};

std::vector<Reading> readingsByProbe(const std::vector<glm::dvec3>& positions_m, const ProbeTree& tree) {
  std::vector<Reading> readings;
  readings.reserve(positions_m.size() * kCornerCount);
  for (uint32_t i = 0; i < positions_m.size(); ++i) {
    const glm::dvec3& at = positions_m[i];
    ProbesAround around;
    if (!tree.lookUp({at.x, at.y, at.z}, &around)) continue;
    for (int c = 0; c < kCornerCount; ++c) readings.push_back({around.corners[c].probe, i, c, around.corners[c]});
  }
  std::stable_sort(readings.begin(), readings.end(), [](const Reading& a, const Reading& b) { return a.probe < b.probe; });
  return readings;
}

class ProbeReader {
 public:
  ProbeReader(const ProbeTree& tree, const RayScene& rays, const LinkTable& links, const DiffusionOptions& diffusion)
      : tree_(tree), builder_(rays, links, diffusion) {}

  // Everything that places read of one probe.
  void read(const Reading* begin, const Reading* end, std::vector<TrueWeights>& weights) {
    const auto [x, y, z] = tree_.probePosition(begin->probe);
    const ProbeOutcome outcome = builder_.build({x, y, z}, tree_.probeSpacing(begin->probe), &function_, InSolid::by_eye);
    for (const Reading* reading = begin; reading != end; ++reading) {
      const ProbeAround& around = reading->around;
      TrueWeights& place = weights[reading->place];
      place.probe[reading->corner] = reading->probe;
      if (outcome == ProbeOutcome::in_solid) continue;
      const bool is_free = outcome == ProbeOutcome::free_space;
      const bool is_seen = is_free || builder_.sees(around.local);
      const float phi = is_free ? tent(around.local) : builder_.valueAt(around.local, function_);
      place.target[reading->corner] = phi * around.tent_ratio;
      place.seen[reading->corner] = is_seen ? tent(around.local) * around.tent_ratio : 0.0f;
      place.is_seen[reading->corner] = is_seen;
    }
  }

 private:
  const ProbeTree& tree_;
  WeightingBuilder builder_;
  GeneratedFunction function_;
};

}  // namespace

std::vector<TrueWeights> trueWeights(const std::vector<glm::dvec3>& positions_m, const ProbeTree& tree, const RayScene& rays,
                                     const LinkTable& links, const DiffusionOptions& diffusion, int thread_count) {
  const std::vector<Reading> readings = readingsByProbe(positions_m, tree);
  std::vector<size_t> first;  // of each probe, into readings
  for (size_t i = 0; i < readings.size(); ++i) {
    if (i == 0 || readings[i].probe != readings[i - 1].probe) first.push_back(i);
  }
  first.push_back(readings.size());
  std::vector<std::unique_ptr<ProbeReader>> readers;
  for (int t = 0; t < thread_count; ++t) readers.push_back(std::make_unique<ProbeReader>(tree, rays, links, diffusion));
  std::vector<TrueWeights> weights(positions_m.size());
  // probes of one place run on several threads: each writes corners of its own
  parallelFor(first.size() - 1, thread_count, [&](uint64_t p, int thread) {
    readers[thread]->read(readings.data() + first[p], readings.data() + first[p + 1], weights);
  });
  return weights;
}

}  // namespace nlg
