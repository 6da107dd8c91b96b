#include "light/methods/weightings.h"

#include <algorithm>
#include <bit>
#include <memory>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

// One corner of one place, as its probe sees it.
struct Reading {
  uint32_t probe, place;
  int corner;
  ProbeAround around;
};

std::vector<Reading> readingsByProbe(const std::vector<glm::dvec3>& positions_m, const ProbeTree& tree) {
  std::vector<Reading> readings;
  readings.reserve(positions_m.size() * kCornerCount);
  for (uint32_t i = 0; i < positions_m.size(); ++i) {
    const glm::dvec3& at = positions_m[i];
    ProbesAround around;
    if (!tree.lookUp({at.x, at.y, at.z}, &around)) continue;
    for (int c = 0; c < kCornerCount; ++c) readings.push_back({around.corners[c].probe, i, c, around.corners[c]});
  }
  std::stable_sort(readings.begin(), readings.end(), [](const Reading& a, const Reading& b) { return a.probe < b.probe; });
  return readings;
}

class ProbeReader {
 public:
  ProbeReader(const ProbeTree& tree, const RayScene& rays, const DiffusionOptions& diffusion, ProbeLattice* lattice)
      : tree_(tree), lattice_(lattice), builder_(rays, diffusion) {}

  // Everything that places read of one probe.
  void read(const Reading* begin, const Reading* end, std::vector<TrueWeights>& weights) {
    const auto [x, y, z] = tree_.probePosition(begin->probe);
    const ProbeOutcome outcome =
        builder_.build({x, y, z}, tree_.probeSpacing(begin->probe), &function_, InSolid::by_eye, lattice_);
    for (const Reading* reading = begin; reading != end; ++reading) {
      const ProbeAround& around = reading->around;
      TrueWeights& place = weights[reading->place];
      place.probe[reading->corner] = reading->probe;
      if (outcome == ProbeOutcome::in_solid) continue;
      const bool is_free = outcome == ProbeOutcome::free_space;
      const float phi = is_free ? tent(around.local) : builder_.valueAt(around.local, function_);
      place.target[reading->corner] = phi * around.tent_ratio;
    }
  }

 private:
  const ProbeTree& tree_;
  ProbeLattice* lattice_;
  WeightingBuilder builder_;
  GeneratedFunction function_;
};

Reach reachOf(LightStatus status) {
  return status == LightStatus::lit     ? Reach::lit
         : status == LightStatus::faint ? Reach::fallback
         : status == LightStatus::unlit ? Reach::unlit
                                        : Reach::outside;
}

}  // namespace

std::vector<TrueWeights> trueWeights(const std::vector<glm::dvec3>& positions_m, const ProbeTree& tree, const RayScene& rays,
                                     const DiffusionOptions& diffusion, int thread_count) {
  const std::vector<Reading> readings = readingsByProbe(positions_m, tree);
  std::vector<size_t> first;  // of each probe, into readings
  for (size_t i = 0; i < readings.size(); ++i) {
    if (i == 0 || readings[i].probe != readings[i - 1].probe) first.push_back(i);
  }
  first.push_back(readings.size());
  ProbeLattice lattice(tree.frame());
  std::vector<std::unique_ptr<ProbeReader>> readers;
  for (int t = 0; t < thread_count; ++t) readers.push_back(std::make_unique<ProbeReader>(tree, rays, diffusion, &lattice));
  std::vector<TrueWeights> weights(positions_m.size());
  // probes of one place run on several threads: each writes corners of its own
  parallelFor(first.size() - 1, thread_count, [&](uint64_t p, int thread) {
    readers[thread]->read(readings.data() + first[p], readings.data() + first[p + 1], weights);
  });
  return weights;
}

