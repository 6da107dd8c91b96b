// When two weighting functions count as one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "runtime_eval/support/stored_function.h"

namespace nlg {

// Two functions are duplicates when their validity differs in at most validity_points points and
//   sum over all P points of (difference of phi)^2  <=  rms^2 * (points valid in both):
// the RMSE that one makes in place of the other, over the points valid in both, where a point valid in only one of them adds
// its whole value. Zeros: the same bytes.
struct DuplicateRule {
  double rms = 0.0;              // in steps of the stored samples, 1/255; >= 0
  uint64_t validity_points = 0;  // >= 0

  friend bool operator==(const DuplicateRule&, const DuplicateRule&) = default;
};

// The RMS difference of two duplicates, in 1/255; nothing when they are none. Symmetric, and the same on every machine.
// point_count   P, a multiple of 8
std::optional<double> duplicateDistance(const DuplicateRule& rule, const StoredFunction& a, const StoredFunction& b,
                                        int point_count);

}  // namespace nlg
