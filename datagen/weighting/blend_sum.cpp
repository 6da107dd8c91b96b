#include "datagen/weighting/blend_sum.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Of the offset to a neighbour, in the octant of `mirror`, along the axes `away`.
std::array<int, 3> offsetOf(int mirror, int away) {
  std::array<int, 3> offset{};
  for (int axis = 0; axis < 3; ++axis) {
    if (away >> axis & 1) offset[axis] = mirror >> axis & 1 ? -1 : 1;
  }
  return offset;
}

size_t indexOf(const std::array<int, 3>& offset) {
  return static_cast<size_t>((offset[0] + 1) + 3 * (offset[1] + 1) + 9 * (offset[2] + 1));
}

}  // namespace

ProbeSight EyeFinder::find(const glm::dvec3& position_m, float spacing_m) {
  const SolidVote vote = visibility_.voteAt(position_m);
  if (!vote.solid()) return {vote, LocalPoint{}};
  visibility_.beginProbe(position_m, spacing_m);
  return {vote, solid_eye_.open(&visibility_)};
}

LatticePoint ProbeEyes::latticeOf(const glm::dvec3& position_m) const {
  LatticePoint at;
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = static_cast<int32_t>(std::lround((position_m[axis] - lattice_.first_m[axis]) / lattice_.spacing_m));
  return at;
}

int32_t ProbeEyes::unitsOf(float spacing_m) const { return static_cast<int32_t>(std::lround(spacing_m / lattice_.spacing_m)); }

size_t ProbeEyes::KeyHash::operator()(const Key& key) const {
  return mixSeed(static_cast<uint64_t>(static_cast<uint32_t>(key[0])) << 32 | static_cast<uint32_t>(key[1]),
                 static_cast<uint64_t>(static_cast<uint32_t>(key[2])) << 32 | static_cast<uint32_t>(key[3]));
}

ProbeSight ProbeEyes::sightOf(const LatticePoint& at, int32_t units, EyeFinder* finder) {
  const Key key = {at[0], at[1], at[2], units};
  Part& part = parts_[KeyHash()(key) % kParts];
  {
    const std::lock_guard lock(part.mutex);
    if (const auto found = part.sights.find(key); found != part.sights.end()) return found->second;
  }
  glm::dvec3 position_m;
  for (int axis = 0; axis < 3; ++axis) position_m[axis] = lattice_.first_m[axis] + lattice_.spacing_m * at[axis];
  const ProbeSight sight = finder->find(position_m, static_cast<float>(units * lattice_.spacing_m));
  const std::lock_guard lock(part.mutex);
  if (part.sights.size() >= kMostKept) part.sights.clear();
  part.sights.emplace(key, sight);
  return sight;
}

NeighbourEyes neighbourEyes(const glm::dvec3& position_m, float spacing_m, ProbeEyes* eyes, EyeFinder* finder) {
  NeighbourEyes found;
  const LatticePoint own = eyes->latticeOf(position_m);
  const int32_t units = eyes->unitsOf(spacing_m);
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        found[indexOf({x, y, z})] =
            eyes->sightOf({own[0] + x * units, own[1] + y * units, own[2] + z * units}, units, finder).eye;
      }
    }
  }
  return found;
}

BlendSum::BlendSum() : sum_(kOctantPointCount) {
  const std::vector<LocalPoint>& points = supportPattern().points;
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) octants_[mirror] = makeOctantPackets(mirror);
  for (int away = 0; away < kMirrorCount; ++away) {
    tents_[away].resize(kOctantPointCount);
    for (int i = 0; i < kOctantPointCount; ++i) {
      tents_[away][i] = 1.0f;
      for (int axis = 0; axis < 3; ++axis) tents_[away][i] *= away >> axis & 1 ? points[i][axis] : 1.0f - points[i][axis];
    }
  }
}

void BlendSum::addNeighbour(int mirror, int away, const LocalPoint& eye, bool in_place,
                            const std::vector<LocalTriangle>& triangles) {
  blockOctantRays(octants_[mirror], triangles, in_place ? near_[mirror] : all_, eye, blocked_.data());
  const float* tent = tents_[away].data();
  for (size_t packet = 0; packet < blocked_.size(); ++packet) {
    float* sum = &sum_[packet * kPacketLanes];
    const float* add = tent + packet * kPacketLanes;
    const uint16_t blocked = blocked_[packet];
    if (blocked == 0) {
      for (int i = 0; i < kPacketLanes; ++i) sum[i] += add[i];
    } else if (blocked != 0xffff) {
      for (int i = 0; i < kPacketLanes; ++i) sum[i] += blocked >> i & 1 ? 0.0f : add[i];
    }
  }
}

void BlendSum::compute(const std::vector<LocalTriangle>& triangles, const NeighbourEyes& eyes, const float* phi, uint8_t* sums) {
  // an octant is one cell of the probe: triangles are sorted by the octants that they touch
  all_.resize(triangles.size());
  std::iota(all_.begin(), all_.end(), 0u);
  for (std::vector<uint32_t>& near : near_) near.clear();
  sortIntoOctants(triangles, &near_);
  // 255 stands for 1 or more, which weighs a point least; where phi is 0 the sum is not read
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
    const float* own = phi + mirror * kOctantPointCount;
    uint8_t* to = sums + mirror * kOctantPointCount;
    std::fill_n(to, kOctantPointCount, uint8_t{255});
    if (std::all_of(own, own + kOctantPointCount, [](float value) { return value == 0.0f; })) continue;
    // no triangle touches the cell, and all neighbours look from their own places: the tents sum to 1
    const auto offsetTo = [mirror](int away) { return indexOf(offsetOf(mirror, away)); };
    const auto isInPlace = [](const std::optional<LocalPoint>& eye) { return eye && *eye == LocalPoint{}; };
    bool all_see_all = near_[mirror].empty();
    for (int away = 1; away < kMirrorCount && all_see_all; ++away) all_see_all = isInPlace(eyes[offsetTo(away)]);
    if (all_see_all) continue;
    std::copy_n(own, kOctantPointCount, sum_.begin());
    // the seven other probes of the cell
    for (int away = 1; away < kMirrorCount; ++away) {
      const std::array<int, 3> offset = offsetOf(mirror, away);
      const std::optional<LocalPoint>& theirs = eyes[offsetTo(away)];
      if (!theirs) continue;
      LocalPoint eye;
      for (int axis = 0; axis < 3; ++axis) eye[axis] = static_cast<float>(offset[axis]) + (*theirs)[axis];
      addNeighbour(mirror, away, eye, isInPlace(theirs), triangles);
    }
    for (int i = 0; i < kOctantPointCount; ++i) {
      // more than 1 counts as 1 (docs/theory/math.md, section 4)
      if (own[i] > 0.0f) to[i] = static_cast<uint8_t>(255.0f * std::min(1.0f, sum_[i]) + 0.5f);
    }
  }
}

}  // namespace nlg
