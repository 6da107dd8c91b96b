#include "light/thinning.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kBesideStream = 0x626573696465;
constexpr double kBefore = 0.03;    // of the reach: from a surface
constexpr float kMostAtOne = 4.0f;  // of the error that is asked for: at any place
constexpr float kLeastSum = 0.05f;  // of weights at a place: with less, neighbours that hardly see it decide
constexpr uint64_t kBlockProbes = 256;
constexpr double kWorthATrial = 4.0;  // what is left out on the way changes what others add: so far beyond is not tried again

float meanLightOf(const LightSh& light) { return std::sqrt(irradianceSquares({light[0]})); }

}  // namespace

std::vector<glm::dvec3> placesBesideSurfaces(const RayScene& rays, const std::vector<glm::dvec3>& places, double reach_m,
                                             uint64_t seed, size_t every) {
  std::vector<glm::dvec3> beside;
  const auto before_m = static_cast<float>(kBefore * reach_m);
  for (size_t i = 0; i < places.size(); i += every) {
    Random random(mixSeed(seed, kBesideStream, i / every));
    glm::vec3 at(places[i]);
    glm::vec3 direction = sphereDirection(random.uniform(), random.uniform());
    // along a surface to the next, and along both to a third
    for (int surfaces = 0; surfaces < 3; ++surfaces) {
      const LightHit hit = rays.lightHit(at, direction);
      if (hit.kind != LightHit::Kind::surface || hit.distance > static_cast<float>(reach_m)) break;
      // stops a share of the reach before the surface, however slanted the ray
      const float back = std::min(hit.distance, before_m / std::max(0.05f, -glm::dot(direction, hit.normal)));
      at += (hit.distance - back) * direction;
      beside.emplace_back(at);
      const auto [along, across] = acrossOf(hit.normal);
      const auto angle = static_cast<float>(2.0 * std::numbers::pi * random.uniform());
      glm::vec3 next = std::cos(angle) * along + std::sin(angle) * across;
      if (surfaces == 1) next = random.chance(0.5) ? glm::cross(hit.normal, direction) : glm::cross(direction, hit.normal);
      if (!(glm::dot(next, next) > 1e-6f)) break;
      direction = glm::normalize(next);
    }
  }
  return beside;
}

GridThinner::GridThinner(LightGrid* grid, const glm::dvec3& origin_m, const std::vector<glm::dvec3>& places,
                         const std::vector<const std::vector<LightSh>*>& measured, const std::vector<glm::dvec3>& beside,
                         const std::vector<const std::vector<LightSh>*>& light, double dark_share, int thread_count)
    : grid_(grid), thread_count_(thread_count), light_(light), places_(places.size() + beside.size()) {
  NLG_CHECK(measured.size(), ==, light.size());
  const size_t groups = light_.size();
  blend_.resize(places_.size() * groups);
  // what every place reads of the whole grid: all later errors are measured from there
  parallelForBlocks(places_.size(), kBlockProbes, thread_count_, [&](uint64_t first, uint64_t end, int) {
    for (size_t i = first; i < end; ++i) {
      Place& place = places_[i];
      read(origin_m, i < places.size() ? places[i] : beside[i - places.size()], &place);
      for (size_t g = 0; g < groups; ++g) {
        LightSh& blend = blend_[i * groups + g];
        blend = {};
        for (int c = 0; c < kCorners; ++c) {
          for (int k = 0; k < kShCount && place.weight[c] > 0.0f; ++k)
            blend[k] += place.weight[c] * (*light_[g])[place.probe[c]][k];
        }
      }
    }
  });
  setTargets(measured, places.size(), dark_share);
  indexReadings();
  indexEdges();
}

void GridThinner::read(const glm::dvec3& origin_m, const glm::dvec3& at_m, Place* place) const {
  place->at_m = at_m;
  const glm::dvec3 world = at_m + origin_m;
  ProbesAround around;
  if (!grid_->tree.lookUp({world.x, world.y, world.z}, &around)) return;
  ProbeWeights weights;
  weightsAround(*grid_, around, &weights);
  for (int c = 0, next = 0; c < kCorners; ++c) {
    const ProbeAround& corner = around.corners[c];
    place->probe[c] = corner.probe;
    if (grid_->probe_function[corner.probe] == kNoWeight) continue;
    place->tent[c] = tent(corner.local) * corner.tent_ratio;
    if (next < weights.count && weights.probe[next] == corner.probe) place->weight[c] = weights.weight[next++];
    place->sum += place->weight[c];
  }
}

