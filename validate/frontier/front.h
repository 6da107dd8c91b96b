// Finds the points on the Pareto front of time and error, beyond noise.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "validate/generators/statistics.h"

namespace nlg {

struct FrontPoint {
  double us = 0.0, error = 0.0;  // error: mean blend RMSE
  bool may_be_member = true;
};

// Shares: times that differ by less count as equal, errors that differ by less count as equal.
struct FrontTolerances {
  double time = 0.1, error = 0.02;  // those of every front that is written
};

// Whether each point is a member.
//
// A point is beaten when another one has an error smaller beyond the tolerance and is not slower beyond it. Of those that are not
// beaten, from the fastest on, each is a member whose error is smaller beyond the tolerance than that of the member before it; of
// points that equal a member in both, the first of the list stands for it.
std::vector<bool> frontMembers(const std::vector<FrontPoint>& points, const FrontTolerances& tolerances);

// One sentence on the whole front: "Of 60 ways from a function to its θ, 9 are beaten by none in both time and mean blend RMSE over
// hard functions: from NAME (7.4 µs, mean blend RMSE 0.00275) to NAME (22 ms, 0.0018)." Without members that nothing is better than the tent.
// population   "hard functions"
// names        of the points, in the same order
std::string frontSentence(const std::string& population, const std::vector<FrontPoint>& points, const std::vector<bool>& members,
                          const std::vector<std::string>& names);

// "So many times faster than direct at equal error": what direct fits take to exactly the error that the generator's theta has. Errors are
// blend RMSEs: both sides minimise the one loss.
//
// Of a family of fits, a budget counts where no other budget of the family beats it in both mean time and mean error. Between two
// budgets that count, time follows error on a straight line in logarithms. The baseline is the family that is the fastest at the error.

// A point on the same functions as all others.
struct TimedPoint {
  std::string family, label;
  std::vector<double> us, blend_rmse;  // by function, above 0
  std::vector<double> fails_check;     // by function, 1 or 0
};

struct Ratio {
  double value = 0.0;
  double low = 0.0;
  std::optional<double> high;  // none: no bound, since too many resamples have no fit that reaches the error
};

struct EqualError {
  double time_us = 0.0, blend_rmse_mean = 0.0;  // means over functions
  Interval share_failing;                       // of the functions
  std::string baseline;                         // in words; empty when there is no ratio
  double baseline_us = 0.0;                     // at exactly blend_rmse_mean
  // of the baseline's at the same error: between two budgets as far from either as the error is, in logarithms
  Interval baseline_share_failing;
  std::optional<Ratio> ratio;        // baseline_us over time_us, with a 95 % interval
  std::string reason;                // why there is none
  std::optional<double> longest_us;  // mean time of the longest fit, where none reaches the error
};

// baselines   points of a family next to each other
// bootstrap   over the scenes of the functions
EqualError compareAtEqualError(const TimedPoint& own, const std::vector<TimedPoint>& baselines, const SceneBootstrap& bootstrap);

}  // namespace nlg
