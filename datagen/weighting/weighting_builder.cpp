#include "datagen/weighting/weighting_builder.h"

#include <algorithm>
#include <cmath>

namespace nlg {

WeightingBuilder::WeightingBuilder(const RayScene& scene, const LinkTable& links, const DiffusionOptions& options)
    : table_(links), options_(options), visibility_(scene, links), lit_(links.points.size()) {
  gaussian_.reserve(links.distance.size());
  const double scale = -0.5 / (options.sigma * options.sigma);
  for (const float distance : links.distance) {
    gaussian_.push_back(static_cast<float>(std::exp(scale * distance * distance)));
  }
}

ProbeOutcome WeightingBuilder::build(const glm::vec3& position_m, float spacing_m, GeneratedFunction* result) {
  visibility_.beginProbe(position_m, spacing_m);
  const SolidVote probe_vote = visibility_.probeVote();
  if (probe_vote.solid()) return ProbeOutcome::in_solid;
  if (visibility_.supportIsEmpty()) return ProbeOutcome::free_space;
  visibility_.traceProbeRays();
  result->open_shell = visibility_.findValidity() || probe_vote.disputed();
  const size_t point_count = table_.points.size();
  result->phi.assign(point_count, 0.0f);
  result->valid.resize(point_count);
  result->seen.resize(point_count);
  for (uint32_t p = 0; p < point_count; ++p) {
    result->valid[p] = visibility_.valid(p);
    result->seen[p] = visibility_.seen(p);
    lit_[p] = visibility_.seen(p);
    if (lit_[p]) result->phi[p] = tent(table_.points[p]);
  }
  for (int pass = 1; pass <= options_.passes; ++pass) diffuse(pass, result);
  const bool empty =
      std::all_of(result->phi.begin(), result->phi.begin() + kSupportPointCount, [](float w) { return w == 0.0f; });
  return empty ? ProbeOutcome::empty : ProbeOutcome::function;
}

// One pass: every valid point without weight gathers from its nearest points that are lit before this pass. Two sweeps of tests:
// links to lit points, which decide who receives; then, for receivers only, links to the rest, which the falloff needs.
void WeightingBuilder::diffuse(int pass, GeneratedFunction* result) {
  const auto litBefore = [&](uint32_t point) { return lit_[point] != 0 && lit_[point] <= pass; };
  receivers_.clear();
  links_.clear();
  for (uint32_t p = 0; p < table_.points.size(); ++p) {
    if (!result->valid[p] || lit_[p]) continue;
    bool beside_light = false;
    for (int k = 0; k < kLinkCount; ++k) {
      const LinkTable::Edge& edge = table_.nearest[size_t(p) * kLinkCount + k];
      if (!litBefore(edge.point)) continue;
      beside_light = true;
      if (!visibility_.linkTested(edge.link)) links_.push_back(edge.link);
    }
    if (beside_light) receivers_.push_back(p);
  }
  visibility_.testLinks(links_);
  links_.clear();
  std::erase_if(receivers_, [&](uint32_t p) {
    const LinkTable::Edge* nearest = &table_.nearest[size_t(p) * kLinkCount];
    const bool receives = std::any_of(nearest, nearest + kLinkCount, [&](const LinkTable::Edge& edge) {
      return litBefore(edge.point) && visibility_.linkOpen(edge.link);
    });
    if (!receives) return true;
    for (int k = 0; k < kLinkCount; ++k) {
      if (result->valid[nearest[k].point] && !visibility_.linkTested(nearest[k].link)) links_.push_back(nearest[k].link);
    }
    return false;
  });
  visibility_.testLinks(links_);
  for (const uint32_t p : receivers_) {
    double weighted = 0.0, lit_sum = 0.0, open_sum = 0.0;
    for (int k = 0; k < kLinkCount; ++k) {
      const size_t entry = size_t(p) * kLinkCount + k;
      const LinkTable::Edge& edge = table_.nearest[entry];
      if (!result->valid[edge.point] || !visibility_.linkOpen(edge.link)) continue;
      open_sum += gaussian_[entry];
      if (!litBefore(edge.point)) continue;
      lit_sum += gaussian_[entry];
      weighted += gaussian_[entry] * result->phi[edge.point];
    }
    if (lit_sum > 0.0)
      result->phi[p] = static_cast<float>(weighted / lit_sum * std::min(1.0, options_.falloff * lit_sum / open_sum));
    lit_[p] = static_cast<uint8_t>(pass + 1);
  }
}

}  // namespace nlg
