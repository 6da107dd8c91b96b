#include "light/air_places.h"

#include <algorithm>
#include <cmath>

#include "datagen/visibility/cavity.h"
#include "light/air.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/probe_tree/morton.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kBlockCells = 256;
constexpr uint64_t kAirStream = 0x616972;

// Roberts's sequence, the golden ratio's kin in three dimensions: any number of its first points is evenly spread.
glm::dvec3 spreadPoint(const glm::dvec3& shift, int i) {
  constexpr double a = 0.8191725133961645, b = 0.6710436067037893, c = 0.5497004779019703;
  const glm::dvec3 p = shift + glm::dvec3(a, b, c) * static_cast<double>(i);
  return p - glm::floor(p);
}

// What is known of a cell so far.
class CellSurvey {
 public:
  explicit CellSurvey(const RayScene& rays) : rays_(rays), voter_(rays) {}

  void begin() {
    air_.clear();
    solid_.clear();
    closed_.clear();
  }

  bool isInAir(const glm::dvec3& place) {
    // one ray instead of a vote's fourteen. Sky lets through from behind: rays begin on the side that may be its front
    const glm::vec3 here(place);
    const auto isSeenFrom = [&](const glm::dvec3& other) { return !rays_.isLightBlocked(glm::vec3(other), here); };
    const auto sees = [&](const glm::dvec3& other) { return !rays_.isLightBlocked(here, glm::vec3(other)); };
    if (std::any_of(air_.rbegin(), air_.rend(), isSeenFrom)) return remember(air_, place, true);
    if (std::any_of(solid_.rbegin(), solid_.rend(), sees)) return remember(solid_, place, false);
    if (std::any_of(closed_.rbegin(), closed_.rend(), sees)) return rememberClosed(place);
    ++votes_;
    if (voter_.isAir(place)) return isInCavity(rays_, place) ? rememberClosed(place) : remember(air_, place, true);
    // a place with a doubt says nothing of those that it sees: what closed the solid there may be no geometry
    if (solid_.size() < kRemembered && voter_.meetsNoFront(place)) solid_.push_back(place);
    return false;
  }

  uint64_t votes() const { return votes_; }
  uint64_t inCavities() const { return in_cavities_; }

 private:
  static constexpr size_t kRemembered = 4;

  static bool remember(std::vector<glm::dvec3>& known, const glm::dvec3& place, bool verdict) {
    if (known.size() < kRemembered) known.push_back(place);
    return verdict;
  }
  bool rememberClosed(const glm::dvec3& place) {
    ++in_cavities_;
    return remember(closed_, place, false);
  }

  const RayScene& rays_;
  AirVoter voter_;
  std::vector<glm::dvec3> air_, solid_, closed_;
  uint64_t votes_ = 0, in_cavities_ = 0;
};

// A run of cells, surveyed by one thread.
struct Block {
  std::vector<AirPlaces::Cell> cells;
  std::vector<glm::dvec3> places;
  uint64_t drawn = 0, votes = 0, in_cavities = 0;
};

class Surveyor {
 public:
  Surveyor(const RayScene& rays, const ProbeTree& tree, const AirPlaceOptions& options)
      : rays_(rays), tree_(tree), options_(options), survey_(rays) {}

  void survey(const ProbeCell& cell, Block* block) {
    if (!mayHoldAir(cell)) {
      block->cells.push_back({cell});
      return;
    }
    const double spacing_m = tree_.frame().spacing_m;
    glm::dvec3 low;
    for (int axis = 0; axis < 3; ++axis) low[axis] = tree_.frame().first_m[axis] + spacing_m * cell.low[axis];
    const double side_m = spacing_m * cell.side;
    AirPlaces::Cell result{cell, static_cast<uint32_t>(block->places.size()), 0, 0.0};
    // without a triangle in it a cell is all air or all solid
    const glm::vec3 middle(low + 0.5 * side_m);
    const auto half_side_m = static_cast<float>(0.5 * side_m);
    rays_.trianglesNearCube(middle, half_side_m, &triangles_);
    const bool is_of_one_kind = triangles_.empty() && !rays_.isSkyNearCube(middle, half_side_m);
    survey_.begin();
    // by seed and place of the cell alone, whatever thread or tree asks
    Random random(mixSeed(options_.seed, kAirStream, mortonFromLattice(cell.low)));
    const glm::dvec3 shift(random.uniform(), random.uniform(), random.uniform());
    // a cell without a point in air so far is tried for longer: gaps are not lost to chance
    int in_air = 0, drawn = 0;
    while (drawn < (in_air > 0 ? options_.draws_per_cell : options_.draws_for_one) && in_air < options_.places_per_cell) {
      const glm::dvec3 place = low + side_m * spreadPoint(shift, drawn++);
      if ((is_of_one_kind && in_air > 0) || survey_.isInAir(place)) {
        ++in_air;
        block->places.push_back(place);
      } else if (is_of_one_kind) {
        break;
      }
    }
    result.count = static_cast<uint32_t>(in_air);
    result.air_share = static_cast<double>(in_air) / drawn;
    block->drawn += static_cast<uint64_t>(drawn);
    block->votes = survey_.votes();
    block->in_cavities = survey_.inCavities();
    block->cells.push_back(result);
  }

