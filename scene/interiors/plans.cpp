#include "scene/interiors/plans.h"

#include <cmath>
#include <numeric>

namespace nlg {

double pickFine(Level& level, double low, double high) {
  const int steps = static_cast<int>((high - low) * 100.0 + 0.5);
  return low + 0.01 * level.random.below(static_cast<uint32_t>(steps + 1));
}

std::vector<double> partLength(Level& level, double from, double to, double wall_m, const std::vector<double>& weights) {
  std::vector<double> drawn;
  for (const double weight : weights) drawn.push_back(weight * level.random.uniform(0.88, 1.12));
  const double all = std::accumulate(drawn.begin(), drawn.end(), 0.0);
  const double length = to - from - wall_m * (static_cast<double>(weights.size()) - 1.0);
  std::vector<double> ends;
  double at = from;
  for (size_t i = 0; i < drawn.size(); ++i) {
    const double end = i + 1 == drawn.size() ? to : at + length * drawn[i] / all;
    ends.push_back(at);
    ends.push_back(end);
    at = end + wall_m;
  }
  return ends;
}

void addGroundPlate(Home& home, const Rect& area, double top_m) {
  home.level.mesh.beginObject("ground", Mobility::structure);
  addBox(home.level.mesh, {}, {area.x0, top_m - 1.0, area.z0}, {area.x1, top_m, area.z1}, home.level.palette.ground);
}

}  // namespace nlg
