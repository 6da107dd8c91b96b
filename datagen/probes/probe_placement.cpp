#include "datagen/probes/probe_placement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/printable.h"

namespace nlg {
namespace {

constexpr double kAlignedUnits = 1e-4;  // of a spacing: an extent that is longer by less is as long
constexpr double kCertainlyMore = 2.0;  // of a limit: an estimate beyond it is no error of the estimate
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

ExtentBox extentToCover(const Scene& scene, const ProbePlacementOptions& options, double spacing_m) {
  ExtentBox box = probeExtent(scene, options);
  for (int axis = 0; axis < 3 && !options.extent && !scene.extent; ++axis) {
    // a scene thinner than a spacing, such as a flat sheet, has its probes on both sides
    if (box.high_m[axis] - box.low_m[axis] >= spacing_m) continue;
    box.low_m[axis] -= spacing_m;
    box.high_m[axis] += spacing_m;
  }
  return box;
}

// Where a tree stands: its frame, and the units that hold the extent's lowest and highest position.
struct Lattice {
  ProbeTreeFrame frame;
  LatticePoint first{}, last{};
  int32_t least_side = 1;  // units, of cells in no box with a spacing of its own

  double cellCount() const {
    double cells = 1.0;
    for (int axis = 0; axis < 3; ++axis) cells *= last[axis] - first[axis] + 1.0;
    return cells;
  }
  // Of a uniform tree, and of any other at most: n cells along an axis have n + 1 probes.
  double probeLimit() const {
    double probes = 1.0;
    for (int axis = 0; axis < 3; ++axis) probes *= last[axis] - first[axis] + 2.0;
    return probes;
  }
};

// None where a lattice cannot be so long, or the box is not finite.
// shift_units   of the lattice against the box's low corner
std::optional<Lattice> latticeOver(const ExtentBox& box, double spacing_m, const glm::dvec3& shift_units, bool is_aligned) {
  Lattice lattice;
  ProbeTreeFrame& frame = lattice.frame;
  frame.spacing_m = spacing_m;
  for (int axis = 0; axis < 3; ++axis) {
    const double furthest = std::max(std::abs(box.low_m[axis]), std::abs(box.high_m[axis]));
    const double side_m = box.high_m[axis] - box.low_m[axis];
    if (!(furthest / spacing_m < kMaxUnits && side_m / spacing_m < kMaxLatticeSide - 2 * kRootSide)) return std::nullopt;
    frame.first_m[axis] = box.low_m[axis] - spacing_m * shift_units[axis];
    // the expressions of the look-up, so that they round alike
    lattice.first[axis] = static_cast<int32_t>((box.low_m[axis] - frame.first_m[axis]) / spacing_m);
    const double end = (box.high_m[axis] - frame.first_m[axis]) / spacing_m;
    lattice.last[axis] = static_cast<int32_t>(end);
    // cells are half open, but an extent of whole spacings needs none behind it; spacing_m is rounded to a float
    if (is_aligned && lattice.last[axis] > 0 && end - lattice.last[axis] < kAlignedUnits) --lattice.last[axis];
    frame.root_count[axis] = lattice.last[axis] / kRootSide + 1;
  }
  return lattice;
}

constexpr int kMostHalvings = 5;  // of the spacing, for boxes: cells outside have still a side below a root's

// Whether these have a position in common that is on no face.
bool overlaps(const ExtentBox& a, const ExtentBox& b) {
  return glm::all(glm::lessThan(a.low_m, b.high_m)) && glm::all(glm::lessThan(b.low_m, a.high_m));
}

// Boxes with a spacing of their own that reach into the extent, relative to the scene's origin; their spacing is the nearest that cells
// can have. outside   receives the nodes of the others
std::vector<DensityBox> boxesIn(const ExtentBox& extent, const Scene& scene, const ProbePlacementOptions& options,
                                double spacing_m, std::vector<std::string>* outside) {
  std::vector<DensityBox> boxes;
  for (DensityBox of : options.density) {
    if (of.spacing_m > 0.0) {
      const double steps = std::round(std::log2(of.spacing_m / spacing_m));
      if (steps < -kMostHalvings)
        throw UsageError(
            "nlg_density of '" + of.node + "'",
            "0, or at least " + numberText(std::ldexp(spacing_m, -kMostHalvings)) + " m, a 32nd of the spacing elsewhere",
            numberText(of.spacing_m) + " m");
      of.spacing_m = spacing_m * std::exp2(std::min(steps, std::log2(kRootSide)));
    }
    of.box = {of.box.low_m - scene.origin_m, of.box.high_m - scene.origin_m};
    if (overlaps(of.box, extent)) {
      boxes.push_back(of);
    } else {
      outside->push_back(of.node);
    }
  }
  return boxes;
}

// How often a spacing is halved to be that of the finest box.
int halvings(const std::vector<DensityBox>& boxes, double spacing_m) {
  int count = 0;
  for (const DensityBox& of : boxes) {
    while (of.spacing_m > 0.0 && std::ldexp(spacing_m, -count) > of.spacing_m) ++count;
  }
  return count;
}

// Judges cells by the extent, by boxes with a spacing of their own, and by the nearest triangle.
class Density {
 public:
  Density(const NearbyTriangles& nearby, const Lattice& lattice, double growth, const std::vector<DensityBox>& boxes = {})
      : nearby_(nearby), lattice_(lattice), growth_(growth), boxes_(boxes) {}

