#include "bake/blend_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "nlg/look_up.h"
#include "tool/printable.h"

namespace nlg {
namespace {

constexpr float kNoTarget = 0.005f;  // sum of target weights: at the rim of what anybody sees shares are noise
constexpr float kHoleTarget = 0.05f, kHoleWeight = 0.02f;  // sums of target weights, and of the look-up's
constexpr float kLeakTarget = 0.001f, kLeakShare = 0.2f;   // of single probes; of all such together

void addPoint(const BlendPoint& point, const LightGrid& grid, BlendFigures* figures) {
  const float targets = std::accumulate(point.target.begin(), point.target.end(), 0.0f);
  ProbeWeights weights;
  if (targets <= kNoTarget || !lookUpWeights(grid, {point.position_m.x, point.position_m.y, point.position_m.z}, &weights))
    return;
  const float sum = std::accumulate(weights.weight, weights.weight + weights.count, 0.0f);
  const double certainty = weights.count > 0 ? double{weights.certainty} : 0.0;
  // what the certainty leaves out is light of no target
  double astray = 0.0, difference = 1.0 - certainty;
  for (int c = 0; c < 8; ++c) {
    double share = 0.0;
    for (int i = 0; i < weights.count; ++i) {
      if (weights.probe[i] == point.around.corners[c].probe) share = certainty * double{weights.weight[i]} / double{sum};
    }
    if (point.target[c] < kLeakTarget) astray += share;
    difference += std::abs(share - double{point.target[c]} / double{targets});
  }
  ++figures->points;
  figures->holes += targets > kHoleTarget && sum < kHoleWeight;
  figures->leaks += astray > kLeakShare;
  figures->total_variation += 0.5 * difference;
}

nlohmann::ordered_json figuresJson(const BlendFigures& figures) {
  return {{"points", figures.points},
          {"holes", figures.holes},
          {"leaks", figures.leaks},
          {"total_variation", figures.total_variation}};
}

}  // namespace

BlendErrors blendErrors(const BlendTargets& targets, const LightGrid& grid) {
  BlendErrors errors;
  for (const BlendPoint& point : targets.points()) addPoint(point, grid, &errors[point.blend_class]);
  for (BlendFigures& figures : errors) {
    for (double* mean : {&figures.holes, &figures.leaks, &figures.total_variation})
      *mean /= std::max(1.0, static_cast<double>(figures.points));
  }
  return errors;
}

nlohmann::ordered_json toJson(const BlendErrors& errors) {
  nlohmann::ordered_json json = {{"air", figuresJson(errors[0])}, {"surface", nlohmann::ordered_json::array()}};
  for (size_t c = 1; c < errors.size(); ++c) {
    json["surface"].push_back({{"from_m", kBlendBordersM[c - 1]}, {"to_m", kBlendBordersM[c]}});
    json["surface"].back().update(figuresJson(errors[c]));
  }
  return json;
}

std::string toText(const BlendErrors& errors) {
  uint64_t points = 0;
  std::vector<std::string> classes, holes, leaks, total_variation;
  for (size_t c = 1; c < errors.size(); ++c) {
    points += errors[c].points;
    classes.push_back(fmt::format("{:g}", 100.0 * kBlendBordersM[c]));
    holes.push_back(fmt::format("{:.2f}", 100.0 * errors[c].holes));
    leaks.push_back(fmt::format("{:.2f}", 100.0 * errors[c].leaks));
    total_variation.push_back(fmt::format("{:.2f}", 100.0 * errors[c].total_variation));
  }
  return fmt::format(
      "blends at {} in air: holes {:.2f} %, leaks {:.2f} %, total variation of shares {:.2f} %\n"
      "blends at {} up to {} cm before surfaces: holes {} %, leaks {} %, total variation of shares {} %\n",
      countText(errors[0].points, "point"), 100.0 * errors[0].holes, 100.0 * errors[0].leaks, 100.0 * errors[0].total_variation,
      countText(points, "point"), fmt::join(classes, ", "), fmt::join(holes, ", "), fmt::join(leaks, ", "),
      fmt::join(total_variation, ", "));
}

}  // namespace nlg
