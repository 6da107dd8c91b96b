// The incremental bake: reuses the functions of an earlier bake of the same level, except those that a change affects.
//
// Nothing here says which level it is of. A probe is known again by what its support holds, bit for bit, and by what was asked of the
// rest of the scene: that is asked again, and where an answer differs the probe is seen anew. A theta is known again by the samples of
// its function. So a bake that takes what is known is a whole bake, byte for byte.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "datagen/weighting/weighting_builder.h"
#include "nlg/policy.h"

namespace nlg {

// Half of a SHA-256.
using KeptKey = std::array<uint64_t, 2>;
struct KeptKeyHash {
  size_t operator()(const KeptKey& key) const { return key[0]; }
};

// A theta as the grid has it. Its record has no times: nobody spent them again.
struct KeptTheta {
  MadeTheta made;
  uint8_t chosen_first = 0;  // the generator before refinement
};

// A function that takes a theta, or duplicates one that does.
struct KeptFunction {
  KeptKey key{};                   // keyOf its samples
  std::vector<uint8_t> packed;     // packSamples
  std::optional<KeptTheta> theta;  // where the function stood for its duplicates
};

// What a probe came to that has triangles in its support.
struct KeptProbe {
  KeptKey key{};                   // keyOf its support
  std::vector<FarQuestion> asked;  // in order
  ProbeOutcome outcome = ProbeOutcome::empty;
  LocalPoint eye{};                        // of a function: from where it sees
  uint8_t flags = 0;                       // of a function: FunctionFlag
  std::optional<double> bare_tent_rmse;    // of a function that the bare tent stands for
  std::shared_ptr<KeptFunction> function;  // of any other one
};

using KeptProbes = std::vector<KeptProbe>;

// Of the triangles in the support of the probe that was begun last, in any order, the vote of its own place, and the eyes around it.
KeptKey keyOf(const WeightingBuilder& begun);
// Of samples: phi, validity and sums.
KeptKey keyOf(const StoredFunction& function);

inline constexpr size_t kKeptSampleBytes = 2 * kSupportPointCount + kValidityByteCount;
std::vector<uint8_t> packSamples(const StoredFunction& function);
// samples   overwritten with kKeptSampleBytes: phi, then validity, then sums
// returns   whether these are packed samples
bool unpackSamples(const std::vector<uint8_t>& packed, std::vector<uint8_t>* samples);

// Finds what is known again. Any number of threads may ask.
class KeptIndex {
 public:
  // probes   must outlive it
  explicit KeptIndex(const KeptProbes& probes);

  // What the probe came to that was begun last; null where it has to be seen anew.
  const KeptProbe* findProbe(const WeightingBuilder& begun, const KeptKey& key) const;
  std::shared_ptr<KeptFunction> findFunction(const KeptKey& key) const;  // null where there is none

 private:
  std::unordered_multimap<KeptKey, const KeptProbe*, KeptKeyHash> probes_;
  std::unordered_map<KeptKey, std::shared_ptr<KeptFunction>, KeptKeyHash> functions_;
};

// Leaves each probe and each function once.
void mergeAlike(KeptProbes* probes);

}  // namespace nlg