  CellVerdict judge(const ProbeCell& cell) const {
    const ProbeTreeFrame& frame = lattice_.frame;
    glm::dvec3 low;
    for (int axis = 0; axis < 3; ++axis) {
      if (cell.low[axis] > lattice_.last[axis] || cell.low[axis] + cell.side <= lattice_.first[axis])
        return CellVerdict::unneeded;
      low[axis] = frame.first_m[axis] + frame.spacing_m * cell.low[axis];
    }
    const double side_m = frame.spacing_m * cell.side;
    const ExtentBox at{low, low + side_m};
    bool is_too_coarse = false, is_inside = false;
    for (const DensityBox& of : boxes_) {
      if (!overlaps(of.box, at)) continue;
      const bool holds =
          glm::all(glm::lessThanEqual(of.box.low_m, at.low_m)) && glm::all(glm::lessThanEqual(at.high_m, of.box.high_m));
      if (of.spacing_m == 0.0 && holds) return CellVerdict::unneeded;
      if (of.spacing_m == 0.0) continue;
      is_too_coarse |= cell.side > 1 && side_m > of.spacing_m;
      is_inside |= holds;
    }
    if (is_too_coarse) return CellVerdict::too_coarse;
    if (is_inside || cell.side <= lattice_.least_side) return CellVerdict::fits;
    if (growth_ == 0.0) return CellVerdict::too_coarse;
    return nearby_.anyCloser(at.low_m, at.high_m, side_m / growth_) ? CellVerdict::too_coarse : CellVerdict::fits;
  }

