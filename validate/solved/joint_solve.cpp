#include "validate/solved/joint_solve.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kSlopeFloor_m = 0.03f;  // nearer points count as if they were so far apart
constexpr float kCarryDeviation_m = 0.1f;
constexpr int kLanes = 8;

// For every corner of point a the corner of b that stands for the same probe.
std::array<int8_t, kCornerCount> sameProbes(const SamplePoints& points, uint32_t a, uint32_t b) {
  std::array<int8_t, kCornerCount> corner;
  for (int c = 0; c < kCornerCount; ++c) {
    corner[c] = -1;
    for (int8_t d = 0; d < kCornerCount; ++d) {
      if (points.probe[a][c] >= 0 && points.probe[a][c] == points.probe[b][d]) corner[c] = d;
    }
  }
  return corner;
}

// In lanes, which the compiler may turn into vectors without changing the sum's order.
float dot(const float* a, const float* b, int count) {
  float lanes[kLanes] = {};
  int s = 0;
  for (; s + kLanes <= count; s += kLanes) {
    for (int l = 0; l < kLanes; ++l) lanes[l] += a[s + l] * b[s + l];
  }
  float sum = 0.0f;
  for (; s < count; ++s) sum += a[s] * b[s];
  for (const float lane : lanes) sum += lane;
  return sum;
}

// Held-out points take the tent, corrected as their neighbours were.
void carryToHeldOut(const SamplePoints& points, const PointLinks& links, BlendWeights& weights) {
  const BlendWeights tent = normalised(points.tent());
  for (uint32_t i = 0; i < points.count(); ++i) {
    if (points.use[i] != PointUse::test) continue;
    std::array<double, kCornerCount> correction{};
    double total = 0.0;
    for (uint32_t e = links.first[i]; e < links.first[i + 1]; ++e) {
      const uint32_t other = links.other(links.of[e], i);
      if (points.use[other] == PointUse::test || points.use[other] == PointUse::probe) continue;
      const double ratio = links.links[links.of[e]].distance_m / kCarryDeviation_m, gaussian = std::exp(-0.5 * ratio * ratio);
      const std::array<int8_t, kCornerCount> same = sameProbes(points, i, other);
      for (int c = 0; c < kCornerCount; ++c) {
        if (same[c] >= 0) correction[c] += gaussian * (weights[other][same[c]] - tent[other][same[c]]);
      }
      total += gaussian;
    }
    for (int c = 0; c < kCornerCount; ++c) {
      const double corrected = tent[i][c] + (total > 0.0 ? correction[c] / total : 0.0);
      weights[i][c] = points.probe[i][c] >= 0 ? static_cast<float>(std::max(0.0, corrected)) : 0.0f;
    }
  }
  weights = normalised(weights);
}

}  // namespace

JointProblem::JointProblem(const SamplePoints& points, const PointLinks& links, const Signals& signals,
                           const SolveOptions& options)
    : points_(points), signals_(signals), counts_(pointsOf(points, {PointUse::fit, PointUse::slice})) {
  std::vector<int> degree(points.count());
  const auto isUsed = [&](const PointLinks::Link& link) { return counts_[link.a] > 0 && counts_[link.b] > 0; };
  for (const PointLinks::Link& link : links.links) {
    if (isUsed(link)) ++degree[link.a], ++degree[link.b];
  }
  for (const float count : counts_) used_count_ += count > 0;
  for (const PointLinks::Link& link : links.links) {
    if (!isUsed(link)) continue;
    const double distance = std::max(link.distance_m, kSlopeFloor_m);
    // three times the mean square of slopes in all directions is the squared gradient
    const double share = 3.0 * 0.5 * (1.0 / degree[link.a] + 1.0 / degree[link.b]) / (distance * distance);
    slopes_.push_back({link.a, link.b, static_cast<float>(options.smoothness * share / static_cast<double>(used_count_)),
                       sameProbes(points, link.a, link.b)});
  }
  const double anchor = options.anchor * static_cast<double>(used_count_) / static_cast<double>(points.probe_position_m.size());
  for (size_t i = 0; i < points.count(); ++i) {
    if (points.use[i] == PointUse::probe) counts_[i] = static_cast<float>(anchor);
  }
}

double JointProblem::addLight(const BlendWeights& w, const std::vector<float>& probes, BlendWeights* by_w,
                              std::vector<float>* by_probes) const {
  const int signal_count = signals_.count;
  const auto scale = static_cast<float>(1.0 / (static_cast<double>(used_count_) * signal_count));
  std::vector<float> residual(signal_count);
  double sum = 0.0;
  for (size_t i = 0; i < points_.count(); ++i) {
    if (counts_[i] == 0.0f) continue;
    blend(points_.probe[i], w[i], probes, signal_count, residual.data());
    const float* target = signals_.row(i);
    for (int s = 0; s < signal_count; ++s) residual[s] -= target[s];
    sum += double{counts_[i]} * dot(residual.data(), residual.data(), signal_count);
    for (float& r : residual) r *= counts_[i];
    for (int c = 0; c < kCornerCount; ++c) {
      if (points_.probe[i][c] < 0) continue;
      const size_t row = size_t(points_.probe[i][c]) * signal_count;
      if (by_w) (*by_w)[i][c] += 2.0f * scale * dot(residual.data(), &probes[row], signal_count);
      if (!by_probes || w[i][c] == 0.0f) continue;
      const float factor = 2.0f * scale * w[i][c];
      for (int s = 0; s < signal_count; ++s) (*by_probes)[row + s] += factor * residual[s];
    }
  }
  return sum * scale;
}

