#include "validate/look_up/look_up_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/evaluator/brick_quads.h"
#include "runtime_eval/evaluator/evaluate_point.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "validate/errors/statistics.h"

namespace nlg {
namespace {

// Half the sum of |differences|, the share of nobody's light included.
double difference(const Blend& a, const Blend& b) {
  double sum = 0.0, nobody = 0.0;
  for (int c = 0; c < kCornerCount; ++c) {
    sum += std::abs(a.share[c] - b.share[c]);
    nobody += a.share[c] - b.share[c];
  }
  return 0.5 * (sum + std::abs(nobody));
}

double squaredDifference(const Blend& a, const Blend& b) {
  double sum = 0.0;
  for (int c = 0; c < kCornerCount; ++c) sum += (a.share[c] - b.share[c]) * (a.share[c] - b.share[c]);
  return sum / kCornerCount;
}

// Values that count differently often.
class WeightedValues {
 public:
  void add(double value, double weight) {
    values_.push_back({value, weight});
    sum_ += value * weight;
    weight_sum_ += weight;
  }
  double mean() const { return weight_sum_ > 0.0 ? sum_ / weight_sum_ : 0.0; }
  // The least value that no more than 1 - share of all weight is above.
  double quantile(double share) {
    std::sort(values_.begin(), values_.end());
    double below = 0.0;
    for (const auto& [value, weight] : values_) {
      below += weight;
      if (below >= share * weight_sum_) return value;
    }
    return values_.empty() ? 0.0 : values_.back().first;
  }

 private:
  std::vector<std::pair<double, double>> values_;
  double sum_ = 0.0, weight_sum_ = 0.0;
};

struct Totals {
  uint64_t places = 0;
  WeightedValues unlit, unlit_target, seen_by_none, squares, wrong, wrong_to_seen, leak;

  void add(const Blend& blend, const TrueWeights& truth, double weight) {
    const Blend target = blendOf(truth.target), seen = blendOf(truth.seen);
    ++places;
    unlit.add(!blend.is_lit, weight);
    unlit_target.add(!target.is_lit, weight);
    seen_by_none.add(!seen.is_lit, weight);
    if (target.is_lit) {
      squares.add(squaredDifference(blend, target), weight);
      wrong.add(difference(blend, target), weight);
    }
    if (seen.is_lit) wrong_to_seen.add(difference(blend, seen), weight);
    if (!blend.is_lit) return;
    double from_occluded = 0.0;
    for (int c = 0; c < kCornerCount; ++c) from_occluded += truth.is_seen[c] ? 0.0 : blend.share[c];
    leak.add(from_occluded, weight);
  }

