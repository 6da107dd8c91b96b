#include "datagen/visibility/probe_lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace nlg {
namespace {

LatticePoint corneredAt(LatticePoint low, int corner, int32_t units) {
  for (int axis = 0; axis < 3; ++axis) low[axis] += corner >> axis & 1 ? units : 0;
  return low;
}

// The sample points of a cell: closed under its symmetries, so that all its octants have the same.
const CellPoints& samplesOfCell() {
  static const CellPoints samples = [] {
    CellPoints points;
    for (const uint16_t point : octantSamples()) points.add(point);
    return points;
  }();
  return samples;
}

// What a cell's probes in air see of it.
CellPoints seenFromAir(const LatticeCell& cell) {
  CellPoints seen;
  for (int corner = 0; corner < kCellCorners; ++corner) {
    if (!cell.corners[corner]->vote.solid()) seen |= cell.corners[corner]->seenIn(corner);
  }
  return seen;
}

}  // namespace

LatticePoint ProbeLattice::nearestTo(const glm::dvec3& position_m) const {
  LatticePoint at;
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = static_cast<int32_t>(std::lround((position_m[axis] - frame_.first_m[axis]) / frame_.spacing_m));
  return at;
}

int32_t ProbeLattice::unitsOf(float spacing_m) const { return static_cast<int32_t>(std::lround(spacing_m / frame_.spacing_m)); }

glm::dvec3 ProbeLattice::placeOf(const LatticePoint& point, int32_t units, const LocalPoint& from_point) const {
  glm::dvec3 place;
  for (int axis = 0; axis < 3; ++axis)
    place[axis] = frame_.first_m[axis] + frame_.spacing_m * (point[axis] + double{from_point[axis]} * units);
  return place;
}

CellSampler::CellSampler(const RayScene& scene, PointChoice choice) : scene_(scene), choice_(choice), visibility_(scene) {
  for (int corner = 0; corner < kCellCorners; ++corner) {
    corner_packets_[corner] = makeCornerPackets(corner, choice);
    for (size_t point = 0; point < kOctantPointCount; ++point) {
      float product = 1.0f;
      for (int axis = 0; axis < 3; ++axis) product *= corner >> axis & 1 ? cellPoint(point)[axis] : 1.0f - cellPoint(point)[axis];
      tents_[corner].push_back(product);
    }
  }
}

std::shared_ptr<const ProbeSight> CellSampler::sightOf(const LatticePoint& at, int32_t units, ProbeLattice* lattice) {
  return lattice->sights_.get({at[0], at[1], at[2], units}, [&] {
    return std::make_shared<const ProbeSight>(
        look(lattice->placeOf(at, units, {}), static_cast<float>(lattice->spacingOf(units))));
  });
}

ProbeSight CellSampler::look(const glm::dvec3& position_m, float spacing_m) {
  ProbeSight sight;
  sight.vote = voteAt(scene_, position_m);
  visibility_.beginProbe(position_m, spacing_m);
  sight.triangle_count = static_cast<uint32_t>(visibility_.triangles().size());
  if (!sight.vote.solid()) {
    sight.eye = LocalPoint{};
    if (!sight.isFree()) traceOctants(&sight);
  } else if ((sight.eye = solid_eye_.open(&visibility_))) {
    sight.seen.assign(kCellCorners, CellPoints::all());
    visibility_.forEachDark([&, &point_of = cellLinks().point_of](uint32_t point) {
      const uint32_t octant = point / kOctantPointCount;
      sight.seen[octant].remove(point_of[octant][point % kOctantPointCount]);
    });
    if (choice_ == PointChoice::samples) {
      for (CellPoints& seen : sight.seen) seen &= samplesOfCell();
    }
  }
  return sight;
}

// What rays through packets left open.
CellPoints CellSampler::openPoints(const uint16_t* blocked) const {
  CellPoints points;
  if (choice_ == PointChoice::samples) {
    for (size_t i = 0; i < kOctantSampleCount; ++i) {
      if (!(blocked[i / kPacketLanes] >> (i % kPacketLanes) & 1)) points.add(octantSamples()[i]);
    }
    return points;
  }
  for (size_t packet = 0; packet < kOctantPointCount / kPacketLanes; ++packet)
    points.words[packet / 4] |= uint64_t{static_cast<uint16_t>(~blocked[packet])} << (16 * (packet % 4));
  return points;
}

// From its own place a probe sees an octant through the triangles that touch it, and no others.
void CellSampler::traceOctants(ProbeSight* sight) {
  for (std::vector<uint32_t>& near : near_) near.clear();
  sortIntoOctants(visibility_.triangles(), &near_);
  for (int octant = 0; octant < kCellCorners; ++octant) {
    std::array<uint16_t, kOctantPointCount / kPacketLanes> blocked{};
    if (!near_[octant].empty())
      blockOctantRays(corner_packets_[octant], visibility_.triangles(), near_[octant], {}, blocked.data());
    sight->seen.push_back(openPoints(blocked.data()));
  }
}

