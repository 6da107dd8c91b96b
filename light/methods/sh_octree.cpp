#include "light/methods/sh_octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "light/light_solve.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr uint64_t kHeldOutStream = 0x68656c64, kAirStream = 0x616972;
constexpr int kCubeLog2 = kOctreeCoarsestLog2;  // cubes of 4 m, each of cells of one size from 4 m to 1 m …
constexpr int kChildLog2 = 2;                   // … or of 64 cubes of 1 m, each of cells of one size from 1 m to 25 cm
// An error counts against the light of its place and so much of the mean: neither lamps alone decide nor the dark.
constexpr float kMeanShare = 0.3f;
constexpr float kPull = 0.1f;         // of a round's prior, as the bake's solve has it
constexpr int kRoundIterations = 15;  // of a round's solve: it begins with the round before
constexpr double kFull = 0.97;        // of a budget: enough
constexpr double kMostOver = 1.2;     // … and what goes beyond it by more is none of its trees
constexpr double kOfRoom = 0.6;       // what a round takes of what is left: how many probes come of it is a guess
constexpr double kGrowth = 1.6;       // of the tree in a round, at most
constexpr double kHelped = 0.95;      // of the error before: more is no help
// Probes that a cell adds when it becomes 8 or 64: between those of a cell by itself and those of one among its like.
constexpr double kProbesOfHalving = 12.0, kProbesOfQuartering = 90.0;

LightSample sampleAt(const ProbeTree& tree, const glm::dvec3& place) {
  LightSample sample;
  ProbesAround around;
  if (!tree.lookUpNear({place.x, place.y, place.z}, &around)) return sample;
  for (const ProbeAround& corner : around.corners) {
    const float weight = tent(corner.local) * corner.tent_ratio;
    if (!(weight > 0.0f)) continue;
    sample.probe[sample.count] = corner.probe;
    sample.weight[sample.count++] = weight;
  }
  return sample;
}

// Sides of cells over a lattice of cubes.
class CellSides {
 public:
  explicit CellSides(const std::vector<glm::dvec3>& places) {
    glm::dvec3 low = places.front(), high = low;
    for (const glm::dvec3& place : places) {
      low = glm::min(low, place);
      high = glm::max(high, place);
    }
    frame_.spacing_m = kOctreeFinestM;
    for (int axis = 0; axis < 3; ++axis) {
      frame_.first_m[axis] = low[axis] - 0.5 * kOctreeFinestM;
      frame_.root_count[axis] = 1 + static_cast<int32_t>((high[axis] - frame_.first_m[axis]) / (kRootSide * kOctreeFinestM));
    }
    for (const glm::dvec3& place : places) cubes_.emplace(cubeKey(unitOf(place), kCubeLog2), kCubeLog2);
  }

  // A cube that may be divided, by its key: one of 4 m with cells of 2 m or more, or one of 1 m.
  struct Cube {
    uint64_t key = 0;
    int log2 = kCubeLog2;
    bool operator<(const Cube& other) const { return log2 != other.log2 ? log2 > other.log2 : key < other.key; }
  };
  Cube cubeOf(const glm::dvec3& place) const {
    const LatticePoint unit = unitOf(place);
    const uint64_t key = cubeKey(unit, kCubeLog2);
    const auto found = cubes_.find(key);
    return found == cubes_.end() || found->second > kChildLog2 ? Cube{key, kCubeLog2}
                                                               : Cube{cubeKey(unit, kChildLog2), kChildLog2};
  }

  int sideOf(const Cube& cube) const {
    const auto& sides = cube.log2 == kCubeLog2 ? cubes_ : children_;
    const auto found = sides.find(cube.key);
    return found == sides.end() ? cube.log2 : found->second;
  }
  void setSide(const Cube& cube, int log2) { (cube.log2 == kCubeLog2 ? cubes_ : children_)[cube.key] = log2; }

  ProbeTree build() const {
    const CellJudge judge = [this](const ProbeCell& cell) {
      const int log2 = std::countr_zero(static_cast<uint32_t>(cell.side));
      if (log2 > kCubeLog2) return CellVerdict::too_coarse;
      const auto cube = cubes_.find(cubeKey(cell.low, kCubeLog2));
      if (cube == cubes_.end()) return CellVerdict::unneeded;
      if (log2 > kChildLog2 || cube->second > kChildLog2)
        return log2 <= cube->second ? CellVerdict::fits : CellVerdict::too_coarse;
      return log2 <= sideOf({cubeKey(cell.low, kChildLog2), kChildLog2}) ? CellVerdict::fits : CellVerdict::too_coarse;
    };
    ProbeTree tree;
    if (ProbeTree::build(frame_, judge, kMaxTreeProbes, &tree) != ProbeTreeStatus::ok)
      throw UsageError("octree", "a scene that cells of 25 cm can cover", "a larger scene");
    return tree;
  }

