#include "light/probe_light.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "light/air.h"
#include "light/direction_guide.h"
#include "light/standing.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kPlaceStream = 0x706c6163, kProbeStream = 0x70726f62;
constexpr uint64_t kBlockPlaces = 64, kBlockSamples = 4096;
constexpr double kDarkestShare = 0.05;  // of the mean: an error in darker places is seen against so much
// Of the mean: what has less is dark enough for nobody to have a light there, where nobody can stand.
constexpr float kUnseenDarkOfMean = 0.01f;
// Rounds of the solve: each weighs places anew by the answer of the one before.
constexpr int kRounds = 5;
// Of the rounds before the last: places are weighed anew after each, and answers are the same to four digits at half of the steps.
constexpr double kRoughTolerance = 1e-2;
// Light that a round blends at a place is believed within this factor of what was measured there: more than the noise of most places.
constexpr float kMostNoise = 3.0f;
// Of the tent in the mean that a probe begins with: too little to count where its function has weight anywhere.
constexpr float kTentShare = 1e-4f;
// Of the weights at a place: below it they are hardly more than strays, and count by the square of their sum.
constexpr float kSureSum = 0.1f;
// Pull of the orders of harmonics, over that of the mean: what sharpens irradiance least carries five ninths of the noise.
constexpr std::array<float, 3> kOrderPull = {1.0f, 1.0f, 3.0f};

// Over all directions: in the norm of squaredError, so that lamps of any colour count alike.
float lightOf(const LightSh& light) {
  const glm::vec3 mean = glm::max(light[0], glm::vec3(0.0f));
  return std::sqrt(glm::dot(mean, mean) / kShChannels);
}

void add(LightSh* sum, float weight, const LightSh& light) {
  for (int k = 0; k < kShCount; ++k) (*sum)[k] += weight * light[k];
}

// Light under weights: every probe's own mean.
struct Means {
  std::vector<LightSh> light;
  std::vector<float> weight;
  std::vector<uint8_t> is_read;

  Means(const LitPoints& points, const std::vector<glm::dvec3>& places, const std::vector<ProbeWeights>& weights,
        const std::vector<LightSh>& place_light)
      : light(points.position_m.size()), weight(light.size(), 0.0f), is_read(light.size(), 0) {
    const auto addTo = [&](uint32_t probe, float share, const LightSh& of_place) {
      add(&light[probe], share, of_place);
      weight[probe] += share;
    };
    for (size_t i = 0; i < places.size(); ++i) {
      for (int j = 0; j < weights[i].count; ++j) {
        addTo(weights[i].probe[j], weights[i].weight[j], place_light[i]);
        is_read[weights[i].probe[j]] = 1;
      }
      ProbeWeights around;
      points.around(places[i], &around);
      for (int j = 0; j < around.count; ++j) addTo(around.probe[j], kTentShare * around.weight[j], place_light[i]);
    }
    for (size_t p = 0; p < light.size(); ++p) {
      for (glm::vec3& value : light[p]) value /= std::max(weight[p], 1e-12f);
    }
  }
};

float meanLight(const std::vector<LightSh>& light) {
  double sum = 0.0;
  for (const LightSh& sh : light) sum += lightOf(sh);
  return static_cast<float>(std::max(1e-12, sum / std::max<double>(1.0, static_cast<double>(light.size()))));
}

// By place, whether its dark is nobody's to see (standing.h). Errors are relative to the light where they stand: a share of a hundredth
// that a probe has in the hollow of a wall would outweigh the lit room before it, and leave a black spot there.
std::vector<uint8_t> unseenDark(const LightTransport& transport, double spacing_m, const std::vector<glm::dvec3>& places,
                                const std::vector<LightSh>& place_light) {
  const float most = kUnseenDarkOfMean * meanLight(place_light);
  std::vector<uint8_t> is_dark(places.size());
  std::transform(place_light.begin(), place_light.end(), is_dark.begin(),
                 [most](const LightSh& light) { return lightOf(light) < most ? 1 : 0; });
  return findUnseenDark(transport, places, is_dark, spacing_m);
}

// The say of a place: 1 where the weights' sum is no accident, less below.
float sayOf(const ProbeWeights& weights) {
  const float sure = std::min(1.0f, std::accumulate(weights.weight, weights.weight + weights.count, 0.0f) / kSureSum);
  return sure * sure;
}

// Weights that add up to their place's say.
std::vector<ProbeWeights> sharesOf(std::vector<ProbeWeights> weights) {
  for (ProbeWeights& of_place : weights) {
    of_place.certainty = sayOf(of_place);
    normaliseWeights(&of_place);
  }
  return weights;
}

