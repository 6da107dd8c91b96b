// Weighting functions that no scene was asked for, and what a bake makes of any function.
#pragma once

#include <functional>
#include <limits>

#include "runtime_eval/fit/function_check.h"
#include "runtime_eval/fit/refinement.h"
#include "validate/stability/stability_case.h"

namespace nlg {

inline const LocalPoint& pointAt(int point) { return supportPattern().points[point]; }

// One function as a data set stores it.
struct SampledFunction {
  std::vector<uint8_t> phi = std::vector<uint8_t>(kSupportPointCount, 0);         // round(255 phi)
  std::vector<uint8_t> validity = std::vector<uint8_t>(kValidityByteCount, 255);  // bits
  StoredFunction view() const { return {phi.data(), validity.data()}; }
  bool valid(int point) const { return (validity[point / 8] >> (point % 8) & 1) != 0; }
};

// phi     of a support point's index, in [0, 1]; stored as 0 where the point is not valid
// valid   of the same; by default every point is
SampledFunction sampleFunction(
    const std::function<double(int)>& phi, const std::function<bool(int)>& valid = [](int) { return true; });

// A probe beside an endless wall: the tent up to a plane at this distance, solid for a tenth of the spacing, nothing behind.
// seed   the direction of the wall
SampledFunction functionBesideWall(uint64_t seed, double distance);

// RMSE of answering 0 everywhere, over valid points; 0 when there are none.
double rmseOfZero(const SampledFunction& function);

// A function through one generator as nlg-bake takes it: network, correction, check and, where that fails, refinement.
struct BakedFunction {
  double generated_rmse = 0.0, corrected_rmse = 0.0;
  FunctionCheck check;  // of the theta that is stored
  bool is_finite = false;
  bool never_worse = false;  // correction did not raise the error, refinement not the trouble
};
BakedFunction bakeFunction(const NamedGenerator& generator, const StoredFunction& stored, const RefinementOptions& options);

// The bake's own refinement; one round of it where the suite is brief.
RefinementOptions bakeOptions(const StabilityInputs& inputs);

// The worst of one function over all generators.
struct WorstBake {
  bool is_finite = true, never_worse = true;
  double generated_rmse = 0.0, corrected_rmse = 0.0, final_rmse = 0.0;
  std::string final_name;  // of the generator with final_rmse
  int failing_count = 0;   // generators whose stored theta fails the bake's check
  double best_final_rmse = std::numeric_limits<double>::infinity();
};
WorstBake worstBake(const StabilityInputs& inputs, const StoredFunction& stored);

}  // namespace nlg
