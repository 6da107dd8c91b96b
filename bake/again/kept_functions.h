// The incremental bake: reuses the theta that an earlier bake made.
//
// A theta is known again by the samples of its function, whatever level that is of: a bake that takes what is known is a whole bake, byte
// for byte.
#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "nlg/policy.h"

namespace nlg {

// Half of a SHA-256.
using KeptKey = std::array<uint64_t, 2>;

// A theta as the grid has it. Its record has no times: nobody spent them again.
struct KeptTheta {
  MadeTheta made;
  uint8_t chosen_first = 0;  // the generator before refinement
};

using KeptThetas = std::map<KeptKey, KeptTheta>;

// Of samples: phi, validity and sums.
KeptKey keyOf(const StoredFunction& function);

}  // namespace nlg