// False where nothing has weight.
bool takeWeights(ProbeWeights weights, LightSample* sample) {
  sample->importance = sayOf(weights);
  // where answers fade the probes must not shine for it
  weights.certainty = 1.0f;
  if (!normaliseWeights(&weights)) return false;
  sample->count = weights.count;
  std::copy_n(weights.probe, weights.count, sample->probe.begin());
  std::copy_n(weights.weight, weights.count, sample->weight.begin());
  return true;
}

std::vector<LightSample> samplesOf(const std::vector<ProbeWeights>& weights, const std::vector<LightSh>& place_light) {
  std::vector<LightSample> samples;
  for (size_t i = 0; i < weights.size(); ++i) {
    LightSample sample;
    if (!takeWeights(weights[i], &sample)) continue;
    sample.light = place_light[i];
    samples.push_back(sample);
  }
  return samples;
}

std::vector<float> pullOf(const LightSolver& solver, const std::vector<LightSample>& samples, size_t probe_count, double share) {
  // by the weight itself, not its square: what is read by small shares alone is hardly known
  std::vector<float> pull(probe_count, 0.0f), squares(probe_count, 0.0f);
  solver.forEachProbe([&](size_t p) {
    solver.forEachRead(p, [&](size_t i, float weight) {
      pull[p] += samples[i].importance * weight;
      squares[p] += samples[i].importance * weight * weight;
    });
  });
  const double total = std::accumulate(squares.begin(), squares.end(), 0.0);
  // probes that are hardly read follow their mean
  const double least = 1e-3 * total / std::max<double>(1.0, static_cast<double>(probe_count)) + 1e-12;
  for (float& value : pull) value = static_cast<float>(share * value + least);
  return pull;
}

float squaredError(const LightSample& sample, const LightSh& blend) {
  LightSh error = blend;
  for (int k = 0; k < kShCount; ++k) error[k] -= sample.light[k];
  return irradianceSquares(error);
}

// An eye sees shares: the unit of an error is the light where it stands. What was measured there has noise, and as the unit it
// would favour the places that noise made dark; so the unit is what the last answer gives, as far as measurement bears it out.
float unitOf(const LightSample& sample, const LightSh& blend, float least) {
  const float measured = lightOf(sample.light);
  return std::clamp(lightOf(blend), measured / kMostNoise, measured * kMostNoise) + least;
}

// What a probe is held at: the mean of light under its shares, where a probe has any. By the plain mean a hundredth of a share of a
// sunlit place outweighs all that a cellar has.
// say           by sample
// without_any   by probe, where it has none
std::vector<LightSh> priorOf(const LightSolver& solver, const std::vector<LightSample>& samples, const std::vector<float>& say,
                             const std::vector<LightSh>& without_any) {
  std::vector<LightSh> prior = without_any;
  constexpr float kLeast = 1e-9f;
  solver.forEachProbe([&](size_t p) {
    LightSh sum{};
    float all = 0.0f;
    solver.forEachRead(p, [&](size_t i, float weight) {
      add(&sum, say[i] * weight, samples[i].light);
      all += say[i] * weight;
    });
    if (all < kLeast) return;
    for (glm::vec3& value : sum) value /= all;
    prior[p] = sum;
  });
  return prior;
}

// Beside a lamp light changes within less than probes are apart. Squares of the errors there would rule all that those probes
// hold, so that their loss is Cauchy's, s² log(1 + error² / s²) with s in units of the place, by iteratively reweighted least
// squares.
//
// samples   their importance becomes that of the last round
// of_all    of one group of lights: the same places in all light, solved for. What one light by itself shows, as a dark wall beside its
//           patch, all light may hide, and the other way round: a place counts by the geometric mean of both
ProbeLight solved(std::vector<LightSample>& samples, const Means& means, float mean, const ProbeLightOptions& options,
                  int thread_count, const std::vector<LightSample>* of_all = nullptr) {
  std::vector<float> importance(samples.size());
  std::transform(samples.begin(), samples.end(), importance.begin(), [](const LightSample& sample) { return sample.importance; });
  const auto least = static_cast<float>(options.dark_share * mean), outlier = static_cast<float>(options.outlier);
  ProbeLight result{means.light, {}, 0, 0};
  LightSolveOptions solve;
  solve.order_pull = kOrderPull;
  solve.tolerance = kRoughTolerance;
  LightSolver solver(samples, means.light.size(), thread_count);
  std::vector<float> say(samples.size());
  for (int round = 0; round < kRounds; ++round) {
    parallelForBlocks(samples.size(), kBlockSamples, thread_count, [&](uint64_t first, uint64_t end, int) {
      for (size_t i = first; i < end; ++i) {
        const LightSh blend = blendOf(samples[i], result.light);
        // u_i a_i of docs/theory/light.md; s is the scale of Cauchy's loss
        const float unit = unitOf(samples[i], blend, least), s = outlier * unit;
        // priors weigh by 1 / unit, the solve by its square
        say[i] = importance[i] * mean / unit;
        samples[i].importance = say[i] * mean / unit;
        samples[i].importance /= 1.0f + squaredError(samples[i], blend) / (s * s);
        if (of_all != nullptr) samples[i].importance = std::sqrt(samples[i].importance * (*of_all)[i].importance);
      }
    });
    // only the last round's answer stays
    if (round + 1 == kRounds) solve.tolerance = LightSolveOptions().tolerance;
    LightSolution solution = solver.solve(priorOf(solver, samples, say, means.light),
                                          pullOf(solver, samples, means.light.size(), options.pull), result.light, solve);
    result.light = std::move(solution.light);
    result.iterations += solution.iterations;
  }
  return result;
}

