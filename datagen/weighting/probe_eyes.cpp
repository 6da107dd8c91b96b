#include "datagen/weighting/probe_eyes.h"

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {

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

}  // namespace nlg