 private:
  const NearbyTriangles& nearby_;
  const Lattice& lattice_;
  double growth_;
  std::vector<DensityBox> boxes_;
};

// Side of the cell that the tree has at a unit: the rule of ProbeTree::build, for the nodes around one unit alone.
int32_t cellSideAt(const LatticePoint& unit, const Density& density) {
  const auto low = [&](int32_t side) {
    LatticePoint corner;
    for (int axis = 0; axis < 3; ++axis) corner[axis] = unit[axis] & -side;
    return corner;
  };
  const auto isCoarse = [&](const ProbeCell& cell) { return density.judge(cell) == CellVerdict::too_coarse; };
  for (int32_t node_side = kRootSide; node_side > 1; node_side /= 4) {
    if (!isCoarse({low(node_side), node_side})) return node_side;
    const LatticePoint node = low(node_side);
    const int32_t half = node_side / 2, quarter = node_side / 4;
    bool all_fit = true;
    for (int c = 0; c < 8 && all_fit; ++c)
      all_fit = !isCoarse({{node[0] + half * (c & 1), node[1] + half * (c >> 1 & 1), node[2] + half * (c >> 2)}, half});
    if (all_fit) return half;
    if (quarter == 1 || !isCoarse({low(quarter), quarter})) return quarter;
  }
  return 1;
}

// Roberts's sequence in the unit cube: any number of its first points is evenly spread.
glm::dvec3 evenlySpread(int i) {
  return glm::fract(0.5 + glm::dvec3(0.8191725133961645, 0.6710436067037893, 0.5497004779019703) * (i + 1.0));
}

constexpr int kEstimatePlaces = 4096;

// Cells by evenly spread places, each with the share of the extent that one cell there is; probes as a box of cells has.
// boxes   none of them finer than the lattice
double probesOn(const Lattice& lattice, const NearbyTriangles& nearby, double growth, const std::vector<DensityBox>& boxes = {}) {
  if (growth == 0.0 && boxes.empty()) return lattice.probeLimit();
  const Density density(nearby, lattice, growth, boxes);
  double share = 0.0;
  for (int i = 0; i < kEstimatePlaces; ++i) {
    const glm::dvec3 at = evenlySpread(i);
    LatticePoint unit;
    for (int axis = 0; axis < 3; ++axis)
      unit[axis] = lattice.first[axis] + static_cast<int32_t>(at[axis] * (lattice.last[axis] - lattice.first[axis] + 1));
    const int32_t side = cellSideAt(unit, density);
    // the low corner of a cell: sides are powers of two
    for (int axis = 0; axis < 3; ++axis) unit[axis] &= -side;
    // places meet a cell in proportion to its volume: the inverse counts every cell once
    if (density.judge({unit, side}) != CellVerdict::unneeded) share += 1.0 / (static_cast<double>(side) * side * side);
  }
  return lattice.probeLimit() * share / kEstimatePlaces;
}

// The share of a box in which it rules: no finer one does, and none as fine before it. Boxes may stand in each other.
double ruledShare(const std::vector<DensityBox>& fine, size_t box) {
  constexpr int kPlaces = 64;
  const ExtentBox& own = fine[box].box;
  int ruled = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const glm::dvec3 at = own.low_m + evenlySpread(i) * (own.high_m - own.low_m);
    bool is_ruled = true;
    for (size_t other = 0; other < fine.size() && is_ruled; ++other) {
      const bool is_before =
          fine[other].spacing_m < fine[box].spacing_m || (fine[other].spacing_m == fine[box].spacing_m && other < box);
      // with its faces: a box may be flat
      const bool holds =
          glm::all(glm::lessThanEqual(fine[other].box.low_m, at)) && glm::all(glm::lessThanEqual(at, fine[other].box.high_m));
      is_ruled = !is_before || !holds;
    }
    ruled += is_ruled ? 1 : 0;
  }
  return static_cast<double>(ruled) / kPlaces;
}

// What boxes finer than a lattice add to its probes.
// coarse   boxes that are not
double probesOfFine(const Lattice& lattice, const std::vector<DensityBox>& fine, const std::vector<DensityBox>& coarse,
                    const NearbyTriangles& nearby, double growth) {
  constexpr double kNodeCells = 4.0;  // along an axis; nodes that a box reaches into are divided whole
  double probes = 0.0;
  for (size_t box = 0; box < fine.size(); ++box) {
    const DensityBox& of = fine[box];
    const double ruled = ruledShare(fine, box);
    if (ruled == 0.0) continue;
    Lattice inside = lattice;
    double own = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto unit = [&](double at_m) {
        const double units = (at_m - lattice.frame.first_m[axis]) / lattice.frame.spacing_m;
        return std::clamp<double>(units, lattice.first[axis], lattice.last[axis] + 1.0);
      };
      const double low = unit(of.box.low_m[axis]), high = unit(of.box.high_m[axis]);
      inside.first[axis] = std::min(static_cast<int32_t>(low), lattice.last[axis]);
      inside.last[axis] = std::min(static_cast<int32_t>(high), lattice.last[axis]);
      own *= (high - low) * lattice.frame.spacing_m / of.spacing_m + kNodeCells + 1.0;
    }
    probes += ruled * std::max(0.0, own - probesOn(inside, nearby, growth, coarse));
  }
  return probes;
}

