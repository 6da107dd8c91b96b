#include "validate/frontier/front.h"

#include <fmt/format.h>
#include <algorithm>

namespace nlg {
namespace {

std::vector<size_t> byTime(const std::vector<FrontPoint>& points, const std::vector<size_t>& chosen) {
  std::vector<size_t> order = chosen;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return points[a].us < points[b].us; });
  return order;
}

// Counts as equal: the larger is no more than a share above the smaller.
bool equal(double a, double b, double tolerance) { return std::max(a, b) <= std::min(a, b) * (1.0 + tolerance); }

std::vector<size_t> unbeaten(const std::vector<FrontPoint>& points, const FrontTolerances& tolerances) {
  std::vector<size_t> left;
  for (size_t a = 0; a < points.size(); ++a) {
    const auto beats = [&](const FrontPoint& b) {
      return b.may_be_member && b.us <= points[a].us * (1.0 + tolerances.time) &&
             b.error * (1.0 + tolerances.error) < points[a].error;
    };
    if (points[a].may_be_member && std::none_of(points.begin(), points.end(), beats)) left.push_back(a);
  }
  return left;
}

// Three digits, microseconds or milliseconds.
std::string timeText(double us) { return us < 1000.0 ? fmt::format("{:.3g} µs", us) : fmt::format("{:.3g} ms", us / 1000.0); }

}  // namespace

std::vector<bool> frontMembers(const std::vector<FrontPoint>& points, const FrontTolerances& tolerances) {
  const std::vector<size_t> left = unbeaten(points, tolerances);
  std::vector<bool> members(points.size(), false);
  const FrontPoint* last = nullptr;
  for (const size_t a : byTime(points, left)) {
    if (last && points[a].error * (1.0 + tolerances.error) >= last->error) continue;
    last = &points[a];
    const size_t first = *std::find_if(left.begin(), left.end(), [&](size_t b) {
      return equal(points[a].us, points[b].us, tolerances.time) && equal(points[a].error, points[b].error, tolerances.error);
    });
    members[first] = true;
  }
  return members;
}

std::string frontSentence(const std::string& population, const std::vector<FrontPoint>& points, const std::vector<bool>& members,
                          const std::vector<std::string>& names) {
  std::vector<size_t> chosen;
  for (size_t i = 0; i < points.size(); ++i) {
    if (members[i]) chosen.push_back(i);
  }
  if (chosen.empty())
    return "Over " + population + " nothing has a smaller mean blend RMSE than the bare tent, which takes no time.";
  const auto text = [&](size_t i, const char* what) {
    return fmt::format("{} ({}, {}{:.3g})", names[i], timeText(points[i].us), what, points[i].error);
  };
  const std::vector<size_t> order = byTime(points, chosen);
  const std::string begin = fmt::format(
      "Of {} ways from a function to its θ, {} beaten by none in both time and mean blend RMSE over {}: ", points.size(),
      order.size() == 1 ? "one is" : fmt::format("{} are", order.size()), population);
  if (order.size() == 1) return begin + text(order.front(), "mean blend RMSE ") + '.';
  return begin + "from " + text(order.front(), "mean blend RMSE ") + " to " + text(order.back(), "") + '.';
}

}  // namespace nlg
