// "So many times faster than direct at equal error": what direct fits take to exactly the error that the generator's theta has. Errors are
// blend RMSEs: both sides minimise the one loss.
//
// Of a family of fits, a budget counts where no other budget of the family beats it in both mean time and mean error. Between two
// budgets that count, time follows error on a straight line in logarithms. The rival is the family that is the fastest at the error.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "validate/errors/bootstrap.h"

namespace nlg {

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
  std::string rival;                            // in words; empty when there is no ratio
  double rival_us = 0.0;                        // at exactly blend_rmse_mean
  // of the rival's at the same error: between two budgets as far from either as the error is, in logarithms
  Interval rival_share_failing;
  std::optional<Ratio> ratio;        // rival_us over time_us, with a 95 % interval
  std::string reason;                // why there is none
  std::optional<double> longest_us;  // mean time of the longest fit, where none reaches the error
};

// rivals      points of a family next to each other
// bootstrap   over the scenes of the functions
EqualError compareAtEqualError(const TimedPoint& own, const std::vector<TimedPoint>& rivals, const SceneBootstrap& bootstrap);

}  // namespace nlg
