#include "datagen/weighting/weighting_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nlg {
namespace {

// What a point without weight receives in one pass from the neighbours that it sees (docs/theory/math.md §1).
struct Gathering {
  double open = 0.0, lit = 0.0, weighted = 0.0;
  void addOpen(float gaussian) { open += gaussian; }
  void addLit(float gaussian, float phi) {
    lit += gaussian;
    weighted += gaussian * phi;
  }
  float phi(double falloff) const { return static_cast<float>(weighted / lit * std::min(1.0, falloff * lit / open)); }
};

float gaussianAt(float distance, double sigma) {
  return static_cast<float>(std::exp(-0.5 / (sigma * sigma) * distance * distance));
}

}  // namespace

WeightingBuilder::WeightingBuilder(const RayScene& scene, const LinkTable& links, const DiffusionOptions& options)
    : table_(links), options_(options), visibility_(scene, links), eye_finder_(scene, links), lit_(links.points.size()) {
  tent_.reserve(links.points.size());
  for (const LocalPoint& point : links.points) tent_.push_back(tent(point));
  gaussian_.reserve(links.distance.size());
  for (const float distance : links.distance) gaussian_.push_back(gaussianAt(distance, options.sigma));
}

ProbeOutcome WeightingBuilder::build(const glm::dvec3& position_m, float spacing_m, GeneratedFunction* result, InSolid in_solid) {
  const ProbeOutcome outcome = see(position_m, spacing_m, in_solid);
  return outcome == ProbeOutcome::function ? generate(result) : outcome;
}

ProbeOutcome WeightingBuilder::see(const glm::dvec3& position_m, float spacing_m, InSolid in_solid) {
  const std::optional<ProbeOutcome> settled = begin(position_m, spacing_m, in_solid);
  return settled ? *settled : look();
}

std::optional<ProbeOutcome> WeightingBuilder::begin(const glm::dvec3& position_m, float spacing_m, InSolid in_solid,
                                                    ProbeEyes* eyes) {
  has_neighbours_ = false;
  probe_vote_ = eyes == nullptr ? visibility_.voteAt(position_m)
                                : eyes->sightOf(eyes->latticeOf(position_m), eyes->unitsOf(spacing_m), &eye_finder_).vote;
  if (probe_vote_.solid() && in_solid == InSolid::left_out) return ProbeOutcome::in_solid;
  visibility_.beginProbe(position_m, spacing_m);
  // without triangles all is as the probe is: there is no eye
  if (visibility_.supportIsEmpty()) return probe_vote_.solid() ? ProbeOutcome::in_solid : ProbeOutcome::free_space;
  if (eyes == nullptr) return std::nullopt;
  neighbours_ = neighbourEyes(position_m, spacing_m, eyes, &eye_finder_);
  has_neighbours_ = true;
  return std::nullopt;
}

ProbeOutcome WeightingBuilder::look() {
  if (has_neighbours_) {
    const std::optional<LocalPoint>& own = neighbours_[neighbours_.size() / 2];
    if (!own) return ProbeOutcome::in_solid;
    visibility_.traceRays(*own);
  } else if (!probe_vote_.solid()) {
    visibility_.traceProbeRays();
  } else if (!solid_eye_.open(&visibility_)) {
    return ProbeOutcome::in_solid;
  }
  visibility_.testLinks();
  open_shell_ = visibility_.findValidity() || probe_vote_.disputed();
  return ProbeOutcome::function;
}

ProbeOutcome WeightingBuilder::generate(GeneratedFunction* result) {
  result->open_shell = open_shell_;
  result->in_solid = probe_vote_.solid();
  lightSeenPoints(result);
  for (int pass = 1; pass <= options_.passes; ++pass) diffuse(pass, result);
  const bool empty =
      std::all_of(result->phi.begin(), result->phi.begin() + kSupportPointCount, [](float w) { return w == 0.0f; });
  return empty ? ProbeOutcome::empty : ProbeOutcome::function;
}

void WeightingBuilder::sumBlend(const GeneratedFunction& function, uint8_t* sums) {
  blend_sum_.compute(visibility_.triangles(), neighbours_, function.phi.data(), sums);
}

// Gives the tent to what the probe sees; lists the valid points that wait for weight.
void WeightingBuilder::lightSeenPoints(GeneratedFunction* result) {
  result->phi = tent_;
  result->valid.assign(tent_.size(), 1);
  result->seen.assign(tent_.size(), 1);
  std::fill(lit_.begin(), lit_.end(), uint8_t{1});
  waiting_.clear();
  for (const uint32_t point : visibility_.dark()) {
    result->phi[point] = 0.0f;
    result->seen[point] = 0;
    result->valid[point] = visibility_.valid(point);
    lit_[point] = 0;
    if (result->valid[point]) waiting_.push_back(point);
  }
}

// One pass: every valid point without weight gathers from its nearest points that are lit before this pass.
void WeightingBuilder::diffuse(int pass, GeneratedFunction* result) {
  const auto litBefore = [&](uint32_t point) { return isLitBefore(pass, point); };
  std::erase_if(waiting_, [&](uint32_t point) {
    const LinkTable::Edge* nearest = &table_.nearest[size_t(point) * kLinkCount];
    if (std::none_of(nearest, nearest + kLinkCount, [&](const LinkTable::Edge& edge) { return litBefore(edge.point); }))
      return false;
    const float* gaussian = &gaussian_[size_t(point) * kLinkCount];
    Gathering gathering;
    for (int k = 0; k < kLinkCount; ++k) {
      const LinkTable::Edge& edge = nearest[k];
      if (!result->valid[edge.point] || !visibility_.linkOpen(edge.link)) continue;
      gathering.addOpen(gaussian[k]);
      if (litBefore(edge.point)) gathering.addLit(gaussian[k], result->phi[edge.point]);
    }
    if (gathering.lit == 0.0) return false;
    result->phi[point] = gathering.phi(options_.falloff);
    lit_[point] = static_cast<uint8_t>(pass + 1);
    return true;
  });
}

float WeightingBuilder::valueAt(const LocalPoint& place, const GeneratedFunction& function) const {
  if (sees(place)) return tent(place);
  const NearestPoints nearest = nearestSupportPoints(place);
  std::array<bool, kLinkCount> open;
  for (int k = 0; k < kLinkCount; ++k)
    open[k] = function.valid[nearest.point[k]] && visibility_.isOpen(table_.points[nearest.point[k]], place);
  for (int pass = 1; pass <= options_.passes; ++pass) {
    Gathering gathering;
    for (int k = 0; k < kLinkCount; ++k) {
      if (!open[k]) continue;
      const uint32_t point = nearest.point[k];
      const float gaussian = gaussianAt(nearest.distance[k], options_.sigma);
      gathering.addOpen(gaussian);
      if (isLitBefore(pass, point)) gathering.addLit(gaussian, function.phi[point]);
    }
    if (gathering.lit > 0.0) return gathering.phi(options_.falloff);
  }
  return 0.0f;
}

}  // namespace nlg
