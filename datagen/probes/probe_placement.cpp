#include "datagen/probes/probe_placement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "datagen/probes/nearby_triangles.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kAlignedUnits = 1e-4;  // of a spacing: an extent that is longer by less is as long
constexpr double kMaxUnits = 0x1p40;    // a position further from the scene's origin cannot be told from its neighbours

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

void checkOptions(const ProbePlacementOptions& o) {
  if (!(o.spacing_min_m > 0.0 && std::isfinite(o.spacing_min_m)))
    throw UsageError("spacing_min_m", "a finite number above 0", numberText(o.spacing_min_m));
  if (!(o.spacing_max_m >= o.spacing_min_m && std::isfinite(o.spacing_max_m)))
    throw UsageError("spacing_max_m", "at least spacing_min_m", numberText(o.spacing_max_m));
  if (!(o.density_growth >= 0.0 && std::isfinite(o.density_growth)))
    throw UsageError("density_growth", "a finite number of at least 0", numberText(o.density_growth));
  if (o.max_probes > kMaxTreeProbes)
    throw UsageError("max_probes", "at most " + std::to_string(kMaxTreeProbes), std::to_string(o.max_probes));
}

// What the tree must cover, relative to the scene's origin.
ExtentBox extentToCover(const Scene& scene, const ProbePlacementOptions& options, double spacing_m) {
  if (options.extent) return {options.extent->low_m - scene.origin_m, options.extent->high_m - scene.origin_m};
  const Bounds bounds = sceneBounds(scene);
  ExtentBox box{bounds.min, bounds.max};
  for (int axis = 0; axis < 3; ++axis) {
    // a scene thinner than a spacing, such as a flat sheet, has its probes on both sides
    if (box.high_m[axis] - box.low_m[axis] >= spacing_m) continue;
    box.low_m[axis] -= spacing_m;
    box.high_m[axis] += spacing_m;
  }
  return box;
}

// A finest spacing at which the extent fits even if all of it is finest: n cells along an axis have n + 1 probes, and a shifted
// lattice has up to 2 cells more than the extent is spacings long.
double fittingSpacing(const glm::dvec3& side_m, double spacing_m, uint64_t max_probes) {
  const auto fits = [&](double spacing) {
    double probes = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      // a side that is thinner than the spacing reaches over two of them, see extentToCover
      const double units = std::max(side_m[axis] / spacing, 2.0);
      if (units > kMaxLatticeSide - 2 * kRootSide) return false;
      probes *= units + 3.0;
    }
    return probes <= static_cast<double>(max_probes);
  };
  while (!fits(spacing_m) && std::isfinite(spacing_m)) spacing_m *= 1.05;
  return spacing_m;
}

[[noreturn]] void refuse(const Scene& scene, const glm::dvec3& side_m, double spacing_m, const ProbePlacementOptions& options) {
  const double fitting = fittingSpacing(side_m, spacing_m, options.max_probes);
  const std::string expected =
      "at most " + std::to_string(options.max_probes) + " probes" +
      (std::isfinite(fitting) ? ", which a finest spacing of " + numberText(1.001 * fitting) + " m keeps" : "");
  throw UsageError(scene.id, expected,
                   "spacing " + numberText(spacing_m) + " m over " + numberText(side_m.x) + " x " + numberText(side_m.y) + " x " +
                       numberText(side_m.z) + " m");
}

// Judges cells by the extent, in lattice units, and by the nearest triangle.
class Density {
 public:
  Density(const Scene& scene, const ProbeTreeFrame& frame, const LatticePoint& first, const LatticePoint& last, double growth)
      : nearby_(scene), frame_(frame), first_(first), last_(last), growth_(growth) {}

  CellVerdict judge(const ProbeCell& cell) const {
    glm::dvec3 low;
    for (int axis = 0; axis < 3; ++axis) {
      if (cell.low[axis] > last_[axis] || cell.low[axis] + cell.side <= first_[axis]) return CellVerdict::unneeded;
      low[axis] = frame_.first_m[axis] + frame_.spacing_m * cell.low[axis];
    }
    if (cell.side == 1) return CellVerdict::fits;
    if (growth_ == 0.0) return CellVerdict::too_coarse;
    const double side_m = frame_.spacing_m * cell.side;
    return nearby_.anyCloser(low, low + side_m, side_m / growth_) ? CellVerdict::too_coarse : CellVerdict::fits;
  }

