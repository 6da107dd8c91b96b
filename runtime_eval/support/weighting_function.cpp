#include "runtime_eval/support/weighting_function.h"

namespace nlg {

int decodeStratum(const StoredFunction& stored, int stratum, int mirror, float* phi, float* mask) {
  // an octant is 1024 samples and 128 validity bytes; bit k of a validity byte belongs to stratum k
  constexpr int kRun = kOctantPointCount / kStratumCount;
  int valid_count = 0;
  for (int m = 0; m < kMirrorCount; ++m) {
    const uint8_t* source = stored.phi + (m ^ mirror) * kOctantPointCount + stratum;
    const uint8_t* bits = stored.validity + (m ^ mirror) * kRun;
    for (int j = 0; j < kRun; ++j) {
      const int valid = (bits[j] >> stratum) & 1;
      phi[m * kRun + j] = static_cast<float>(source[8 * j]) * (1.0f / 255.0f);
      mask[m * kRun + j] = static_cast<float>(valid);
      valid_count += valid;
    }
  }
  return valid_count;
}

int WeightingFunction::validCount() const {
  int total = 0;
  for (const int count : valid_count) total += count;
  return total;
}

WeightingFunction decodeFunction(const StoredFunction& stored, int mirror) {
  WeightingFunction function;
  function.phi.resize(kSupportPointCount);
  function.mask.resize(kSupportPointCount);
  for (int k = 0; k < kStratumCount; ++k) {
    const int first = k * kStratumPointCount;
    function.valid_count[k] = decodeStratum(stored, k, mirror, &function.phi[first], &function.mask[first]);
  }
  return function;
}

WeightingFunction tentFunction() {
  WeightingFunction function;
  function.phi = stratifiedSupportPoints().tent;
  function.mask.assign(kSupportPointCount, 1.0f);
  function.valid_count.fill(kStratumPointCount);
  return function;
}

}  // namespace nlg
