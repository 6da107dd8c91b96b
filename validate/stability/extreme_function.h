// Extreme weighting functions, beyond those of scenes, and the worst errors of bakes on them.
#pragma once

#include <functional>

#include "nlg/policy.h"
#include "validate/stability/stability_case.h"

namespace nlg {

inline const LocalPoint& pointAt(int point) { return supportPattern().points[point]; }

// One function as a data set stores it.
struct SampledFunction {
  std::vector<uint8_t> phi = std::vector<uint8_t>(kSupportPointCount, 0);         // round(255 phi)
  std::vector<uint8_t> validity = std::vector<uint8_t>(kValidityByteCount, 255);  // bits
  StoredFunction view() const { return {phi.data(), validity.data()}; }
};

// phi     of a support point's index, cut to [0, 1]; stored as 0 where the point is not valid
// valid   of the same; by default every point is
SampledFunction sampleFunction(
    const std::function<double(int)>& phi, const std::function<bool(int)>& valid = [](int) { return true; });

// A probe beside an endless wall: the tent up to a plane at this distance, solid for a tenth of the spacing, nothing behind.
// seed   the direction of the wall
SampledFunction functionBesideWall(uint64_t seed, double distance);

// What a bake may come to above the best that is known of a function.
inline constexpr double kBestKnownFactor = 1.5;

// What the stored error of a function may be where it fails the check.
enum class ErrorBound {
  // of functions that levels have: kBestKnownFactor times the best blend RMSE that is known of the function in this representation. Above both thresholds
  // and that, the bake has missed what the representation can do
  best_known,
  // of functions that no geometry makes: 1.01 times the blend RMSE or the trouble (check.h) of the best constant in the place of the network or
  // the field. Every representation holds a constant, so a fit must find one that is as good. For tents that a sigmoid limits, nothing fits
  // the function that is 1 everywhere better than the bare tent, which is .886 off
  constant,
};

// The worst of some functions, each taken through a generator as nlg-bake takes it, but that theta is not rounded.
class WorstBake {
 public:
  void add(const StabilityInputs& inputs, const NamedGenerator& generator, const StoredFunction& stored, ErrorBound bound,
           const PolicyOptions& options = {});
  // … with every generator.
  void addAll(const StabilityInputs& inputs, const StoredFunction& stored, ErrorBound bound, const PolicyOptions& options = {}) {
    for (const NamedGenerator& generator : inputs.generators) add(inputs, generator, stored, bound, options);
  }

  // What must hold: theta is finite, no stage makes it worse, the stored error keeps to its bound. Nothing where nothing was added.
  void report(StabilityFigures* figures) const;

 private:
  int bake_count_ = 0, failing_count_ = 0;  // of bakes, and of those whose theta fails the bake's check
  bool is_finite_ = true, never_worse_ = true;
  double network_rmse_ = 0.0, corrected_rmse_ = 0.0, stored_rmse_ = 0.0;
  double most_of_bound_ = -1.0;  // the largest stored error over what it may be …
  std::string nearest_;          // … with its generator, and what that bound follows from
};

}  // namespace nlg
