// All methods at one spacing, with the same probes, rays and measured light.
#pragma once

#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "datagen/weighting/weighting_builder.h"
#include "light/air_places.h"
#include "light/methods/apv.h"
#include "light/methods/ddgi.h"
#include "light/methods/light_method.h"
#include "light/methods/weightings.h"
#include "light/probe_light.h"

namespace nlg {

struct MethodSetOptions {
  GatherOptions probe;                          // of every probe
  ProbeLightOptions solve;                      // of places in air, as a bake measures and solves with the same seed
  std::vector<double> thin_errors;              // each above 0: grids are there thinned so, too, their light solved for
  double light_error = kLightError;             // with which every method keeps harmonics (packed_light.h)
  ThetaPrecision theta = ThetaPrecision::int8;  // in which grids are counted: that of their bakes
  int thread_count = 1;
  uint64_t seed = 1;
};

// What methods are made from; all of it must outlive them.
struct MethodScene {
  const LightTransport& transport;
  const ProbeTree& tree;  // in the scene's coordinates
  const AirPlaces& air;   // places in cells of the tree
};

class MethodSet {
 public:
  // How probes are lit: by light gathered where they stand, and by light solved for.
  static inline const std::vector<LightWay> kGatheredAndSolved = {LightWay::point, LightWay::solved};

  // Gathers light at probes and at places in air.
  MethodSet(const MethodScene& scene, const MethodSetOptions& options);

  const ProbeSet& probes() const { return probes_; }
  const std::deque<LightMethod>& methods() const { return methods_; }
  // What is needed to show these methods elsewhere; null until they were added, or where the scene has none.
  const DdgiMaps* shippedDdgi() const { return shipped_ddgi_; }
  double measure_s() const { return measure_s_; }                          // light at places in air, for whoever solves
  const std::vector<LightSh>& placeLight() const { return place_light_; }  // that was measured there

  // A baseline: its name on command lines, which names of its methods begin with, and what adds them.
  struct Baseline {
    const char* name;
    bool is_technique;  // false: a bound, which nobody could ship
    void (MethodSet::*add)(const std::vector<LightWay>& ways);
  };
  static std::span<const Baseline> baselines();
  // "DDGI as shipped, relocated" is ddgi-as-shipped-relocated on a command line; behind a colon stands how its probes are lit, where
  // that is not as baselines do (trilinear:solved).
  static std::string commandName(const LightMethod& method);
  static bool isBaseline(const std::string& command_name);
  // Adds the methods of the baseline that a name is of, once. "ddgi" is DDGI as shipped, of which nothing else is added.
  void addNamed(const std::string& command_name);
  // null: the set has none of this name
  const LightMethod* named(const std::string& command_name) const;

  void addTrilinear(const std::vector<LightWay>& ways) { addTrilinear(TrilinearKind::all, ways); }
  void addValidTrilinear(const std::vector<LightWay>& ways) { addTrilinear(TrilinearKind::valid, ways); }
  void addExactVisibility(const std::vector<LightWay>& ways) { addTrilinear(TrilinearKind::visible, ways); }
  void addApv(const std::vector<LightWay>& ways);
  // As shipped, with and without relocation; where light is solved for, its weights with harmonics too. In a scene that has sheets all
  // of it again: ", backless sheets", by SheetBacks::none.
  void addDdgi(const std::vector<LightWay>& ways);
  // places   where the methods will be asked
  void addTargetFunctions(const std::vector<glm::dvec3>& places, const DiffusionOptions& diffusion,
                          const std::vector<LightWay>& ways = kGatheredAndSolved);
  // "SH octree, 64 kB" …: of light at these places, which must outlive this object; a kB is 1024 bytes.
  void addShOctrees(const std::vector<glm::dvec3>& places, const std::vector<LightSh>& light,
                    const std::vector<size_t>& kilobytes);
  // grid   baked without light, in the world's coordinates. One that is lit in every way is followed by "NAME, thinned 0.03" …, as
  //        options say (thinning.h)
  void addGrid(const std::string& name, LightGrid grid, double bake_s, const std::vector<LightWay>& ways = kGatheredAndSolved);

 private:
  struct Blends {
    std::string name;
    std::unique_ptr<Weighting> weighting;
    size_t probes = 0;
    MethodBytes bytes;
    double weights_s = 0.0;
    const std::vector<LightSh>* point_light = nullptr;  // by probe, where the method has its own way to gather it
    std::vector<LightWay> ways = kGatheredAndSolved;    // a method each
    std::vector<uint32_t> probe_function{};             // of a light grid's probes
  };
  const Weighting& own(std::unique_ptr<Weighting> weighting);
  const std::vector<LightSh>& own(std::vector<LightSh> light);
  // What of weights and tree a method has that stores harmonics as our grid does; addBlends counts those.
  MethodBytes bytesOf(size_t weight_bytes) const;
  void addBlends(Blends blends);
  void addTrilinear(TrilinearKind kind, const std::vector<LightWay>& ways);
  void addShippedDdgi();  // not relocated, by RTXGI's own rule
  const DdgiMaps& makeDdgi(SheetBacks backs, bool relocates);
  void addThinned(const LightMethod& whole, LightGrid grid, double error);
  const DdgiMaps& addDdgi(const std::string& name, const DdgiMaps& maps);

  const MethodScene scene_;
  const MethodSetOptions options_;
  ProbeSet probes_;
  std::vector<LightSh> place_light_;  // of scene.air
  double measure_s_ = 0.0;
  size_t tree_bytes_ = 0;
  std::deque<LightMethod> methods_;
  std::deque<std::unique_ptr<Weighting>> weightings_;
  std::deque<std::vector<LightSh>> lights_;
  std::deque<DdgiMaps> maps_;
  const DdgiMaps* shipped_ddgi_ = nullptr;
  std::unique_ptr<ApvProbes> apv_;
  std::deque<LightGrid> grids_;
  std::deque<ProbeTree> octrees_;
};

}  // namespace nlg
