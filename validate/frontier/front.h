// Which points stand on the Pareto front of time and error, beyond noise.
#pragma once

#include <string>
#include <vector>

namespace nlg {

struct FrontPoint {
  double us = 0.0, error = 0.0;  // error: mean blend RMSE
  bool may_be_member = true;
};

// Shares: times that differ by less count as equal, errors that differ by less count as equal.
struct FrontTolerances {
  double time = 0.1, error = 0.02;
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

}  // namespace nlg