// A finest spacing that keeps the limit: for certain where all of the extent may be finest, else by the estimate, with room for
// its error and for other shifts of the lattice. Infinite where not even one cell does.
double fittingSpacing(const ExtentBox& box, const NearbyTriangles& nearby, double spacing_m, double growth, uint64_t max_probes) {
  const auto limit = static_cast<double>(max_probes);
  // no probes fewer than three along an axis, as extents of a thin scene have them
  if (limit < 27.0) return HUGE_VAL;
  while (std::isfinite(spacing_m)) {
    const std::optional<Lattice> lattice = latticeOver(box, spacing_m, glm::dvec3(0.999), false);
    double excess = 8.0;
    if (lattice) excess = std::min(lattice->probeLimit(), 1.3 * probesOn(*lattice, nearby, growth)) / limit;
    if (excess <= 1.0) break;
    // probes fall with the square of the spacing at least, and with its cube at most
    spacing_m *= std::max(1.03, std::cbrt(excess));
  }
  return spacing_m;
}

constexpr size_t kMostFarObjects = 4;
constexpr double kMuchSmaller = 0.25;

// A few objects without which the scene would be much smaller, in words; empty where there are none.
std::string farObjects(const Scene& scene) {
  std::vector<std::pair<const SceneObject*, ExtentBox>> left;
  for (const SceneObject& object : scene.objects) {
    const Bounds bounds = objectBounds(scene, object);
    left.push_back({&object, {bounds.min, bounds.max}});
  }
  const auto join = [](const ExtentBox& a, const ExtentBox& b) {
    return ExtentBox{glm::min(a.low_m, b.low_m), glm::max(a.high_m, b.high_m)};
  };
  // along a side that is shorter than a room nothing is far
  constexpr double kRoom = 10.0;
  const auto sizeOf = [](const ExtentBox& box) {
    const glm::dvec3 sides = box.high_m - box.low_m + kRoom;
    return sides.x * sides.y * sides.z;
  };
  double whole = 0.0;
  std::string names;
  size_t triangles_left = scene.triangles.size();
  for (size_t count = 0; count <= kMostFarObjects; ++count) {
    // boxes of all objects before each, and of all from each on
    const ExtentBox nothing{glm::dvec3(HUGE_VAL), glm::dvec3(-HUGE_VAL)};
    std::vector<ExtentBox> before(left.size() + 1, nothing), from(left.size() + 1, nothing);
    for (size_t i = 0; i < left.size(); ++i) before[i + 1] = join(before[i], left[i].second);
    for (size_t i = left.size(); i-- > 0;) from[i] = join(from[i + 1], left[i].second);
    if (count == 0) whole = sizeOf(from[0]);
    const glm::dvec3 sides = from[0].high_m - from[0].low_m;
    if (count > 0 && sizeOf(from[0]) <= kMuchSmaller * whole)
      return "without " + names + " " + numberText(sides.x) + " x " + numberText(sides.y) + " x " + numberText(sides.z) +
             " m; a box named nlg_extent, or extent_m, says where probes are needed";
    // the level itself is no stray, however small the rest would be
    const auto isLevel = [&](size_t i) { return 2 * left[i].first->triangle_count > triangles_left; };
    const auto sizeWithout = [&](size_t i) { return sizeOf(join(before[i], from[i + 1])); };
    size_t furthest = left.size();
    for (size_t i = 0; i < left.size(); ++i) {
      if (!isLevel(i) && (furthest == left.size() || sizeWithout(i) < sizeWithout(furthest))) furthest = i;
    }
    if (furthest == left.size()) break;
    triangles_left -= left[furthest].first->triangle_count;
    names += (names.empty() ? "'" : ", '") + left[furthest].first->name.substr(0, 40) + "'";
    left.erase(left.begin() + static_cast<ptrdiff_t>(furthest));
  }
  return "";
}

