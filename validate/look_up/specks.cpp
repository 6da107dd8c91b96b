#include "validate/look_up/specks.h"

#include <algorithm>

#include "light/air.h"
#include "runtime_eval/light_grid/irradiance.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kBlock = 65536;  // places of one stream

class SpeckSearch {
 public:
  SpeckSearch(const LightGrid& grid, const ProbeTree& tree, const glm::dvec3& origin_m, const RayScene& rays)
      : grid_(grid), tree_(tree), origin_m_(origin_m), rays_(rays) {}

  // returns   false where no cell is
  bool ask(const glm::dvec3& at, Specks* found, size_t most_listed) const {
    const PositionM world = {origin_m_.x + at.x, origin_m_.y + at.y, origin_m_.z + at.z};
    ProbeWeights weights, tents;
    if (!lookUpWeights(grid_, world, &weights) || !lookUpTents(grid_, world, &tents)) return false;
    float of_seen = 0.0f, of_any = 0.0f;
    int seen_by = 0;
    for (int i = 0; i < tents.count; ++i) {
      const float share = shareOf(weights, tents.probe[i]) / tents.weight[i];
      of_any = std::max(of_any, share);
      if ((share < kSpeckShare && tents.weight[i] < kSpeckLeastTent) || !sees(tents.probe[i], at)) continue;
      if (share >= kSpeckShare) return true;
      ++seen_by;
      of_seen = std::max(of_seen, share);
    }
    const float largest = seen_by > 0 ? of_seen : of_any;
    if (largest >= kSpeckShare) return true;
    ProbeWeights shares;
    if (lookUpShares(grid_, world, &shares) != LightStatus::lit || !isInAir(rays_, at)) return true;
    ++found->count;
    if (found->first.size() < most_listed) found->first.push_back({at, largest, seen_by});
    return true;
  }

 private:
  static float shareOf(const ProbeWeights& weights, uint32_t probe) {
    const uint32_t* end = weights.probe + weights.count;
    const uint32_t* at = std::find(weights.probe, end, probe);
    return at != end ? weights.weight[at - weights.probe] : 0.0f;
  }

  bool sees(uint32_t probe, const glm::dvec3& at) const {
    const PositionM p = tree_.probePosition(probe);
    return !rays_.isBlocked(glm::vec3(glm::dvec3(p[0], p[1], p[2])), glm::vec3(at));
  }

  const LightGrid& grid_;
  const ProbeTree& tree_;
  const glm::dvec3 origin_m_;
  const RayScene& rays_;
};

}  // namespace

Specks findSpecks(const LightGrid& grid, const ProbeTree& tree, const glm::dvec3& origin_m, const RayScene& rays,
                  const ExtentBox& extent, const SpeckOptions& options) {
  const SpeckSearch search(grid, tree, origin_m, rays);
  std::vector<Specks> of_block((options.places + kBlock - 1) / kBlock);
  parallelFor(of_block.size(), options.threads, [&](uint64_t block, int) {
    Random random(mixSeed(options.seed, block));
    Specks& found = of_block[block];
    const uint64_t count = std::min(kBlock, options.places - block * kBlock);
    for (uint64_t i = 0; i < count; ++i) {
      glm::dvec3 at;
      for (int axis = 0; axis < 3; ++axis) at[axis] = random.uniform(extent.low_m[axis], extent.high_m[axis]);
      found.looked_up += search.ask(at, &found, options.most_listed);
    }
  });
  Specks all;
  for (const Specks& found : of_block) {
    all.looked_up += found.looked_up;
    all.count += found.count;
    for (const Speck& speck : found.first) {
      if (all.first.size() < options.most_listed) all.first.push_back(speck);
    }
  }
  return all;
}

}  // namespace nlg
