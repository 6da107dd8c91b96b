#include "datagen/weighting/weighting_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datagen/visibility/segment_kernel.h"

namespace nlg {
namespace {

// What a point without weight receives in one pass from the neighbours that it sees (docs/theory/math.md §1).
struct Gathering {
  double open = 0.0, lit = 0.0, weighted = 0.0;
  void addOpen(float gaussian) { open += gaussian; }
  void addLit(float gaussian, float phi) {
    lit += gaussian;
    weighted += gaussian * phi;
  }
  float phi(double falloff) const { return static_cast<float>(weighted / lit * std::min(1.0, falloff * lit / open)); }
};

float gaussianAt(float distance, double sigma) {
  return static_cast<float>(std::exp(-0.5 / (sigma * sigma) * distance * distance));
}

// The octant that lies so far from another one of the support; nothing outside it.
std::optional<int> octantAway(int octant, const std::array<int8_t, 3>& away) {
  int there = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int side = (octant >> axis & 1 ? 0 : 1) + away[axis];  // 0 below the probe, 1 above
    if (side < 0 || side > 1) return std::nullopt;
    there |= (1 - side) << axis;
  }
  return there;
}

bool isBlocked(const std::vector<uint16_t>& blocked, size_t place) {
  return blocked[place / kPacketLanes] >> (place % kPacketLanes) & 1;
}

}  // namespace

void describe(DiffusionOptions& o, OptionTable& table) {
  table.group("Weighting functions");
  table.add("diffusion_passes", &o.passes, "diffusion passes, which carry weight round corners", 0, 16);
  table.add("diffusion_sigma", &o.sigma, "standard deviation of the diffusion's Gaussian, as a share of the spacing", 1e-3, 10.0);
  table.add("diffusion_falloff", &o.falloff,
            "falloff of the diffusion: weight fades at points of whose open neighbourhood less than 1/falloff is lit", 0.0, 1e6);
}

std::vector<WeightingBuilder::Reading> WeightingBuilder::readingsOf(uint32_t point, std::vector<float>* gaussian, double sigma) {
  const CellLinks& links = cellLinks();
  const auto octant = static_cast<int>(point / kOctantPointCount);
  const size_t first = size_t{links.point_of[octant][point % kOctantPointCount]} * kLinkCount;
  std::vector<Reading> readings;
  for (size_t entry = first; entry < first + kLinkCount; ++entry) {
    const CellLinks::Edge& edge = links.nearest[entry];
    const std::optional<int> there = octantAway(octant, edge.away);
    if (!there) continue;
    const auto other = static_cast<uint16_t>(*there * kOctantPointCount + links.point_of[*there][edge.point]);
    readings.push_back({other, edge.link, static_cast<uint8_t>(edge.is_theirs ? *there : octant)});
    gaussian->push_back(gaussianAt(links.distance[entry], sigma));
  }
  return readings;
}

WeightingBuilder::WeightingBuilder(const RayScene& scene, const DiffusionOptions& options, const TestLinks* test,
                                   PointChoice choice)
    : scene_(scene), options_(options), test_(test), sampler_(scene, choice), around_(scene), lit_(kSupportPointCount) {
  // without links there is nothing to diffuse along
  if (choice == PointChoice::samples) options_.passes = 0;
  for (const LocalPoint& point : supportPattern().points) tent_.push_back(tent(point));
  first_reading_.push_back(0);
  for (uint32_t point = 0; point < kSupportPointCount; ++point) {
    const std::vector<Reading> readings = readingsOf(point, &gaussian_, options.sigma);
    readings_.insert(readings_.end(), readings.begin(), readings.end());
    first_reading_.push_back(static_cast<uint32_t>(readings_.size()));
  }
}

ProbeOutcome WeightingBuilder::build(const glm::dvec3& position_m, float spacing_m, GeneratedFunction* result, InSolid in_solid,
                                     ProbeLattice* lattice) {
  const ProbeOutcome outcome = see(position_m, spacing_m, in_solid, lattice);
  return outcome == ProbeOutcome::function ? generate(result) : outcome;
}