[[noreturn]] void refuse(const NearbyTriangles& nearby, const ExtentBox& box, double spacing_m, double probes,
                         const ProbePlacementOptions& options, double of_boxes = 0.0) {
  const Scene& scene = nearby.scene();
  const double others = std::max(0.0, static_cast<double>(options.max_probes) - std::max(0.0, of_boxes));
  const double fitting = fittingSpacing(box, nearby, spacing_m, options.density_growth, static_cast<uint64_t>(others));
  const std::string expected = "at most " + std::to_string(options.max_probes) + " probes" +
                               (options.max_probes < kMaxTreeProbes ? " (max_probes)" : "") +
                               (std::isfinite(fitting) ? "; a finest spacing of " + numberText(1.001 * fitting) + " m fits" : "");
  const glm::dvec3 side_m = box.high_m - box.low_m;
  const std::string smaller = options.extent || scene.extent ? "" : farObjects(scene);
  throw UsageError(scene.id, expected,
                   (probes > 0.0 ? "about " + roughCountText(probes, "probe") + ": " : "") +
                       (of_boxes > 0.0 ? "boxes with nlg_density, about " + roughCountText(of_boxes, "probe") + ", and " : "") +
                       "spacing " + numberText(spacing_m) + " m over " + numberText(side_m.x) + " x " + numberText(side_m.y) +
                       " x " + numberText(side_m.z) + " m" + (smaller.empty() ? "" : "; " + smaller));
}

// Refuses what is far beyond the limit by an estimate; a uniform tree's is none.
void refuseFarTooMany(const NearbyTriangles& nearby, const ExtentBox& box, const Lattice& lattice,
                      const std::vector<DensityBox>& boxes, const ProbePlacementOptions& options) {
  const auto limit = static_cast<double>(options.max_probes);
  std::vector<DensityBox> fine, coarse;
  for (const DensityBox& of : boxes) (of.spacing_m > 0.0 && of.spacing_m < lattice.frame.spacing_m ? fine : coarse).push_back(of);
  const double of_boxes = probesOfFine(lattice, fine, coarse, nearby, options.density_growth);
  const double probes = probesOn(lattice, nearby, options.density_growth, coarse) + of_boxes;
  const bool is_certain = options.density_growth == 0.0 && boxes.empty() && lattice.cellCount() > limit;
  if (is_certain || probes > kCertainlyMore * limit) refuse(nearby, box, lattice.frame.spacing_m, probes, options, of_boxes);
}

// What a seed draws.
struct Draw {
  double spacing_m;
  glm::dvec3 shift_units;
};
Draw drawOf(const ProbePlacementOptions& options, uint64_t seed) {
  Random random(mixSeed(seed, 0x74726565));
  // a float, so that every probe's spacing is exact in the data set
  const double spacing_m =
      static_cast<float>(options.spacing_min_m * std::pow(options.spacing_max_m / options.spacing_min_m, random.uniform()));
  glm::dvec3 shift;
  for (int axis = 0; axis < 3; ++axis) shift[axis] = random.uniform() * kRootSide;
  return {spacing_m, options.align_lattice ? glm::dvec3(0.0) : shift};
}

bool hasExtent(const Scene& scene, const ProbePlacementOptions& options) {
  return !scene.triangles.empty() || options.extent || scene.extent;
}

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

ExtentBox probeExtent(const Scene& scene, const ProbePlacementOptions& options) {
  for (const std::optional<ExtentBox>& extent : {options.extent, scene.extent}) {
    if (extent) return {extent->low_m - scene.origin_m, extent->high_m - scene.origin_m};
  }
  const Bounds bounds = sceneBounds(scene);
  ExtentBox box{bounds.min, bounds.max};
  if (options.reach) {
    box.low_m = glm::min(box.low_m, options.reach->low_m - scene.origin_m);
    box.high_m = glm::max(box.high_m, options.reach->high_m - scene.origin_m);
  }
  return box;
}

