// Computes the weighting function of a probe: the bare tent where the probe sees, carried round corners by diffusion.
//
// Method: the talk, "How do we generate the functions"; the formula is in docs/theory/math.md §1. What the probe sees, which links are open
// and where is air it has from its lattice, whose probes share it. A probe in solid sees nothing from where it is: on demand it sees what
// its eye in air sees (solid_eye.h), weighted by its own tent all the same.
#pragma once

#include <optional>
#include <vector>

#include "datagen/visibility/cell_links.h"
#include "datagen/visibility/probe_lattice.h"
#include "tool/command/options.h"

namespace nlg {

struct DiffusionOptions {
  int passes = 2;
  double sigma = 0.1;    // deviation of the Gaussian, local units (shares of the spacing)
  double falloff = 2.0;  // a point's weight fades below a lit share of 1 / falloff of its open neighbourhood
};
void describe(DiffusionOptions& options, OptionTable& table);

enum class ProbeOutcome {
  function,    // generated
  free_space,  // no geometry in the support: the bare tent
  in_solid,    // the probe itself is in solid, and has no eye or is not asked to have one
  empty,       // generated, but zero at every valid support point
  outside,     // generated, but nothing of its support lies within the level's hull: said by who makes a data set
};

// The result for one probe; arrays run over the P support points, then over the test points.
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
  // test   must outlive this object, as the scene; null: there are no test points
  // choice samples: functions without diffusion, valid and other than 0 at sample points alone
  WeightingBuilder(const RayScene& scene, const DiffusionOptions& options, const TestLinks* test = nullptr,
                   PointChoice choice = PointChoice::all);

  // position_m  relative to the scene's origin; spacing_m > 0
  // lattice     on which the probe stands; null: one of its own. The same function either way
  // result      filled when the outcome is `function` or `empty`
  ProbeOutcome build(const glm::dvec3& position_m, float spacing_m, GeneratedFunction* result,
                     InSolid in_solid = InSolid::left_out, ProbeLattice* lattice = nullptr);

  // build in two steps. see: visibility and validity alone; `function` when there is one to generate.
  // generate: the function of the probe that was seen last, whose outcome was `function`; returns `function` or `empty`
  ProbeOutcome see(const glm::dvec3& position_m, float spacing_m, InSolid in_solid = InSolid::left_out,
                   ProbeLattice* lattice = nullptr);
  ProbeOutcome generate(GeneratedFunction* result);
  // Of a probe that is seen and has a function: whether all that it does not see is solid, so that the function is the bare tent.
  bool isBareTent() const;

  // What the tents of all probes of a cell add up to where these see a point, and this one's function where it does not.
  // function   as generate gave it
  // sums       P, overwritten: StoredFunction::blend_sum
  void sumBlend(const GeneratedFunction& function, uint8_t* sums) const;

  // Of the probe that was seen last: whether it sees a place of its support, and what its function is there, by the rule that
  // gives functions at test points. The place must be in air: nobody votes about it.
  bool sees(const LocalPoint& place);
  float valueAt(const LocalPoint& place, const GeneratedFunction& function);

  // Of the probe that was seen last, whatever came of it.
  const ProbeSight& sight() const { return *sight_; }

 private:
  // What a point of a support reads from another one of it.
  struct Reading {
    uint16_t point, link;
    uint8_t octant;  // whose cell has the link
  };
  static std::vector<Reading> readingsOf(uint32_t point, std::vector<float>* gaussian, double sigma);

  void lightSeenPoints(GeneratedFunction* result);
  void diffuse(int pass, GeneratedFunction* result);
  void generateTestPoints(GeneratedFunction* result);
  float gatherFrom(const NearestPoints& nearest, const std::array<bool, kLinkCount>& open,
                   const GeneratedFunction& function) const;
  bool isLitBefore(int pass, uint32_t point) const { return lit_[point] != 0 && lit_[point] <= pass; }
  // The triangles of the support: of who asks for more than support points.
  const SupportVisibility& lookAround();

  const RayScene& scene_;
  DiffusionOptions options_;
  const TestLinks* test_;
  CellSampler sampler_;
  SupportVisibility around_;
  bool is_around_ = false;  // whether around_ is of the probe that was seen last
  glm::dvec3 position_{0.0};
  float spacing_m_ = 1.0f;
  std::shared_ptr<const ProbeSight> sight_;
  std::array<std::shared_ptr<const LatticeCell>, kCellCorners> cells_;  // by octant
  std::vector<float> tent_;                                             // by support point
  std::vector<uint32_t> first_reading_;                                 // by support point, into the two below; one more
  std::vector<Reading> readings_;
  std::vector<float> gaussian_;
  std::vector<uint8_t> lit_;       // by support point: 0: nothing received; otherwise 1 + the pass that lit it
  std::vector<uint16_t> waiting_;  // valid support points that have received nothing yet
  LinkScratch scratch_;
};

}  // namespace nlg