void judge(const std::vector<ProbeWeights>& weights, const std::vector<LightSh>& place_light, ProbeLight* lit) {
  double sum = 0.0, light = 0.0;
  float worst = 0.0f;
  const double mean = meanLight(place_light);
  std::vector<double> shares;
  for (size_t i = 0; i < weights.size(); ++i) {
    LightSample sample;
    if (!takeWeights(weights[i], &sample)) continue;
    sample.light = place_light[i];
    const float error = squaredError(sample, blendOf(sample, lit->light));
    if (error > worst) {
      worst = error;
      lit->worst_place = i;
    }
    // relative to the light there, which in the dark is taken as a share of the mean
    const double own = lightOf(place_light[i]) + kDarkestShare * mean;
    if (own > 0.0) shares.push_back(std::sqrt(error) / own);
    sum += error;
    light += glm::dot(place_light[i][0], place_light[i][0]) / kShChannels;
  }
  lit->error = light > 0.0 ? std::sqrt(sum / light) : 0.0;
  if (shares.empty()) return;
  std::sort(shares.begin(), shares.end());
  lit->median_error = shares[shares.size() / 2];
  lit->p95_error = shares[shares.size() * 19 / 20];
}

}  // namespace

LightWay lightWayFromName(const std::string& name) {
  if (name == "point") return LightWay::point;
  if (name == "integrated") return LightWay::integrated;
  if (name == "solved") return LightWay::solved;
  throw UsageError("light", "solved, integrated, point or none", "'" + name + "'");
}

int raysOfPlace(size_t place_count) {
  constexpr size_t kAll = 16'000'000, kFewest = 64, kMost = 512, kStep = 8;
  return static_cast<int>(std::clamp(kAll / std::max<size_t>(1, place_count), kFewest, kMost) / kStep * kStep);
}

WeightsAt weightsOf(const LightGrid& grid, const glm::dvec3& origin_m) {
  return [&grid, origin_m](const glm::dvec3& position_m, ProbeWeights* weights) {
    const glm::dvec3 world = position_m + origin_m;
    weights->count = 0;
    lookUpWeights(grid, {world.x, world.y, world.z}, weights);
  };
}

std::vector<LightSh> measureLight(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                  const GatherOptions& options, uint64_t seed, int thread_count, LightByGroup* groups) {
  std::vector<LightSh> light(places.size());
  if (groups != nullptr) {
    const size_t group_count = transport.scene().light.groups.names.size();
    groups->assign(group_count, std::vector<LightSh>(places.size()));
  }
  Progress progress("sample points lit", static_cast<int64_t>(places.size()));
  parallelForBlocks(places.size(), kBlockPlaces, thread_count, [&](uint64_t first, uint64_t end, int) {
    // of a block alone, whatever thread measures it
    DirectionGuide guide;
    for (uint64_t i = first; i < end; ++i) {
      const GatheredLight gathered = transport.gather(places[i], options, mixSeed(seed, kPlaceStream), i, &guide);
      light[i] = gathered.light;
      for (size_t g = 0; groups != nullptr && g < groups->size(); ++g) (*groups)[g][i] = gathered.groups[g];
    }
    progress.advance(static_cast<int64_t>(end - first));
  });
  return light;
}

std::vector<float> floatsOf(const std::vector<LightSh>& light) {
  std::vector<float> floats;
  floats.reserve(light.size() * kShFloats);
  for (const LightSh& sh : light) {
    for (const glm::vec3& coefficient : sh) floats.insert(floats.end(), {coefficient.r, coefficient.g, coefficient.b});
  }
  return floats;
}