std::shared_ptr<const LatticeCell> CellSampler::cellOf(const LatticePoint& low, int32_t units, ProbeLattice* lattice) {
  return lattice->cells_.get({low[0], low[1], low[2], units}, [&] {
    auto cell = std::make_shared<LatticeCell>();
    for (int corner = 0; corner < kCellCorners; ++corner)
      cell->corners[corner] = sightOf(corneredAt(low, corner, units), units, lattice);
    if (choice_ == PointChoice::samples) {
      cell->valid = seenFromAir(*cell);
      cell->valid &= samplesOfCell();
      return std::shared_ptr<const LatticeCell>(std::move(cell));
    }
    const CellPlace place{*lattice, low, units};
    testLinks(place, cell.get());
    findValidity(place, cell.get());
    sumTents(cell.get());
    return std::shared_ptr<const LatticeCell>(std::move(cell));
  });
}

void CellSampler::testLinks(const CellPlace& place, LatticeCell* cell) {
  const glm::dvec3 middle = place.lattice.placeOf(place.low, place.units, {0.5f, 0.5f, 0.5f});
  const double reach_m = kCellReach * place.lattice.spacingOf(place.units);
  triangles_.clear();
  scene_.trianglesNearCube(glm::vec3(middle), static_cast<float>(reach_m), &candidates_);
  collectLocalTriangles(scene_.positions(), scene_.triangles(), candidates_, middle, reach_m, &triangles_);
  if (triangles_.empty()) return;
  cell->blocked.resize(cellLinks().packets.tree.packetCount());
  blockLinks(cellLinks().packets, triangles_, &scratch_, cell->blocked.data());
}

void CellSampler::findValidity(const CellPlace& place, LatticeCell* cell) {
  const CellPoints seen = seenFromAir(*cell);
  cell->valid = seen;
  if (cell->blocked.empty()) {
    // all points are one group
    group_.resize(kOctantPointCount);
    std::iota(group_.begin(), group_.end(), uint16_t{0});
    if (seen != CellPoints::none() || !isGroupSolid(place, false, cell)) cell->valid = CellPoints::all();
    return;
  }
  CellPoints judged = seen;
  seen.forEachOther([&](size_t point) {
    if (judged.has(point)) return;
    const bool is_linked_to_seen = gatherGroup(point, seen, *cell, &judged);
    if (isGroupSolid(place, is_linked_to_seen, cell)) return;
    for (const uint16_t member : group_) cell->valid.add(member);
  });
}

// Gathers the points that nobody in air sees and that open links within the cell connect to `first`; returns whether one links to a seen
// point.
bool CellSampler::gatherGroup(size_t first, const CellPoints& seen, const LatticeCell& cell, CellPoints* judged) {
  const CellLinks& links = cellLinks();
  group_.assign(1, static_cast<uint16_t>(first));
  judged->add(first);
  bool is_linked_to_seen = false;
  for (size_t i = 0; i < group_.size(); ++i) {
    for (uint32_t e = links.first_inner[group_[i]]; e < links.first_inner[group_[i] + 1]; ++e) {
      const auto [point, link] = links.inner[e];
      const bool is_seen = seen.has(point);
      if (is_seen ? is_linked_to_seen : judged->has(point)) continue;
      if (!cell.isOpen(link)) continue;
      is_linked_to_seen |= is_seen;
      if (is_seen) continue;
      judged->add(point);
      group_.push_back(point);
    }
  }
  return is_linked_to_seen;
}

// Where sight and rays contradict each other, sight has the say unless rays leave no doubt.
bool CellSampler::isGroupSolid(const CellPlace& place, bool is_linked_to_seen, LatticeCell* cell) const {
  const auto place_of = [&](size_t member) { return place.lattice.placeOf(place.low, place.units, cellPoint(group_[member])); };
  SolidVote vote = groupVote(scene_, group_.size(), place_of);
  if (is_linked_to_seen && !vote.unanimous()) return false;
  vote = withCavity(vote, scene_, place_of(0));
  cell->is_disputed |= vote.disputed();
  return vote.solid();
}

void CellSampler::sumTents(LatticeCell* cell) const {
  const auto& corners = cell->corners;
  const auto sees_all = [&](int corner) { return corners[corner]->seenIn(corner) == CellPoints::all(); };
  bool is_seen_by_all = true;
  for (int corner = 0; corner < kCellCorners; ++corner) is_seen_by_all &= sees_all(corner);
  if (is_seen_by_all) return;
  AlignedFloats& sums = cell->seen_tents;
  sums.assign(kOctantPointCount, 0.0f);
  for (int corner = 0; corner < kCellCorners; ++corner) {
    const CellPoints& seen = corners[corner]->seenIn(corner);
    for (size_t first = 0; first < kOctantPointCount; first += kPacketLanes) {
      const uint64_t open = seen.words[first / 64] >> (first % 64) & 0xffff;
      const float* tent = &tents_[corner][first];
      if (open == 0xffff) {
        for (int i = 0; i < kPacketLanes; ++i) sums[first + i] += tent[i];
      } else if (open != 0) {
        for (int i = 0; i < kPacketLanes; ++i) sums[first + i] += open >> i & 1 ? tent[i] : 0.0f;
      }
    }
  }
}

}  // namespace nlg