ChosenSpacing chooseSpacing(const NearbyTriangles& nearby, ProbePlacementOptions options) {
  constexpr double kRoomSpacing = 0.5, kCellsOfSmall = 8.0, kOrdinary = 1.0;
  const Scene& scene = nearby.scene();
  ChosenSpacing chosen;
  if (!hasExtent(scene, options)) return chosen;
  const ExtentBox box = probeExtent(scene, options);
  const glm::dvec3 sides = box.high_m - box.low_m;
  const double largest = std::max({sides.x, sides.y, sides.z});
  const auto probesAt = [&](double spacing_m) {
    const auto lattice = latticeOver(extentToCover(scene, options, spacing_m), spacing_m, glm::dvec3(0.5), false);
    return lattice ? probesOn(*lattice, nearby, options.density_growth) : HUGE_VAL;
  };
  // half a metre, or an eighth of a small scene
  const double finest = largest > 0.0 ? std::min(kRoomSpacing, largest / kCellsOfSmall) : kOrdinary;
  const auto spacingAt = [&](int step) { return finest * std::exp2(0.5 * step); };
  int step = 0;
  double probes = probesAt(finest);
  // coarser by the root of two until the number of probes is affordable; beyond a metre more of them are
  while (probes > (spacingAt(step) < kOrdinary ? kManyProbes : kMostChosenProbes)) {
    // only its author knows what so large a scene is for: it is refused at a metre, with a hint
    if (spacingAt(step) > largest) return chosen;
    probes = probesAt(spacingAt(++step));
  }
  // the steps beside it, for the user to compare
  chosen.spacing_m = spacingAt(step), chosen.probes = probes;
  chosen.finer_m = spacingAt(step - 1), chosen.probes_of_finer = probesAt(chosen.finer_m);
  chosen.coarser_m = spacingAt(step + 1), chosen.probes_of_coarser = probesAt(chosen.coarser_m);
  return chosen;
}

ProbeTree placeProbes(const NearbyTriangles& nearby, const ProbePlacementOptions& options, uint64_t seed,
                      PlacedBoxes* placed_boxes) {
  const Scene& scene = nearby.scene();
  checkOptions(options);
  ProbeTree tree;
  if (!hasExtent(scene, options)) return tree;
  const Draw draw = drawOf(options, seed);
  const ExtentBox box = extentToCover(scene, options, draw.spacing_m);
  std::optional<Lattice> lattice = latticeOver(box, draw.spacing_m, draw.shift_units, options.align_lattice);
  if (!lattice) refuse(nearby, box, draw.spacing_m, 0.0, options);
  PlacedBoxes none;
  if (placed_boxes == nullptr) placed_boxes = &none;
  const std::vector<DensityBox> boxes = boxesIn(box, scene, options, draw.spacing_m, &placed_boxes->outside);
  placed_boxes->inside = boxes.size();
  // what is far too much is known without building it for minutes
  if (lattice->probeLimit() > static_cast<double>(options.max_probes) || !boxes.empty())
    refuseFarTooMany(nearby, box, *lattice, boxes, options);
  if (const int count = halvings(boxes, draw.spacing_m); count > 0) {
    lattice = latticeOver(box, std::ldexp(draw.spacing_m, -count), draw.shift_units, options.align_lattice);
    if (!lattice) refuse(nearby, box, draw.spacing_m, 0.0, options);
    lattice->least_side = 1 << count;
  }
  const Density density(nearby, *lattice, options.density_growth, boxes);
  const CellJudge judge = [&](const ProbeCell& cell) { return density.judge(cell); };
  const ProbeTreeStatus status = ProbeTree::build(lattice->frame, judge, options.max_probes, &tree);
  if (status != ProbeTreeStatus::ok) refuse(nearby, box, draw.spacing_m, 0.0, options);
  return tree;
}

}  // namespace nlg
