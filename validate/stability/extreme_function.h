// Weighting functions that no scene was asked for, and what a bake makes of any function.
#pragma once

#include <functional>
#include <limits>

#include "runtime_eval/fit/theta_policy.h"
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

// A function through one generator as nlg-bake takes it, but that theta is not rounded.
struct BakedFunction {
  double network_rmse = 0.0, corrected_rmse = 0.0;
  FunctionCheck stored;
  Theta theta;  // that is stored; empty: the bare tent
  bool fails_check = false;
  bool is_finite = false;
  bool never_worse = false;  // corrections did not raise the error, nothing after them the trouble
};
BakedFunction bakeFunction(const NamedGenerator& generator, const StoredFunction& stored, const PolicyOptions& options = {});

// What the stored error of a function may be, beside the threshold tau.
enum class ErrorBound {
  // of functions that levels have: so many times the best that is known of the function in this representation. Above tau and that,
  // the bake has missed what the representation can do
  best_known,
  // of functions that no geometry makes: what one constant does at best in the place of the network or the field. Every
  // representation holds it, and it is the least that a fit must find: for tents that a sigmoid limits, of the function that is 1
  // everywhere nothing is better than the bare tent, .886 off
  constant,
};
inline constexpr double kBestKnownFactor = 1.5;
// Sigmoids come near their ends but never to them, and a fit near its minimum.
inline constexpr double kConstantFactor = 1.01;

// The lowest RMSE of c, of c tent(x) where the representation has the tent, over all constants c that it can output.
double constantRmse(const Representation& representation, const StoredFunction& stored);

// The worst of one function over all generators.
struct WorstBake {
  bool is_finite = true, never_worse = true;
  double network_rmse = 0.0, corrected_rmse = 0.0, stored_rmse = 0.0;
  std::string stored_name;  // of the generator with stored_rmse
  int failing_count = 0;    // generators whose stored theta fails the bake's check
  double best_stored_rmse = std::numeric_limits<double>::infinity();
  double most_of_bound = 0.0;  // the largest stored error over what it may be …
  double bound_rmse = 0.0;     // … and what that one may be
  std::string bound_text;      // … with its generator, and what the bound follows from

  bool holds() const { return is_finite && never_worse && most_of_bound <= 1.0; }
  // The worse of both in everything.
  void add(const WorstBake& other);
};
WorstBake worstBake(const StabilityInputs& inputs, const StoredFunction& stored, ErrorBound bound,
                    const PolicyOptions& options = {});

// "nearest to its bound: .0449 of .0512, pf3 (best known .0341 by direct)".
std::string describeBound(const WorstBake& worst);

}  // namespace nlg