  LookUpFigures figures() {
    return {places,       unlit.mean(),         unlit_target.mean(),  seen_by_none.mean(), std::sqrt(squares.mean()),
            wrong.mean(), wrong.quantile(0.99), wrong_to_seen.mean(), leak.mean(),         leak.quantile(0.99)};
  }
};

// Of two look-ups that may read other cells: by probe.
double differenceByProbe(ProbeWeights a, ProbeWeights b) {
  double sum = std::abs((normaliseWeights(&a) ? double{a.certainty} : 0.0) - (normaliseWeights(&b) ? double{b.certainty} : 0.0));
  for (int i = 0; i < a.count; ++i) {
    const uint32_t* found = std::find(b.probe, b.probe + b.count, a.probe[i]);
    const bool in_both = found != b.probe + b.count;
    sum += std::abs(double{a.weight[i]} - (in_both ? double{b.weight[found - b.probe]} : 0.0));
  }
  for (int i = 0; i < b.count; ++i) {
    if (std::find(a.probe, a.probe + a.count, b.probe[i]) == a.probe + a.count) sum += double{b.weight[i]};
  }
  return 0.5 * sum;
}

}  // namespace

Blend blendOf(const CornerWeights& weights) {
  Blend blend;
  double sum = 0.0;
  for (int c = 0; c < kCornerCount; ++c) {
    if (weights[c] >= kLeastWeight) sum += blend.share[c] = double{weights[c]};
  }
  blend.is_lit = sum > 0.0;
  for (double& share : blend.share) share = blend.is_lit ? share / sum : 0.0;
  return blend;
}

LookUp lookUpOf(const LightGrid& grid, const glm::dvec3& origin_m) {
  return [&grid, origin_m](const glm::dvec3& position_m, ProbeWeights* weights) {
    const glm::dvec3 world = origin_m + position_m;
    return lookUpWeights(grid, {world.x, world.y, world.z}, weights);
  };
}

std::vector<Blend> blendsOf(const LookUp& look_up, const std::vector<Place>& places, const std::vector<TrueWeights>& truth) {
  std::vector<Blend> blends(places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    ProbeWeights weights;
    if (!look_up(places[i].position_m, &weights)) continue;
    blends[i].is_lit = normaliseWeights(&weights);
    for (int k = 0; k < weights.count; ++k) {
      const auto corner = std::find(truth[i].probe.begin(), truth[i].probe.end(), weights.probe[k]) - truth[i].probe.begin();
      NLG_CHECK(corner, <, kCornerCount);
      blends[i].share[corner] = double{weights.weight[k]};
    }
  }
  return blends;
}

LookUpFiguresByDistance figuresOf(const std::vector<Blend>& blends, const Places& places, const std::vector<TrueWeights>& truth) {
  Totals all;
  std::array<Totals, kDistanceClassCount> of_class;
  for (size_t i = 0; i < blends.size(); ++i) {
    const uint8_t distance_class = places.places[i].distance_class;
    all.add(blends[i], truth[i], places.weight(distance_class));
    of_class[distance_class].add(blends[i], truth[i], 1.0);
  }
  LookUpFiguresByDistance figures;
  figures.all = all.figures();
  for (size_t c = 0; c < kDistanceClassCount; ++c) figures.by_class[c] = of_class[c].figures();
  return figures;
}

std::vector<Blend> targetBlends(const std::vector<TrueWeights>& truth) {
  std::vector<Blend> blends;
  for (const TrueWeights& weights : truth) blends.push_back(blendOf(weights.target));
  return blends;
}

JumpFigures measureJumps(const std::vector<Place>& places, const ProbeTree& tree, const RayScene& rays, const LookUp& look_up,
                         uint64_t seed) {
  JumpFigures figures;
  Random random(seed);
  std::vector<double> jumps;
  const ProbeTreeFrame& frame = tree.frame();
  const auto around = [&](const glm::dvec3& at, ProbesAround* found) { return tree.lookUp({at.x, at.y, at.z}, found); };
  for (const Place& place : places) {
    const int axis = static_cast<int>(random.below(3));
    const bool upper = random.chance(0.5);
    ProbesAround here, before_face, behind_face;
    if (!around(place.position_m, &here)) continue;
    const double side_m = frame.spacing_m * here.cell.side;
    const double face_m = frame.first_m[axis] + frame.spacing_m * (here.cell.low[axis] + (upper ? here.cell.side : 0));
    const double step_m = (upper ? 0x1p-20 : -0x1p-20) * side_m;
    glm::dvec3 before = place.position_m, behind = place.position_m;
    before[axis] = face_m - step_m;
    behind[axis] = face_m + step_m;
    if (!around(before, &before_face) || !around(behind, &behind_face)) continue;
    if (rays.isBlocked(glm::vec3(place.position_m), glm::vec3(behind))) continue;
    if (behind_face.cell.side != before_face.cell.side) {
      ++figures.hanging;
      continue;
    }
    ProbeWeights a, b;
    if (!look_up(before, &a) || !look_up(behind, &b)) continue;
    jumps.push_back(differenceByProbe(a, b));
  }
  const Quantiles q = quantiles(std::move(jumps));
  figures.segments = q.count;
  figures.mean = q.mean;
  figures.p99 = q.p99;
  figures.largest = q.worst;
  return figures;
}

BorderFigures measureBorder(const LightGrid& grid) {
  constexpr int kPoints = 96;
  std::vector<LocalPoint> points = testPoints(kPoints);
  for (int i = 0; i < kPoints; ++i) points[i][i % 3] = i / 3 % 2 == 0 ? -1.0f : 1.0f;
  std::vector<double> values;
  for (size_t function = 0; function < grid.functionCount(); ++function) {
    const Representation& representation = grid.representations[grid.function_representation[function]];
    for (const LocalPoint& point : points) {
      const double phi = representation.isCode()
                             ? tent(point) * evaluateQuads(representation.resolution, point, grid.function_brick[function].step,
                                                           grid.functionQuads(function))
                             : evaluatePoint(representation, point, grid.functionTheta(function));
      values.push_back(std::clamp(phi, 0.0, 1.0));
    }
  }
  const Quantiles q = quantiles(std::move(values));
  return {grid.functionCount(), q.mean, q.p99, q.worst};
}

}  // namespace nlg