 private:
  bool mayHoldAir(const ProbeCell& cell) const {
    if (options_.known == nullptr) return true;
    const ProbeTreeFrame& frame = options_.known->frame();
    PositionM middle_m = frame.first_m;
    for (int axis = 0; axis < 3; ++axis) middle_m[axis] += frame.spacing_m * (cell.low[axis] + 0.5 * cell.side);
    ProbesAround around;
    return options_.known->lookUp(middle_m, &around);
  }

  const RayScene& rays_;
  const ProbeTree& tree_;
  const AirPlaceOptions& options_;
  CellSurvey survey_;
  std::vector<uint32_t> triangles_;
};

}  // namespace

AirPlaces findAirPlaces(const RayScene& rays, const ProbeTree& tree, const AirPlaceOptions& options, int thread_count) {
  std::vector<ProbeCell> cells;
  tree.forEachCell([&](const ProbeCell& cell) { cells.push_back(cell); });
  std::vector<Block> blocks((cells.size() + kBlockCells - 1) / kBlockCells);
  Progress progress("cells searched for air", static_cast<int64_t>(cells.size()));
  parallelFor(blocks.size(), thread_count, [&](uint64_t b, int) {
    // a voter a block: the order of its rays depends on no thread
    Surveyor surveyor(rays, tree, options);
    for (uint64_t i = b * kBlockCells; i < std::min<uint64_t>((b + 1) * kBlockCells, cells.size()); ++i)
      surveyor.survey(cells[i], &blocks[b]);
    progress.advance(static_cast<int64_t>(blocks[b].cells.size()));
  });
  // in the order of the cells, whatever thread searched them
  AirPlaces air;
  air.spacing_m = tree.frame().spacing_m;
  for (Block& block : blocks) {
    for (AirPlaces::Cell cell : block.cells) {
      cell.first += static_cast<uint32_t>(air.places.size());
      air.cells.push_back(cell);
    }
    air.places.insert(air.places.end(), block.places.begin(), block.places.end());
    air.drawn += block.drawn;
    air.votes += block.votes;
    air.in_cavities += block.in_cavities;
  }
  return air;
}

ProbeTree treeOfAir(const ProbeTree& tree, const AirPlaces& air) {
  struct LiveCell {
    uint64_t code;
    int32_t side;
  };
  std::vector<LiveCell> live;
  for (const AirPlaces::Cell& cell : air.cells) {
    if (cell.count > 0) live.push_back({mortonFromLattice(cell.cell.low), cell.cell.side});
  }
  std::sort(live.begin(), live.end(), [](const LiveCell& a, const LiveCell& b) { return a.code < b.code; });
  // the cells inside a cell are a run of the curve
  const CellJudge judge = [&](const ProbeCell& cell) {
    const uint64_t code = mortonFromLattice(cell.low);
    const auto side = static_cast<uint64_t>(cell.side);
    const auto first =
        std::lower_bound(live.begin(), live.end(), code, [](const LiveCell& c, uint64_t at) { return c.code < at; });
    if (first == live.end() || first->code >= code + side * side * side) return CellVerdict::unneeded;
    return first->side < cell.side ? CellVerdict::too_coarse : CellVerdict::fits;
  };
  ProbeTree pruned;
  // fewer cells than the tree has: it cannot be too large
  const ProbeTreeStatus status = ProbeTree::build(tree.frame(), judge, kMaxTreeProbes, &pruned);
  NLG_CHECK(static_cast<int>(status), ==, static_cast<int>(ProbeTreeStatus::ok));
  NLG_CHECK(pruned.cellCount(), ==, live.size());
  return pruned;
}

}  // namespace nlg
