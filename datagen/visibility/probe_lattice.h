// What the probes of a lattice see, and what is air in its cells.
//
// A probe in air sees from its own place, one in solid from its eye in air (solid_eye.h). A cell's links are open or blocked by the triangles
// around it. Its points are air or solid by what its probes in air see, by groups of linked points, and by rays of these: a pure function
// of the scene and of the cell, the same for all probes that have it in their supports (docs/theory/visibility.md). Both are made when
// they are first asked for, and remembered: neighbours share them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "datagen/visibility/cell_links.h"
#include "datagen/visibility/solid_eye.h"
#include "datagen/visibility/solid_vote.h"
#include "datagen/visibility/support_visibility.h"
#include "nlg/probe_tree.h"

namespace nlg {

// Of one probe.
struct ProbeSight {
  SolidVote vote;                 // of its own place
  std::optional<LocalPoint> eye;  // in its own local coordinates; nothing where it has no function
  uint32_t triangle_count = 0;    // that touch its support
  std::vector<CellPoints> seen;   // by octant, the cell's points; none where no triangle touches the support

  // Without geometry in its support a probe in air has the bare tent, and one in solid no function.
  bool isFree() const { return eye && triangle_count == 0; }
  const CellPoints& seenIn(int octant) const {
    return !eye ? CellPoints::none() : seen.empty() ? CellPoints::all() : seen[static_cast<size_t>(octant)];
  }
};

// Of one cell.
struct LatticeCell {
  std::array<std::shared_ptr<const ProbeSight>, kCellCorners> corners;
  std::vector<uint16_t> blocked;  // links by packet of cellLinks(); none where no triangle is near: all are open
  CellPoints valid;               // in air
  bool is_disputed = false;       // votes of its groups were
  AlignedFloats seen_tents;  // 1024: the tents of its probes, of each where it sees the point; none where they are 1 everywhere

  bool isOpen(size_t link) const { return blocked.empty() || !(blocked[link / kPacketLanes] >> (link % kPacketLanes) & 1); }
};

// A lattice's probes or cells by place, as far as they were asked for; the oldest are forgotten, and made again when asked for. Any number
// of threads may ask.
template <class Value>
class LatticeMemo {
 public:
  using Key = std::array<int32_t, 4>;  // lattice point, spacing in units
  explicit LatticeMemo(size_t most_kept) : most_kept_(most_kept / (2 * kParts)) {}

  // make   a pure function of the key
  std::shared_ptr<const Value> get(const Key& key, const std::function<std::shared_ptr<const Value>()>& make) {
    Part& part = parts_[KeyHash()(key) % kParts];
    {
      const std::lock_guard lock(part.mutex);
      if (const auto found = part.young.find(key); found != part.young.end()) return found->second;
      if (const auto found = part.old.find(key); found != part.old.end()) return part.young.insert(*found).first->second;
    }
    std::shared_ptr<const Value> made = make();
    const std::lock_guard lock(part.mutex);
    if (part.young.size() >= most_kept_) {
      part.old = std::move(part.young);
      part.young.clear();
    }
    return part.young.emplace(key, std::move(made)).first->second;
  }

 private:
  struct KeyHash {
    size_t operator()(const Key& key) const {
      uint64_t hash = 0;
      for (const int32_t number : key) hash = (hash ^ static_cast<uint32_t>(number)) * 0x9e3779b97f4a7c15;
      return hash ^ hash >> 32;
    }
  };
  using Values = std::unordered_map<Key, std::shared_ptr<const Value>, KeyHash>;
  struct Part {
    std::mutex mutex;
    Values young, old;
  };
  static constexpr size_t kParts = 16;  // threads seldom wait for each other

  const size_t most_kept_;
  std::array<Part, kParts> parts_;
};

// Shared by all threads that make functions of a lattice.
class ProbeLattice {
 public:
  explicit ProbeLattice(const ProbeTreeFrame& frame) : frame_(frame) {}

  LatticePoint nearestTo(const glm::dvec3& position_m) const;
  int32_t unitsOf(float spacing_m) const;
  // The place `from_point` spacings from a lattice point, relative to the scene's origin.
  glm::dvec3 placeOf(const LatticePoint& point, int32_t units, const LocalPoint& from_point) const;
  double spacingOf(int32_t units) const { return units * frame_.spacing_m; }

 private:
  friend class CellSampler;

  ProbeTreeFrame frame_;
  LatticeMemo<ProbeSight> sights_{8192};  // of 1 kB, and
  LatticeMemo<LatticeCell> cells_{4096};  // of 7 kB at most
};

// What one thread takes to look. Answers are the same for any number of threads and any order of questions.
class CellSampler {
 public:
  // The scene must outlive this object.
  // choice   samples: nothing else is seen or valid; a point is air where a probe of its cell in air sees it, and no links are tested. For a
  //          draft, which has no time for more
  explicit CellSampler(const RayScene& scene, PointChoice choice = PointChoice::all);

  // Of the probe at a lattice point, inside or outside the tree, of a spacing of so many units.
  std::shared_ptr<const ProbeSight> sightOf(const LatticePoint& at, int32_t units, ProbeLattice* lattice);
  // Of the cell whose low corner is a lattice point.
  std::shared_ptr<const LatticeCell> cellOf(const LatticePoint& low, int32_t units, ProbeLattice* lattice);

 private:
  struct CellPlace {
    const ProbeLattice& lattice;
    LatticePoint low;
    int32_t units;
  };

  ProbeSight look(const glm::dvec3& position_m, float spacing_m);
  void traceOctants(ProbeSight* sight);
  void testLinks(const CellPlace& place, LatticeCell* cell);
  void findValidity(const CellPlace& place, LatticeCell* cell);
  bool gatherGroup(size_t first, const CellPoints& seen, const LatticeCell& cell, CellPoints* judged);
  bool isGroupSolid(const CellPlace& place, bool is_linked_to_seen, LatticeCell* cell) const;
  void sumTents(LatticeCell* cell) const;

  CellPoints openPoints(const uint16_t* blocked) const;

  const RayScene& scene_;
  PointChoice choice_;
  SupportVisibility visibility_;
  SolidEye solid_eye_;
  std::array<CornerPackets, kCellCorners> corner_packets_;
  std::array<AlignedFloats, kCellCorners> tents_;  // of the probe at a corner, by the cell's points
  // kept between cells so that none of them allocates
  std::array<std::vector<uint32_t>, kMirrorCount> near_;
  std::vector<uint32_t> candidates_;
  std::vector<LocalTriangle> triangles_;
  std::vector<uint16_t> group_;
  LinkScratch scratch_;
};

}  // namespace nlg