void GridThinner::setTargets(const std::vector<const std::vector<LightSh>*>& measured, size_t measured_count, double dark_share) {
  const size_t groups = light_.size();
  target_.resize(blend_.size());
  unit_.resize(blend_.size());
  for (size_t g = 0; g < groups; ++g) {
    double mean = 0.0;
    for (const LightSh& light : *measured[g]) mean += meanLightOf(light) / static_cast<double>(measured_count);
    for (size_t i = 0; i < places_.size(); ++i) {
      // measured places are held to their measured light, places beside surfaces to what the whole grid gives
      LightSh& target = target_[i * groups + g];
      target = i < measured_count ? (*measured[g])[i] : blend_[i * groups + g];
      for (int k = 0; k < kShCount && i >= measured_count; ++k) target[k] /= std::max(places_[i].sum, 1e-12f);
      unit_[i * groups + g] = meanLightOf(target) + static_cast<float>(dark_share * mean) + 1e-20f;
    }
  }
  std::vector<LightSh> blends(groups);
  for (size_t i = 0; i < places_.size(); ++i)
    places_[i].square = places_[i].first_square = squareOf(i, blendsWith(i, 0, places_[i].weight[0], &blends), places_[i].sum);
}

void GridThinner::indexReadings() {
  const size_t probes = grid_->tree.probeCount();
  reading_begin_.assign(probes + 1, 0);
  const auto forEachReading = [&](const auto& visit) {
    for (uint32_t i = 0; i < places_.size(); ++i) {
      for (uint8_t c = 0; c < kCorners && places_[i].sum > 0.0f; ++c) {
        if (places_[i].tent[c] > 0.0f) visit(places_[i].probe[c], Reading{i, c});
      }
    }
  };
  forEachReading([&](uint32_t probe, const Reading&) { ++reading_begin_[probe + 1]; });
  for (size_t p = 0; p < probes; ++p) reading_begin_[p + 1] += reading_begin_[p];
  readings_.resize(reading_begin_.back());
  std::vector<size_t> next(reading_begin_.begin(), reading_begin_.end() - 1);
  forEachReading([&](uint32_t probe, const Reading& reading) { readings_[next[probe]++] = reading; });
}

// Beside an edge of a cell whose two probes have no weight the others' tents end, and which of them counts most changes within nothing.
void GridThinner::indexEdges() {
  std::vector<std::pair<uint32_t, uint32_t>> of_probe;
  const ProbeTree& tree = grid_->tree;
  tree.forEachCell([&](const ProbeCell& cell) {
    const ProbeTreeFrame& frame = tree.frame();
    // the middle of a cell reads its eight corners
    PositionM middle;
    for (int axis = 0; axis < 3; ++axis)
      middle[axis] = frame.first_m[axis] + frame.spacing_m * (cell.low[axis] + 0.5 * cell.side);
    ProbesAround around;
    NLG_CHECK(tree.lookUp(middle, &around), ==, true);
    // an edge along each axis from each of its four low corners; counted are its probes with weight
    for (int axis = 0; axis < 3; ++axis) {
      for (int low = 0; low < kCorners; ++low) {
        if ((low >> axis & 1) != 0) continue;
        const auto edge = static_cast<uint32_t>(edge_weights_.size());
        edge_weights_.push_back(0);
        for (const int c : {low, low | 1 << axis}) {
          const uint32_t probe = around.corners[c].probe;
          if (grid_->probe_function[probe] == kNoWeight) continue;
          ++edge_weights_.back();
          of_probe.emplace_back(probe, edge);
        }
      }
    }
  });
  // by probe, so that what leaves one out finds its edges
  std::sort(of_probe.begin(), of_probe.end());
  edge_begin_.assign(tree.probeCount() + 1, 0);
  for (const auto& [probe, edge] : of_probe) {
    ++edge_begin_[probe + 1];
    edges_of_.push_back(edge);
  }
  for (size_t p = 0; p < tree.probeCount(); ++p) edge_begin_[p + 1] += edge_begin_[p];
}

// Of the group that errs most.
float GridThinner::squareOf(size_t place, const std::vector<LightSh>& blends, float sum) const {
  if (!(sum > 0.0f)) return 1.0f;  // dark
  float worst = 0.0f;
  const size_t groups = light_.size();
  for (size_t g = 0; g < groups; ++g) {
    LightSh difference = blends[g];
    for (int k = 0; k < kShCount; ++k) difference[k] = difference[k] / sum - target_[place * groups + g][k];
    const float unit = unit_[place * groups + g];
    worst = std::max(worst, irradianceSquares(difference) / (unit * unit));
  }
  return worst;
}

const std::vector<LightSh>& GridThinner::blendsWith(size_t place, int corner, float weight, std::vector<LightSh>* blends) const {
  const float more = weight - places_[place].weight[corner];
  for (size_t g = 0; g < light_.size(); ++g) {
    const LightSh& of_probe = (*light_[g])[places_[place].probe[corner]];
    (*blends)[g] = blend_[place * light_.size() + g];
    for (int k = 0; k < kShCount; ++k) (*blends)[g][k] += more * of_probe[k];
  }
  return *blends;
}