LitPoints litPoints(const ProbeTree& tree) {
  LitPoints points;
  points.spacing_m = tree.frame().spacing_m;
  for (size_t p = 0; p < tree.probeCount(); ++p) {
    const auto [x, y, z] = tree.probePosition(p);
    points.position_m.emplace_back(x, y, z);
  }
  points.around = [&tree](const glm::dvec3& position_m, ProbeWeights* weights) {
    ProbesAround around;
    weights->count = 0;
    if (!tree.lookUp({position_m.x, position_m.y, position_m.z}, &around)) return;
    for (const ProbeAround& corner : around.corners) {
      weights->probe[weights->count] = corner.probe;
      weights->weight[weights->count++] = tent(corner.local) * corner.tent_ratio;
    }
  };
  return points;
}

ProbeLight lightProbes(const LightTransport& transport, const ProbeTree& tree, const std::vector<glm::dvec3>& places,
                       const std::vector<LightSh>& place_light, const WeightsAt& weights_at, const ProbeLightOptions& options,
                       int thread_count, const LightByGroup& place_groups) {
  return lightProbes(transport, litPoints(tree), places, place_light, weights_at, options, thread_count, place_groups);
}

ProbeLight lightProbes(const LightTransport& transport, const LitPoints& points, const std::vector<glm::dvec3>& places,
                       const std::vector<LightSh>& place_light, const WeightsAt& weights_at, const ProbeLightOptions& options,
                       int thread_count, const LightByGroup& place_groups) {
  NLG_CHECK(places.size(), ==, place_light.size());
  Progress progress("light of probes");
  std::vector<ProbeWeights> weights(places.size());
  parallelForBlocks(places.size(), kBlockPlaces, thread_count, [&](uint64_t first, uint64_t end, int) {
    for (uint64_t i = first; i < end; ++i) weights_at(places[i], &weights[i]);
  });
  uint64_t unseen = 0;
  if (options.way == LightWay::solved) {
    const std::vector<uint8_t> is_unseen = unseenDark(transport, points.spacing_m, places, place_light);
    for (size_t i = 0; i < places.size(); ++i) {
      if (is_unseen[i]) ++unseen, weights[i].count = 0;
    }
  }
  // the talk's integral is over the function; what a solve leans on is read at places by shares, which beside walls are far more
  const std::vector<ProbeWeights> leaned_on = options.way == LightWay::solved ? sharesOf(weights) : weights;
  Means means(points, places, leaned_on, place_light);
  std::vector<Means> group_means;
  for (const std::vector<LightSh>& of_group : place_groups) group_means.emplace_back(points, places, leaned_on, of_group);
  // probes to which no sample point gives weight are counted for the report
  const auto unread = static_cast<uint64_t>(std::count(means.is_read.begin(), means.is_read.end(), 0));
  ProbeLight result;
  if (options.way == LightWay::solved) {
    const float mean = meanLight(place_light);
    std::vector<LightSample> samples = samplesOf(weights, place_light);
    result = solved(samples, means, mean, options, thread_count);
    // groups are solved apart; which points are outliers all light has a say in
    for (size_t g = 0; g < place_groups.size(); ++g) {
      std::vector<LightSample> of_group = samplesOf(weights, place_groups[g]);
      ProbeLight lit = solved(of_group, group_means[g], meanLight(place_groups[g]), options, thread_count, &samples);
      result.groups.push_back(std::move(lit.light));
      result.iterations += lit.iterations;
    }
  } else {
    result.light = std::move(means.light);
    for (Means& of_group : group_means) result.groups.push_back(std::move(of_group.light));
  }
  // gathered at the probe itself; a probe in solid keeps its mean
  if (options.way == LightWay::point) {
    parallelFor(points.position_m.size(), thread_count, [&](uint64_t p, int) {
      const glm::dvec3& at = points.position_m[p];
      if (!isInAir(transport.rays(), at)) return;
      const GatheredLight gathered = transport.gather(at, options.probe, mixSeed(options.seed, kProbeStream, p));
      result.light[p] = gathered.light;
      for (size_t g = 0; g < result.groups.size(); ++g) result.groups[g][p] = gathered.groups[g];
    });
  }
  // all light is the sum of its groups, as a game mixes them
  if (!result.groups.empty()) {
    for (size_t p = 0; p < result.light.size(); ++p) {
      result.light[p] = {};
      for (const std::vector<LightSh>& of_group : result.groups) add(&result.light[p], 1.0f, of_group[p]);
    }
  }
  result.unread = unread;
  result.unseen = unseen;
  judge(weights, place_light, &result);
  return result;
}

}  // namespace nlg
