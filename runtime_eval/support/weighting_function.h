// A weighting function as the fitting kernels read it: samples and mask as floats, in stratum order.
#pragma once

#include <array>
#include <cstdint>

#include "runtime_eval/support/aligned.h"
#include "runtime_eval/support/support_pattern.h"

namespace nlg {

// One function as a data set stores it. Both pointers must outlive the view.
struct StoredFunction {
  const uint8_t* phi = nullptr;       // P, round(255 phi), pattern order
  const uint8_t* validity = nullptr;  // P / 8, bit i of byte b is point 8 b + i
};

// Decodes one stratum of a stored function, mirrored by `mirror` (bits as in SupportPattern; 0 leaves it as it is).
// phi, mask   kStratumPointCount each; mask is 1 at valid points, 0 at others; phi is in [0, 1]
// returns     how many points of the stratum are valid
int decodeStratum(const StoredFunction& stored, int stratum, int mirror, float* phi, float* mask);

struct WeightingFunction {
  AlignedFloats phi;                             // P, stratum order, [0, 1]
  AlignedFloats mask;                            // P, 1 at valid points, 0 at others
  std::array<int, kStratumCount> valid_count{};  // by stratum
  int validCount() const;
};

// All strata of a stored function.
WeightingFunction decodeFunction(const StoredFunction& stored, int mirror = 0);

// The bare tent, valid everywhere: the function of a probe in free space.
WeightingFunction tentFunction();

}  // namespace nlg