ProbeOutcome WeightingBuilder::see(const glm::dvec3& position_m, float spacing_m, InSolid in_solid, ProbeLattice* lattice) {
  std::optional<ProbeLattice> own;
  if (lattice == nullptr) lattice = &own.emplace(ProbeTreeFrame{{position_m.x, position_m.y, position_m.z}, spacing_m, {}});
  position_ = position_m;
  spacing_m_ = spacing_m;
  is_around_ = false;
  const LatticePoint at = lattice->nearestTo(position_m);
  const int32_t units = lattice->unitsOf(spacing_m);
  sight_ = sampler_.sightOf(at, units, lattice);
  if (!sight_->eye || (sight_->vote.solid() && in_solid == InSolid::left_out)) return ProbeOutcome::in_solid;
  if (sight_->isFree()) return ProbeOutcome::free_space;
  for (int octant = 0; octant < kCellCorners; ++octant) {
    LatticePoint low = at;
    for (int axis = 0; axis < 3; ++axis) low[axis] -= octant >> axis & 1 ? units : 0;
    cells_[octant] = sampler_.cellOf(low, units, lattice);
  }
  return ProbeOutcome::function;
}

ProbeOutcome WeightingBuilder::generate(GeneratedFunction* result) {
  result->open_shell = sight_->vote.disputed();
  for (const auto& cell : cells_) result->open_shell |= cell->is_disputed;
  result->in_solid = sight_->vote.solid();
  lightSeenPoints(result);
  for (int pass = 1; pass <= options_.passes && !waiting_.empty(); ++pass) diffuse(pass, result);
  if (test_ != nullptr && !test_->points.empty()) generateTestPoints(result);
  const bool empty =
      std::all_of(result->phi.begin(), result->phi.begin() + kSupportPointCount, [](float w) { return w == 0.0f; });
  return empty ? ProbeOutcome::empty : ProbeOutcome::function;
}

bool WeightingBuilder::isBareTent() const {
  for (int octant = 0; octant < kCellCorners; ++octant) {
    CellPoints covered = sight_->seenIn(octant);
    covered |= cells_[octant]->valid;
    if (covered != sight_->seenIn(octant)) return false;
  }
  return true;
}

// Gives the tent to what the probe sees; lists the valid points that wait for weight.
void WeightingBuilder::lightSeenPoints(GeneratedFunction* result) {
  result->phi = tent_;
  result->valid.assign(kSupportPointCount, 1);
  result->seen.assign(kSupportPointCount, 1);
  std::fill(lit_.begin(), lit_.end(), uint8_t{1});
  waiting_.clear();
  for (int octant = 0; octant < kCellCorners; ++octant) {
    const CellPoints& valid = cells_[octant]->valid;
    const uint16_t* point_of = cellLinks().point_of[octant].data();
    sight_->seenIn(octant).forEachOther([&](size_t cell_point) {
      const size_t point = static_cast<size_t>(octant) * kOctantPointCount + point_of[cell_point];
      result->phi[point] = 0.0f;
      result->seen[point] = 0;
      result->valid[point] = valid.has(cell_point);
      lit_[point] = 0;
      if (result->valid[point]) waiting_.push_back(static_cast<uint16_t>(point));
    });
  }
}

// One pass: every valid point without weight gathers from its nearest points that are lit before this pass.
void WeightingBuilder::diffuse(int pass, GeneratedFunction* result) {
  std::erase_if(waiting_, [&](uint16_t point) {
    const uint32_t first = first_reading_[point], end = first_reading_[point + 1];
    if (std::none_of(&readings_[first], &readings_[end - 1] + 1, [&](const Reading& r) { return isLitBefore(pass, r.point); }))
      return false;
    Gathering gathering;
    for (uint32_t r = first; r < end; ++r) {
      const Reading& reading = readings_[r];
      if (!result->valid[reading.point] || !cells_[reading.octant]->isOpen(reading.link)) continue;
      gathering.addOpen(gaussian_[r]);
      if (isLitBefore(pass, reading.point)) gathering.addLit(gaussian_[r], result->phi[reading.point]);
    }
    if (gathering.lit == 0.0) return false;
    result->phi[point] = gathering.phi(options_.falloff);
    lit_[point] = static_cast<uint8_t>(pass + 1);
    return true;
  });
}