bool GridThinner::baresEdge(uint32_t probe) const {
  return std::any_of(edges_of_.begin() + static_cast<std::ptrdiff_t>(edge_begin_[probe]),
                     edges_of_.begin() + static_cast<std::ptrdiff_t>(edge_begin_[probe + 1]),
                     [&](uint32_t edge) { return edge_weights_[edge] == 1; });
}

bool GridThinner::isCandidate(uint32_t probe, Left left) const {
  const uint32_t function = grid_->probe_function[probe];
  return function != kNoWeight && (left == Left::nothing ? !baresEdge(probe) : function != kFreeSpace);
}

GridThinner::Trial GridThinner::tryOut(uint32_t probe, Left left, float most_at_one, std::vector<LightSh>* scratch) const {
  Trial trial;
  if (reading_begin_[probe] == reading_begin_[probe + 1]) return {false, 0.0};  // nothing is known of it
  for (size_t r = reading_begin_[probe]; r < reading_begin_[probe + 1]; ++r) {
    const auto [i, corner] = readings_[r];
    const Place& place = places_[i];
    const float weight = left == Left::tent ? place.tent[corner] : 0.0f;
    const float sum = place.sum + weight - place.weight[corner];
    const float square = squareOf(i, blendsWith(i, corner, weight, scratch), sum);
    const bool is_thin = sum < kLeastSum && sum < place.sum;
    if (is_thin || std::sqrt(square) > std::sqrt(place.first_square) + most_at_one) return {false, 0.0};
    // Cauchy's loss, as the solve has it, close to where it began
    trial.loss += (square - place.square) / (1.0f + place.first_square);
  }
  trial.loss /= static_cast<double>(reading_begin_[probe + 1] - reading_begin_[probe]);
  return trial;
}

void GridThinner::leaveOut(uint32_t probe, Left left) {
  std::vector<LightSh> blends(light_.size());
  for (size_t r = reading_begin_[probe]; r < reading_begin_[probe + 1]; ++r) {
    const auto [i, corner] = readings_[r];
    Place& place = places_[i];
    const float weight = left == Left::tent ? place.tent[corner] : 0.0f;
    blendsWith(i, corner, weight, &blends);
    std::copy(blends.begin(), blends.end(), blend_.begin() + static_cast<std::ptrdiff_t>(i * light_.size()));
    place.sum += weight - place.weight[corner];
    place.weight[corner] = weight;
    place.square = squareOf(i, blends, place.sum);
    if (left == Left::nothing) place.tent[corner] = 0.0f;
  }
  grid_->probe_function[probe] = left == Left::tent ? kFreeSpace : kNoWeight;
  ++(left == Left::tent ? thinned_.functions : thinned_.probes);
  for (size_t f = edge_begin_[probe]; f < edge_begin_[probe + 1] && left == Left::nothing; ++f) --edge_weights_[edges_of_[f]];
}

// Whatever costs light least first; each is tried again when its turn comes, since what went before changed what stands around it.
void GridThinner::pass(Left left, double error) {
  const auto most_at_one = static_cast<float>(kMostAtOne * error);
  const auto probes = static_cast<uint32_t>(grid_->tree.probeCount());
  // all trials against the grid as it stands, in parallel
  std::vector<Trial> trials(probes, Trial{false, 0.0});
  parallelForBlocks(probes, kBlockProbes, thread_count_, [&](uint64_t first, uint64_t end, int) {
    std::vector<LightSh> scratch(light_.size());
    for (auto p = static_cast<uint32_t>(first); p < end; ++p) {
      if (isCandidate(p, left)) trials[p] = tryOut(p, left, most_at_one, &scratch);
    }
  });
  std::vector<uint32_t> order;
  for (uint32_t p = 0; p < probes; ++p) {
    if (trials[p].is_allowed && trials[p].loss <= kWorthATrial * error * error) order.push_back(p);
  }
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return trials[a].loss < trials[b].loss; });
  std::vector<LightSh> scratch(light_.size());
  for (const uint32_t probe : order) {
    if (!isCandidate(probe, left)) continue;
    const Trial trial = tryOut(probe, left, most_at_one, &scratch);
    if (trial.is_allowed && trial.loss <= error * error) leaveOut(probe, left);
  }
}

void GridThinner::thinTo(double error) {
  pass(Left::tent, error);
  pass(Left::nothing, error);
  noteLargestChange();
}

void GridThinner::noteLargestChange() {
  for (const Place& place : places_) {
    const double change = std::sqrt(place.square) - std::sqrt(place.first_square);
    if (change <= thinned_.largest_change) continue;
    thinned_.largest_change = change;
    thinned_.largest_at_m = place.at_m;
  }
}

}  // namespace nlg
