// Computes the visibility of one probe's support: points that the probe sees, open links, valid points.
//
// What the probe sees is what its eye sees: the probe's own place, or for a probe in solid a place in air (solid_eye.h).
// Only the triangles that touch the support are looked at, in its local coordinates, through fixed hierarchies over the probe's
// rays and over the links (segment_kernel.h). Validity is carried along open links: what a valid point sees is valid. Only a
// group of points that nothing valid sees casts rays of its own, and is solid when two fifths of those that meet a one-sided face
// meet its back. Rays that meet nothing, or a double-sided face, are no evidence; a group without evidence is valid (open air).
// Flipped objects therefore count as air inside, and a crack in a shell lets validity through: docs/theory/visibility.md says what was
// measured on real levels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/visibility/link_table.h"
#include "datagen/visibility/local_triangles.h"
#include "datagen/visibility/ray_scene.h"

namespace nlg {

// Whether a place lies in solid, by rays from it alone.
//
// How rays from a place judged it.
struct SolidVote {
  int front = 0, back = 0;
  int nothing = 0;         // rays that met no face
  bool in_cavity = false;  // no solid by its rays, but where nobody can be: cavity.h, for who asks it
  // solid from two fifths of backs on: on real and procedural levels shares of backs lie below a tenth or above two fifths,
  // seldom between, and exactly a half is common inside a slab that rests on another one (docs/theory/visibility.md)
  bool solid() const { return in_cavity || (back > 0 && 5 * back >= 2 * (front + back)); }
  // a share of backs in that gap: open, flipped or self-intersecting geometry
  bool disputed() const { return 10 * back > front + back && !solid(); }
  // at least half of one place's 14 rays met a one-sided face, all of them the same side
  bool unanimous() const { return front + back >= 7 && (front == 0 || back == 0); }
};

inline constexpr int kSolidVoteRays = 14;

// The directions of a vote's rays.
const std::array<glm::vec3, kSolidVoteRays>& voteDirections();

// The rays of one place against the scene's surfaces.
// position_m   relative to the scene's origin
SolidVote solidVote(const RayScene& rays, const glm::dvec3& position_m);

// The same with sky faces among the surfaces: what lies behind the sky is no part of the scene.
SolidVote solidVoteWithSky(const RayScene& rays, const glm::dvec3& position_m);

// What was asked of the scene beyond the support, and the answer. The triangles of the support, the vote of the probe's own place and
// these answers are all that comes from the scene: where they are the same, a probe has the same function.
struct FarQuestion {
  static constexpr size_t kMostPoints = 5;
  enum class Kind : uint8_t { group, sky };

  Kind kind = Kind::group;  // groupVote of these points; isBehindSky of the first
  uint8_t point_count = 0;
  bool solid = false, disputed = false;        // the answer
  std::array<uint16_t, kMostPoints> points{};  // of the link table; 0 behind point_count

  friend bool operator==(const FarQuestion&, const FarQuestion&) = default;
};

class SupportVisibility {
 public:
  // Both must outlive this object. One object serves many probes, one after another.
  SupportVisibility(const RayScene& scene, const LinkTable& links);

  // The rays of one place, of a probe for instance that has not been begun: most of those in solid need no more than this. What lies in
  // a cavity (cavity.h) is solid, here and in all that follows.
  // position_m   relative to the scene's origin
  SolidVote voteAt(const glm::dvec3& position_m) const;

  // Moves to another probe, forgets everything about the last, and collects the triangles of the support.
  // position_m   relative to the scene's origin; spacing_m > 0
  void beginProbe(const glm::dvec3& position_m, float spacing_m);

  bool supportIsEmpty() const { return triangles_.empty(); }  // no triangle touches the support
  const std::vector<LocalTriangle>& triangles() const { return triangles_; }
  SolidVote probeVote() const { return voteAt(position_); }  // is the probe itself in solid?

  // The rays of a few support points together, that stand for all of a group: the first one alone when its rays leave no doubt.
  SolidVote groupVote(const std::vector<uint32_t>& members) const;
  // Whether a support point, by itself in air, lies behind the scene's sky.
  bool isBehindSky(uint32_t point) const;

  // What groupVote and isBehindSky were asked since beginProbe, in order.
  const std::vector<FarQuestion>& asked() const { return asked_; }
  // Asks again, around the present probe: whether the answer is the same. It is not among what was asked.
  bool answersAlike(const FarQuestion& question) const;

  // Which points the probe sees; call once a probe, before the rest.
  void traceProbeRays() { traceRays({}); }
  // The same from another eye: a place of the support, local coordinates.
  void traceRays(const LocalPoint& eye);
  const LocalPoint& eye() const { return eye_; }
  bool seen(uint32_t point) const { return seen_[point]; }
  const std::vector<uint32_t>& dark() const { return dark_; }  // the points that it does not see, rising

  // Which links are open: all of them, which is cheaper than to find out which of them anything reads (docs/theory/visibility.md).
  void testLinks();
  // Whether no triangle of the support meets a segment in it, local coordinates: the rule of all its rays and links, one at a time.
  bool isOpen(const LocalPoint& from, const LocalPoint& to) const;
  bool linkOpen(uint32_t link) const { return (blocked_links_[link / kPacketLanes] >> (link % kPacketLanes) & 1) == 0; }

  // Carries validity from the points that the probe sees to all others; after traceProbeRays and testLinks. returns whether any
  // vote was disputed
  bool findValidity();
  bool valid(uint32_t point) const { return state_[point] == State::valid; }

  // Work since construction: rays cast for votes, and pairs of a packet of 16 links and a triangle.
  uint64_t rayCount() const { return ray_count_; }
  uint64_t packetTestCount() const { return packet_test_count_; }

 private:
  enum class State : uint8_t { unknown, valid, solid };

  SolidVote raysAt(const glm::dvec3& position_m) const;
  FarQuestion answered(FarQuestion question, SolidVote* vote) const;
  glm::dvec3 pointPosition(uint32_t point) const;  // relative to the scene's origin
  bool reachesValid(uint32_t point) const;
  void flood(State carried, std::vector<uint32_t>* members);

  const RayScene& scene_;
  const LinkTable& table_;
  glm::dvec3 position_{0.0};
  double spacing_ = 1.0;
  LocalPoint eye_{};
  mutable uint64_t ray_count_ = 0;
  mutable std::vector<FarQuestion> asked_;
  uint64_t packet_test_count_ = 0;
  std::vector<uint8_t> seen_;
  std::vector<State> state_;
  std::vector<uint16_t> blocked_points_, blocked_links_;  // by packet
  // kept between probes so that none of them allocates
  std::vector<uint32_t> candidates_, dark_, members_;
  std::vector<LocalTriangle> triangles_;
  LinkScratch scratch_;
};

}  // namespace nlg