ProbeBlend Trilinear::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  ProbeBlend blend;
  ProbesAround around;
  if (!probes_.tree.lookUp({position_m.x, position_m.y, position_m.z}, &around)) {
    blend.reach = Reach::outside;
    return blend;
  }
  // probes that are not seen serve where none is
  ProbeBlend unseen;
  for (const ProbeAround& corner : around.corners) {
    const float weight = tent(corner.local) * corner.tent_ratio;
    if (kind_ != TrilinearKind::all && !probes_.is_in_air[corner.probe]) continue;
    const bool is_unseen = kind_ == TrilinearKind::visible && weight > 0.0f &&
                           rays_.isBlocked(glm::vec3(position_m), glm::vec3(probes_.position_m[corner.probe]));
    (is_unseen ? unseen : blend).add(corner.probe, weight);
  }
  if (blend.count > 0) {
    blend.finish(Reach::lit);
    return blend;
  }
  unseen.finish(Reach::fallback);
  return unseen;
}

size_t TargetFunctions::PlaceHash::operator()(const glm::dvec3& place) const {
  return mixSeed(std::bit_cast<uint64_t>(place.x), std::bit_cast<uint64_t>(place.y), std::bit_cast<uint64_t>(place.z));
}

TargetFunctions::TargetFunctions(const std::vector<glm::dvec3>& places, const ProbeSet& probes, const RayScene& rays,
                                 const DiffusionOptions& diffusion, int thread_count) {
  const std::vector<TrueWeights> weights = trueWeights(places, probes.tree, rays, diffusion, thread_count);
  for (size_t i = 0; i < places.size(); ++i) {
    ProbesAround around;
    ProbeBlend blend;
    const bool is_inside = probes.tree.lookUp({places[i].x, places[i].y, places[i].z}, &around);
    for (int c = 0; c < kCornerCount && is_inside; ++c) {
      if (weights[i].target[c] >= kLeastWeight) blend.add(weights[i].probe[c], weights[i].target[c]);
    }
    blend.finish(Reach::lit);
    if (!is_inside) blend.reach = Reach::outside;
    blends_.emplace(places[i], blend);
  }
}

ProbeBlend TargetFunctions::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  const auto found = blends_.find(position_m);
  NLG_CHECK((found != blends_.end()), ==, true);
  return found->second;
}

ProbeBlend GridWeighting::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  const glm::dvec3 world = position_m + origin_m_;
  ProbeWeights shares;
  const LightStatus status = lookUpShares(grid_, {world.x, world.y, world.z}, &shares);
  ProbeBlend blend;
  for (int i = 0; i < shares.count; ++i) blend.add(shares.probe[i], shares.weight[i]);
  blend.reach = reachOf(status);
  return blend;
}

ProbeWeights GridWeighting::weightsAt(const glm::dvec3& position_m, const glm::vec3&) const {
  ProbeWeights weights;
  weights_of_grid_(position_m, &weights);
  return weights;
}

LightAt gridLight(const LightGrid& grid, const glm::dvec3& origin_m) {
  return [&grid, origin_m](std::span<const Receiver> receivers, LightAnswer* answers) {
    const size_t count = receivers.size();
    // working memory for many takes longer to allocate than one look-up
    if (count == 1) {
      const glm::dvec3 world = origin_m + receivers[0].position_m;
      LightAnswer& answer = *answers = {};
      answer.reach = reachOf(lookUpIrradiance(grid, {world.x, world.y, world.z}, &receivers[0].normal.x, &answer.irradiance.x));
      return;
    }
    std::vector<PositionM> positions_m(count);
    std::vector<glm::vec3> normals(count), irradiance(count);
    std::vector<LightStatus> status(count);
    for (size_t i = 0; i < count; ++i) {
      const glm::dvec3 world = origin_m + receivers[i].position_m;
      positions_m[i] = {world.x, world.y, world.z};
      normals[i] = receivers[i].normal;
    }
    lookUpIrradiances(grid, positions_m.data(), &normals.data()->x, count, &irradiance.data()->x, status.data());
    for (size_t i = 0; i < count; ++i) answers[i] = {irradiance[i], reachOf(status[i])};
  };
}

}  // namespace nlg