 private:
  LatticePoint unitOf(const glm::dvec3& place) const {
    LatticePoint unit;
    for (int axis = 0; axis < 3; ++axis)
      unit[axis] = static_cast<int32_t>(std::floor((place[axis] - frame_.first_m[axis]) / frame_.spacing_m));
    return unit;
  }
  static uint64_t cubeKey(const LatticePoint& unit, int log2) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) key = key << 21 | static_cast<uint64_t>(unit[axis] >> log2);
    return key;
  }

  ProbeTreeFrame frame_;
  std::map<uint64_t, int> cubes_, children_;  // by key: log2 of the side of their cells; children that are not there: 1 m
};

class Grower {
 public:
  Grower(const LightTransport& transport, const std::vector<glm::dvec3>& places, const std::vector<LightSh>& light,
         const ShOctreeOptions& options)
      : transport_(transport), places_(places), light_(light), options_(options), sides_(places) {
    float mean = 0.0f;
    for (const LightSh& sh : light) mean += std::sqrt(irradianceSquares({sh[0]})) / static_cast<float>(light.size());
    for (size_t i = 0; i < light.size(); ++i) {
      const float unit = std::sqrt(irradianceSquares({light[i][0]})) + kMeanShare * mean + 1e-12f;
      importance_.push_back(1.0f / (unit * unit));
      is_held_out_.push_back(mixSeed(options.seed, kHeldOutStream, i) % 2);
    }
    rebuild();
    solve();
    measure();
  }

  size_t bytes() const { return options_.bytes(tree_); }

  void growTo(size_t budget) {
    for (int round = 0; round < options_.rounds_per_budget; ++round) {
      const size_t stored = bytes();
      if (static_cast<double>(stored) >= kFull * static_cast<double>(budget)) return;
      // what is left of the budget, in probes at their present bytes
      const double room =
          static_cast<double>(budget - stored) / (static_cast<double>(stored) / static_cast<double>(tree_.probeCount()));
      const size_t before = tree_.probeCount();
      const double expected = divide(std::min(kOfRoom * room, (kGrowth - 1.0) * static_cast<double>(before)) / probes_of_one_);
      if (expected == 0.0) return;
      rebuild();
      // how many probes divisions really made corrects the next guess
      const double grown = static_cast<double>(tree_.probeCount()) - static_cast<double>(before);
      probes_of_one_ = std::clamp(grown / expected, 0.1, 3.0);
      solve();
      measure();
      takeBack();
    }
  }

  // Whatever was taken back is gone from the tree, too.
  ShOctree finished() {
    rebuild();
    const WeightsAt weights = [this](const glm::dvec3& position_m, ProbeWeights* at) {
      const LightSample sample = sampleAt(tree_, position_m);
      at->count = sample.count;
      std::copy_n(sample.probe.begin(), sample.count, at->probe);
      std::copy_n(sample.weight.begin(), sample.count, at->weight);
    };
    ShOctree octree{0, tree_, {}, 0.0};
    octree.light = lightProbes(transport_, tree_, places_, light_, weights, options_.solve, options_.thread_count).light;
    return octree;
  }

 private:
  struct Division {
    CellSides::Cube cube;
    int from_log2 = 0;
    double error = 0.0;  // before
  };

  // The tree of the sides, without cells in solid, and its probes' light from the tree before.
  void rebuild() {
    const ProbeTree before = std::move(tree_);
    const std::vector<LightSh> known = std::move(solved_);
    const ProbeTree full = sides_.build();
    AirPlaceOptions air;
    air.places_per_cell = 1;
    air.draws_for_one = 48;
    air.seed = mixSeed(options_.seed, kAirStream);
    tree_ = treeOfAir(full, findAirPlaces(transport_.rays(), full, air, options_.thread_count));
    // new probes begin with the blend of the tree before, and the first with the mean
    LightSh mean{};
    for (const LightSh& sh : light_) {
      for (int k = 0; k < kShCount; ++k) mean[k] += sh[k] / static_cast<float>(light_.size());
    }
    solved_.assign(tree_.probeCount(), mean);
    for (size_t p = 0; p < solved_.size() && !known.empty(); ++p) {
      const auto [x, y, z] = tree_.probePosition(p);
      const LightSample sample = sampleAt(before, {x, y, z});
      if (sample.count > 0) solved_[p] = blendOf(sample, known);
    }
  }