 private:
  NearbyTriangles nearby_;
  const ProbeTreeFrame& frame_;
  LatticePoint first_, last_;  // units that hold the extent's lowest and highest position
  double growth_;
};

}  // namespace

std::optional<ExtentBox> extentFromNumbers(const std::vector<std::string>& numbers) {
  if (numbers.empty()) return std::nullopt;
  std::string all;
  for (const std::string& number : numbers) all += (all.empty() ? "" : " ") + number;
  const UsageError error("extent_m", "six finite numbers: low x, y, z, high x, y, z with low <= high", all);
  if (numbers.size() != 6) throw error;
  ExtentBox box;
  for (int i = 0; i < 6; ++i) {
    char* end = nullptr;
    const double value = std::strtod(numbers[i].c_str(), &end);
    if (numbers[i].empty() || *end != '\0' || !std::isfinite(value)) throw error;
    (i < 3 ? box.low_m : box.high_m)[i % 3] = value;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (box.low_m[axis] > box.high_m[axis]) throw error;
  }
  return box;
}

ProbeTree placeProbes(const Scene& scene, const ProbePlacementOptions& options, uint64_t seed) {
  checkOptions(options);
  Random random(mixSeed(seed, 0x74726565));
  ProbeTreeFrame frame;
  // a float, so that every probe's spacing is exact in the data set
  frame.spacing_m =
      static_cast<float>(options.spacing_min_m * std::pow(options.spacing_max_m / options.spacing_min_m, random.uniform()));
  double shift_units[3] = {random.uniform() * kRootSide, random.uniform() * kRootSide, random.uniform() * kRootSide};
  if (options.align_lattice) std::fill_n(shift_units, 3, 0.0);
  ProbeTree tree;
  if (scene.triangles.empty() && !options.extent) return tree;

  const ExtentBox box = extentToCover(scene, options, frame.spacing_m);
  const glm::dvec3 side_m = box.high_m - box.low_m;
  LatticePoint first, last;
  double finest_cells = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double furthest = std::max(std::abs(box.low_m[axis]), std::abs(box.high_m[axis]));
    // also refuses what is not finite
    if (!(furthest / frame.spacing_m < kMaxUnits && side_m[axis] / frame.spacing_m < kMaxLatticeSide - 2 * kRootSide))
      refuse(scene, side_m, frame.spacing_m, options);
    frame.first_m[axis] = box.low_m[axis] - frame.spacing_m * shift_units[axis];
    // the expressions of the look-up, so that they round alike
    first[axis] = static_cast<int32_t>((box.low_m[axis] - frame.first_m[axis]) / frame.spacing_m);
    const double end = (box.high_m[axis] - frame.first_m[axis]) / frame.spacing_m;
    last[axis] = static_cast<int32_t>(end);
    // cells are half open, but an extent of whole spacings needs none behind it; spacing_m is rounded to a float
    if (options.align_lattice && last[axis] > 0 && end - last[axis] < kAlignedUnits) --last[axis];
    frame.root_count[axis] = last[axis] / kRootSide + 1;
    finest_cells *= last[axis] - first[axis] + 1;
  }
  // a uniform tree is as many cells: known without building it
  if (options.density_growth == 0.0 && finest_cells > static_cast<double>(options.max_probes))
    refuse(scene, side_m, frame.spacing_m, options);
  const Density density(scene, frame, first, last, options.density_growth);
  const CellJudge judge = [&](const ProbeCell& cell) { return density.judge(cell); };
  const ProbeTreeStatus status = ProbeTree::build(frame, judge, options.max_probes, &tree);
  if (status != ProbeTreeStatus::ok) refuse(scene, side_m, frame.spacing_m, options);
  return tree;
}

}  // namespace nlg
