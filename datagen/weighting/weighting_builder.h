// Computes the weighting function of a probe: the bare tent where the probe sees, carried round corners by diffusion.
//
// Method: the talk, "How do we generate the functions"; the formula is in docs/theory/math.md §1. A probe in solid sees nothing
// from where it is: on demand it sees what its eye in air sees (solid_eye.h), weighted by its own tent all the same.
#pragma once

#include <optional>
#include <vector>

#include "datagen/visibility/solid_eye.h"
#include "datagen/visibility/support_visibility.h"
#include "datagen/weighting/blend_sum.h"

namespace nlg {

struct DiffusionOptions {
  int passes = 2;
  double sigma = 0.1;    // deviation of the Gaussian, local units (shares of the spacing)
  double falloff = 2.0;  // a point's weight fades below a lit share of 1 / falloff of its open neighbourhood
};

enum class ProbeOutcome {
  function,    // generated
  free_space,  // no geometry in the support: the bare tent
  in_solid,    // the probe itself is in solid, and has no eye or is not asked to have one
  empty,       // generated, but zero at every valid support point
  outside,     // generated, but nothing of its support lies within the level's hull: said by who makes a data set
};

// The result for one probe; arrays run over all points of the link table (P support points, then the test points).
struct GeneratedFunction {
  std::vector<float> phi;      // [0, 1]; 0 at invalid points
  std::vector<uint8_t> valid;  // 0 or 1
  std::vector<uint8_t> seen;   // 0 or 1: seen by the probe's eye (and valid)
  bool open_shell = false;     // votes about solid were disputed
  bool in_solid = false;       // the probe is in solid, its eye elsewhere
};

// What becomes of a probe in solid.
enum class InSolid {
  left_out,  // no function
  by_eye,    // a function where it has an eye
};

class WeightingBuilder {
 public:
  // All three must outlive this object.
  WeightingBuilder(const RayScene& scene, const LinkTable& links, const DiffusionOptions& options);

  // position_m  relative to the scene's origin; spacing_m > 0
  // result      filled when the outcome is `function` or `empty`
  ProbeOutcome build(const glm::dvec3& position_m, float spacing_m, GeneratedFunction* result,
                     InSolid in_solid = InSolid::left_out);

  // build in two steps. see: visibility and validity alone; `function` when there is one to generate.
  // generate: the function of the probe that was seen last, whose outcome was `function`; returns `function` or `empty`
  ProbeOutcome see(const glm::dvec3& position_m, float spacing_m, InSolid in_solid = InSolid::left_out);
  ProbeOutcome generate(GeneratedFunction* result);

  // see in two steps. begin: the vote of the probe's own place and the triangles of its support; its outcome, where they settle it.
  // look: the rest, where they do not
  // eyes   of the scene's lattice, on which the probe stands; null: it looks for its own, and nobody sums blends
  std::optional<ProbeOutcome> begin(const glm::dvec3& position_m, float spacing_m, InSolid in_solid, ProbeEyes* eyes = nullptr);
  ProbeOutcome look();
  const SolidVote& probeVote() const { return probe_vote_; }  // of the probe that was begun last

  // The eyes of the probe that was begun and of those around it, where `begin` was given them and settled nothing.
  const NeighbourEyes& neighbours() const { return neighbours_; }
  // What they and the function that generate has made of it add up to.
  // sums   P, overwritten: StoredFunction::blend_sum
  void sumBlend(const GeneratedFunction& function, uint8_t* sums);

  // Of the probe that was seen last: whether it sees a place of its support, and what its function is there, by the rule that
  // gives functions at the test points of a link table. The place must be in air: nobody votes about it.
  // function   as generate gave it
  bool sees(const LocalPoint& place) const { return visibility_.isOpen(visibility_.eye(), place); }
  float valueAt(const LocalPoint& place, const GeneratedFunction& function) const;

  // Whether that probe's own place lies in a cavity (cavity.h).
  bool isInCavity() const { return probe_vote_.in_cavity; }

  const SupportVisibility& visibility() const { return visibility_; }

 private:
  void lightSeenPoints(GeneratedFunction* result);
  void diffuse(int pass, GeneratedFunction* result);
  bool isLitBefore(int pass, uint32_t point) const { return lit_[point] != 0 && lit_[point] <= pass; }

  const LinkTable& table_;
  DiffusionOptions options_;
  SupportVisibility visibility_;
  SolidEye solid_eye_;
  EyeFinder eye_finder_;
  BlendSum blend_sum_;
  NeighbourEyes neighbours_;
  bool has_neighbours_ = false;  // of the probe that was begun last
  SolidVote probe_vote_;
  bool open_shell_ = false;
  std::vector<float> tent_;        // by point
  std::vector<float> gaussian_;    // by entry of LinkTable::nearest
  std::vector<uint8_t> lit_;       // 0: nothing received; otherwise 1 + the pass that lit it
  std::vector<uint32_t> waiting_;  // valid points that have received nothing yet
};

}  // namespace nlg
