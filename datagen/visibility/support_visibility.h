// What one probe's support sees: which points the probe sees, which links are open, which points are valid.
//
// All of it lazily: a link is tested when somebody first asks for it, once for both directions. Validity is carried along open
// links: what a valid point sees is valid. Only a group of points that nothing valid sees casts rays of its own, and is solid
// when two fifths of those that meet a one-sided face meet its back. Rays that meet nothing, or a double-sided face, are no
// evidence; a group without evidence is valid (open air). Flipped objects therefore count as air inside, and a crack in a shell
// lets validity through: docs/visibility.md says what was measured on real levels.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/visibility/link_table.h"
#include "datagen/visibility/ray_scene.h"

namespace nlg {

// How rays from a place judged it.
struct SolidVote {
  int front = 0, back = 0;
  // solid from two fifths of backs on: on real and procedural levels shares of backs lie below a tenth or above two fifths,
  // seldom between, and exactly a half is common inside a slab that rests on another one (docs/visibility.md)
  bool solid() const { return back > 0 && 5 * back >= 2 * (front + back); }
  // a share of backs in that gap: open, flipped or self-intersecting geometry
  bool disputed() const { return 10 * back > front + back && !solid(); }
};

class SupportVisibility {
 public:
  // Both must outlive this object. One object serves many probes, one after another.
  SupportVisibility(const RayScene& scene, const LinkTable& links);

  // Moves to another probe and forgets everything about the last.
  // position_m   relative to the scene's origin; spacing_m > 0
  void beginProbe(const glm::vec3& position_m, float spacing_m);

  bool supportIsEmpty() const;  // no triangle touches the support
  SolidVote probeVote() const;  // is the probe itself in solid?

  // Which points the probe sees; call once a probe, before the rest.
  void traceProbeRays();
  bool seen(uint32_t point) const { return seen_[point]; }

  // Carries validity from the points that the probe sees to all others. returns whether any vote was disputed
  bool findValidity();
  bool valid(uint32_t point) const { return state_[point] == State::valid; }

  // Tests those of the links that have not been tested yet.
  void testLinks(const std::vector<uint32_t>& links);
  bool linkTested(uint32_t link) const { return link_state_[link] != LinkState::untested; }
  bool linkOpen(uint32_t link) const { return link_state_[link] == LinkState::open; }

  uint64_t rayCount() const { return ray_count_; }  // since construction

 private:
  enum class State : uint8_t { unknown, valid, solid, asked };  // asked: within takeSteps only
  enum class LinkState : uint8_t { untested, open, blocked };
  struct Step {
    uint32_t target, link;  // a point whose state is unknown, and a link to it from one whose state is known
  };

  glm::vec3 worldPoint(uint32_t point) const;
  SolidVote vote(const glm::vec3& origin) const;
  void takeSteps(State carried, std::vector<uint32_t>* reached);
  void flood(State carried, std::vector<uint32_t>* members);

  const RayScene& scene_;
  const LinkTable& table_;
  glm::vec3 position_{0.0f};
  float spacing_ = 1.0f;
  mutable uint64_t ray_count_ = 0;
  std::vector<uint8_t> seen_;
  std::vector<State> state_;
  std::vector<LinkState> link_state_;
  // kept between probes so that none of them allocates
  std::vector<Step> steps_;
  std::vector<uint32_t> first_links_, batch_, members_;
};

}  // namespace nlg