double JointProblem::addSlopes(const BlendWeights& w, BlendWeights* by_w) const {
  double sum = 0.0;
  for (const Slope& slope : slopes_) {
    std::array<float, kCornerCount> of_b = w[slope.b];  // what is left of it has no partner at a
    float squares = 0.0f;
    for (int c = 0; c < kCornerCount; ++c) {
      const int d = slope.corner[c];
      const float difference = w[slope.a][c] - (d >= 0 ? w[slope.b][d] : 0.0f);
      if (d >= 0) of_b[d] = 0.0f;
      squares += difference * difference;
      if (!by_w) continue;
      (*by_w)[slope.a][c] += 2.0f * slope.weight * difference;
      if (d >= 0) (*by_w)[slope.b][d] -= 2.0f * slope.weight * difference;
    }
    for (int d = 0; d < kCornerCount; ++d) {
      squares += of_b[d] * of_b[d];
      if (by_w) (*by_w)[slope.b][d] += 2.0f * slope.weight * of_b[d];
    }
    sum += slope.weight * squares;
  }
  return sum;
}

double JointProblem::evaluate(const BlendWeights& phi, const std::vector<float>& probes, BlendWeights* by_phi,
                              std::vector<float>* by_probes) const {
  const BlendWeights w = normalised(phi);
  if (by_phi) by_phi->assign(phi.size(), {});
  if (by_probes) by_probes->assign(probes.size(), 0.0f);
  const double value = addLight(w, probes, by_phi, by_probes) + addSlopes(w, by_phi);
  if (!by_phi) return value;
  // from w to φ: w_p = φ_p / Σ φ
  for (size_t i = 0; i < phi.size(); ++i) {
    if (points_.use[i] == PointUse::test || points_.use[i] == PointUse::probe) {
      (*by_phi)[i] = {};  // they do not move
      continue;
    }
    float sum = 0.0f, mean = 0.0f;
    for (int c = 0; c < kCornerCount; ++c) sum += phi[i][c], mean += w[i][c] * (*by_phi)[i][c];
    for (int c = 0; c < kCornerCount; ++c) {
      (*by_phi)[i][c] = points_.probe[i][c] >= 0 ? ((*by_phi)[i][c] - mean) / sum : 0.0f;
    }
  }
  return value;
}

std::vector<float> JointProblem::bestProbes(const BlendWeights& phi) const {
  return solveProbes(points_, normalised(phi), signals_, counts_);
}

SolvedFunctions solveFunctions(const SamplePoints& points, const PointLinks& links, const Signals& signals,
                               const SolveOptions& options) {
  constexpr double kMeanDecay = 0.9, kSquareDecay = 0.99, kPi = 3.141592653589793;
  const JointProblem problem(points, links, signals, options);
  const double per_point = static_cast<double>(points.count());  // gradients of the size of a point's own error
  SolvedFunctions solved;
  BlendWeights phi = normalised(points.tent()), gradient, mean(phi.size()), square(phi.size());
  for (int step = 0; step < options.steps; ++step) {
    solved.loss = problem.evaluate(phi, problem.bestProbes(phi), &gradient, nullptr);
    if (!std::isfinite(solved.loss)) throw NumericalError("solve", "step " + std::to_string(step), "loss", solved.loss);
    const double rate = options.rate * 0.5 * (1.0 + std::cos(kPi * step / options.steps));
    const double mean_share = 1.0 - std::pow(kMeanDecay, step + 1), square_share = 1.0 - std::pow(kSquareDecay, step + 1);
    for (size_t i = 0; i < phi.size(); ++i) {
      if (points.use[i] == PointUse::test || points.use[i] == PointUse::probe) continue;
      for (int c = 0; c < kCornerCount; ++c) {
        const double g = per_point * gradient[i][c];
        mean[i][c] = static_cast<float>(kMeanDecay * mean[i][c] + (1 - kMeanDecay) * g);
        square[i][c] = static_cast<float>(kSquareDecay * square[i][c] + (1 - kSquareDecay) * g * g);
        const double move = rate * (mean[i][c] / mean_share) / (std::sqrt(square[i][c] / square_share) + 1e-4);
        phi[i][c] = std::max(0.0f, static_cast<float>(phi[i][c] - move));
      }
    }
    phi = normalised(phi);
  }
  solved.loss = problem.evaluate(phi, problem.bestProbes(phi), nullptr, nullptr);
  solved.weights = phi;
  carryToHeldOut(points, links, solved.weights);
  return solved;
}

}  // namespace nlg