  void solve() {
    std::vector<LightSample> samples;
    std::vector<float> pull(tree_.probeCount(), 1e-6f);
    for (size_t i = 0; i < places_.size(); ++i) {
      // half of the points are held out: they measure what a division gained
      if (is_held_out_[i]) continue;
      LightSample sample = sampleAt(tree_, places_[i]);
      if (sample.count == 0) continue;
      sample.importance = importance_[i];
      sample.light = light_[i];
      for (int j = 0; j < sample.count; ++j) pull[sample.probe[j]] += kPull * sample.importance * sample.weight[j];
      samples.push_back(sample);
    }
    LightSolveOptions solve;
    solve.max_iterations = kRoundIterations;
    solved_ = solveLight(samples, solved_, pull, solved_, solve).light;
  }

  void measure() {
    error_.clear();
    for (size_t i = 0; i < places_.size(); ++i) {
      if (!is_held_out_[i]) continue;
      const LightSample sample = sampleAt(tree_, places_[i]);
      LightSh difference = sample.count > 0 ? blendOf(sample, solved_) : LightSh{};
      for (int k = 0; k < kShCount; ++k) difference[k] -= light_[i][k];
      const double squares = importance_[i] * irradianceSquares(difference);
      error_[sides_.cubeOf(places_[i])] += squares / (1.0 + squares);  // Cauchy's, as the solve has it
    }
  }

  double errorOf(const CellSides::Cube& cube) const {
    const auto found = error_.find(cube);
    return found == error_.end() ? 0.0 : found->second;
  }

  // Divides what gains most by probes, for so many more. Returns how many that should be.
  double divide(double probes) {
    struct Candidate {
      CellSides::Cube cube;
      double gain, cost;
    };
    std::vector<Candidate> candidates;
    // by held-out error for each probe that a division would add
    for (const auto& [cube, error] : error_) {
      const int side = sides_.sideOf(cube);
      if (side == 0 || settled_.count(cube) > 0) continue;
      // a cube's first division makes 8 of a cell, a further one 64
      const bool halves = side == cube.log2;
      const double cost = halves ? kProbesOfHalving : kProbesOfQuartering;
      candidates.push_back({cube, error / cost, cost});
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
    divisions_.clear();
    double sum = 0.0;
    // one is always taken, however few probes are left
    for (const Candidate& candidate : candidates) {
      if (sum > 0.0 && sum + candidate.cost > probes) break;
      const int side = sides_.sideOf(candidate.cube);
      divisions_.push_back({candidate.cube, side, errorOf(candidate.cube)});
      sides_.setSide(candidate.cube, side - 1);
      sum += candidate.cost;
    }
    return sum;
  }

  void takeBack() {
    for (const Division& division : divisions_) {
      // what a wall in a cell of 4 m costs is gone in cells of 1 m, and hardly less in those of 2 m
      if (division.cube.log2 == kCubeLog2 || errorOf(division.cube) <= kHelped * division.error) continue;
      sides_.setSide(division.cube, division.from_log2);
      settled_[division.cube] = true;
    }
  }

  const LightTransport& transport_;
  const std::vector<glm::dvec3>& places_;
  const std::vector<LightSh>& light_;
  const ShOctreeOptions& options_;
  CellSides sides_;
  std::vector<float> importance_;     // by place
  std::vector<uint8_t> is_held_out_;  // by place
  ProbeTree tree_;
  std::vector<LightSh> solved_;              // by probe
  std::map<CellSides::Cube, double> error_;  // held-out, by cube
  std::map<CellSides::Cube, bool> settled_;  // not to be divided
  std::vector<Division> divisions_;          // of the last round
  double probes_of_one_ = 1.0;               // that came of one that was expected
};

}  // namespace

std::vector<ShOctree> growShOctrees(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                    const std::vector<LightSh>& light, const ShOctreeOptions& options) {
  NLG_CHECK(places.size(), ==, light.size());
  NLG_CHECK(places.size(), >, 0u);
  const double start = processorSeconds();
  Grower grower(transport, places, light, options);
  std::vector<ShOctree> octrees;
  for (const size_t budget : options.byte_budgets) {
    if (static_cast<double>(grower.bytes()) > kMostOver * static_cast<double>(budget)) continue;
    grower.growTo(budget);
    octrees.push_back(grower.finished());
    octrees.back().byte_budget = budget;
    octrees.back().bake_s = processorSeconds() - start;
    // little is left to divide where not half of a budget is used: larger ones get no tree
    if (grower.bytes() < budget / 2) break;
  }
  return octrees;
}

ProbeBlend ShOctreeWeighting::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  ProbeBlend blend;
  const LightSample sample = sampleAt(tree_, position_m);
  for (int j = 0; j < sample.count; ++j) blend.add(sample.probe[j], sample.weight[j]);
  if (blend.count == 0) {
    blend.reach = Reach::outside;
  } else {
    blend.finish(Reach::lit);
  }
  return blend;
}

}  // namespace nlg
