#include "validate/solved/diffusion_rule.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"

namespace nlg {
namespace {

float distanceToProbe(const LocalPoint& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

ProbeView viewProbe(const RayScene& rays, const LinkTable& links, WeightingBuilder& builder, const glm::vec3& position_m) {
  ProbeView view;
  GeneratedFunction function;
  const ProbeOutcome outcome = builder.build(position_m, 1.0f, &function);
  NLG_CHECK(static_cast<int>(outcome), !=, static_cast<int>(ProbeOutcome::in_solid));
  view.free_space = outcome == ProbeOutcome::free_space;
  if (view.free_space) return view;
  view.seen = function.seen;
  view.valid = function.valid;
  const auto world = [&](uint32_t point) {
    const LocalPoint& local = links.points[point];
    return position_m + glm::vec3(local[0], local[1], local[2]);
  };
  std::vector<glm::vec3> a, b;
  for (const LinkTable::Link& link : links.links) a.push_back(world(link.a)), b.push_back(world(link.b));
  const std::vector<uint8_t> link_open = seeEachOther(rays, a, b);
  view.open.resize(links.nearest.size());
  for (size_t e = 0; e < view.open.size(); ++e) {
    const size_t point = e / kLinkCount;
    view.open[e] = link_open[links.nearest[e].link] && view.valid[point] && view.valid[links.nearest[e].point];
  }
  return view;
}

// One probe's diffusion under one rule.
class Diffusion {
 public:
  Diffusion(const LinkTable& links, const ProbeView& view, const DiffusionRule& rule)
      : links_(links), view_(view), rule_(rule), phi_(links.points.size()), lit_(view.seen), path_(phi_.size()) {
    for (size_t p = 0; p < phi_.size(); ++p) {
      if (!lit_[p]) continue;
      phi_[p] = tent(links.points[p]);
      path_[p] = distanceToProbe(links.points[p]);
    }
  }

  // One pass; reads only what stood before it.
  void pass() {
    std::vector<uint32_t> received;
    std::vector<float> phi, path;
    for (uint32_t p = 0; p < phi_.size(); ++p) {
      if (lit_[p] || !view_.valid[p] || !gather(p)) continue;
      received.push_back(p);
      phi.push_back(received_phi_);
      path.push_back(received_path_);
    }
    for (size_t i = 0; i < received.size(); ++i) {
      lit_[received[i]] = 1;
      phi_[received[i]] = phi[i];
      path_[received[i]] = path[i];
    }
  }

  std::vector<float> take() { return std::move(phi_); }

 private:
  bool gather(uint32_t p) {
    const float tent_here = tent(links_.points[p]);
    double lit_sum = 0.0, open_sum = 0.0, weighted = 0.0;
    float shortest = std::numeric_limits<float>::infinity();
    for (size_t e = size_t(p) * kLinkCount; e < size_t(p + 1) * kLinkCount; ++e) {
      if (!view_.open[e]) continue;
      const uint32_t other = links_.nearest[e].point;
      const double ratio = links_.distance[e] / rule_.sigma, gaussian = std::exp(-0.5 * ratio * ratio);
      open_sum += gaussian;
      if (!lit_[other]) continue;
      lit_sum += gaussian;
      const float tent_there = rule_.carry == Carry::share ? tent(links_.points[other]) : 1.0f;
      weighted += gaussian * phi_[other] / tent_there;
      shortest = std::min(shortest, path_[other] + links_.distance[e]);
    }
    if (!(lit_sum > 0.0)) return false;
    const double falloff = std::min(1.0, rule_.falloff * lit_sum / open_sum);
    received_path_ = shortest;
    if (rule_.carry == Carry::path) {
      received_phi_ = tent_here * static_cast<float>(std::pow(distanceToProbe(links_.points[p]) / shortest, rule_.path_power));
    } else {
      received_phi_ = static_cast<float>(weighted / lit_sum * falloff) * (rule_.carry == Carry::share ? tent_here : 1.0f);
    }
    return true;
  }

  const LinkTable& links_;
  const ProbeView& view_;
  const DiffusionRule& rule_;
  std::vector<float> phi_;
  std::vector<uint8_t> lit_;
  std::vector<float> path_;  // shortest way from the probe that has been found, local units
  float received_phi_ = 0.0f, received_path_ = 0.0f;
};

}  // namespace

std::vector<ProbeView> viewProbes(const RayScene& rays, const LinkTable& links, const SamplePoints& points) {
  WeightingBuilder builder(rays, links, {0, 0.1});
  std::vector<ProbeView> views;
  for (const glm::vec3& position : points.probe_position_m) views.push_back(viewProbe(rays, links, builder, position));
  return views;
}

std::vector<float> generate(const LinkTable& links, const ProbeView& view, const DiffusionRule& rule) {
  if (view.free_space || rule.baseline == Baseline::bare_tent) {
    std::vector<float> phi;
    for (const LocalPoint& point : links.points) phi.push_back(tent(point));
    return phi;
  }
  Diffusion diffusion(links, view, rule);
  const int passes = rule.baseline == Baseline::visible_tent ? 0 : rule.passes;
  for (int pass = 0; pass < passes; ++pass) diffusion.pass();
  return diffusion.take();
}

BlendWeights generateWeights(const LinkTable& links, const std::vector<ProbeView>& views, const SamplePoints& points,
                             const DiffusionRule& rule) {
  std::vector<std::vector<float>> phi;
  for (const ProbeView& view : views) phi.push_back(generate(links, view, rule));
  BlendWeights weights(points.count());
  for (size_t i = 0; i < points.count(); ++i) {
    for (int corner = 0; corner < kCornerCount; ++corner) {
      const int probe = points.probe[i][corner];
      if (probe >= 0) weights[i][corner] = phi[probe][kSupportPointCount + points.cell_point[i] * kCornerCount + corner];
    }
  }
  return weights;
}

}  // namespace nlg