// A test point that the probe does not see is judged as the nearest support point that one of its carrying links leads to, and by rays of
// its own where none does.
void WeightingBuilder::generateTestPoints(GeneratedFunction* result) {
  const SupportVisibility& around = lookAround();
  std::vector<uint16_t> dark(test_->point_packets.tree.packetCount()), blocked(test_->link_packets.tree.packetCount());
  blockRays(test_->point_packets, around.triangles(), *sight_->eye, dark.data());
  blockLinks(test_->link_packets, around.triangles(), &scratch_, blocked.data());
  const size_t count = test_->points.size();
  for (std::vector<uint8_t>* list : {&result->valid, &result->seen}) list->resize(kSupportPointCount + count, 1);
  result->phi.resize(kSupportPointCount + count);
  for (size_t place = 0; place < count; ++place)
    result->seen[kSupportPointCount + test_->point_packets.tree.order[place]] = !isBlocked(dark, place);
  for (size_t i = 0; i < count; ++i) {
    const size_t point = kSupportPointCount + i;
    const NearestPoints& nearest = test_->nearest[i];
    if (result->seen[point]) {
      result->phi[point] = tent(test_->points[i]);
      continue;
    }
    std::array<bool, kLinkCount> open;
    for (size_t k = 0; k < kLinkCount; ++k) open[k] = !isBlocked(blocked, test_->place[i * kLinkCount + k]);
    const auto carrying = std::find(open.begin(), open.begin() + kCarryingLinkCount, true);
    result->valid[point] = carrying != open.begin() + kCarryingLinkCount
                               ? result->valid[nearest.point[carrying - open.begin()]]
                               : !voteAt(scene_, around.placeOf(test_->points[i])).solid();
    if (!result->valid[point]) continue;
    result->phi[point] = gatherFrom(nearest, open, *result);
  }
}

// What a further place in the dark receives, in the first pass in which it does.
float WeightingBuilder::gatherFrom(const NearestPoints& nearest, const std::array<bool, kLinkCount>& open,
                                   const GeneratedFunction& function) const {
  for (int pass = 1; pass <= options_.passes; ++pass) {
    Gathering gathering;
    for (int k = 0; k < kLinkCount; ++k) {
      const uint32_t point = nearest.point[k];
      if (!open[k] || !function.valid[point]) continue;
      const float gaussian = gaussianAt(nearest.distance[k], options_.sigma);
      gathering.addOpen(gaussian);
      if (isLitBefore(pass, point)) gathering.addLit(gaussian, function.phi[point]);
    }
    if (gathering.lit > 0.0) return gathering.phi(options_.falloff);
  }
  return 0.0f;
}

void WeightingBuilder::sumBlend(const GeneratedFunction& function, uint8_t* sums) const {
  // 255 stands for 1 or more, which weighs a point least; where phi is 0 the sum is not read
  std::fill_n(sums, kSupportPointCount, uint8_t{255});
  for (int octant = 0; octant < kCellCorners; ++octant) {
    const AlignedFloats& tents = cells_[octant]->seen_tents;
    if (tents.empty()) continue;
    const uint16_t* point_of = cellLinks().point_of[octant].data();
    for (size_t i = 0; i < kOctantPointCount; ++i) {
      const size_t point = static_cast<size_t>(octant) * kOctantPointCount + i;
      const float own = function.phi[point];
      if (own == 0.0f) continue;
      const float sum = tents[point_of[i]] + (function.seen[point] ? 0.0f : own);
      sums[point] = static_cast<uint8_t>(255.0f * std::min(1.0f, sum) + 0.5f);
    }
  }
}

const SupportVisibility& WeightingBuilder::lookAround() {
  if (!is_around_) around_.beginProbe(position_, spacing_m_);
  is_around_ = true;
  return around_;
}

bool WeightingBuilder::sees(const LocalPoint& place) { return lookAround().isOpen(*sight_->eye, place); }

float WeightingBuilder::valueAt(const LocalPoint& place, const GeneratedFunction& function) {
  if (sees(place)) return tent(place);
  const NearestPoints nearest = nearestSupportPoints(place);
  std::array<bool, kLinkCount> open;
  for (int k = 0; k < kLinkCount; ++k) open[k] = lookAround().isOpen(supportPattern().points[nearest.point[k]], place);
  return gatherFrom(nearest, open, function);
}

}  // namespace nlg
