// Computes probe light from light measured at sample points in air, in three ways.
//
// Neighbouring supports overlap eightfold, so that light is measured once at places of every cell, and each place serves the
// eight probes around it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "light/air_places.h"
#include "light/light_solve.h"
#include "light/light_transport.h"
#include "nlg/look_up.h"

namespace nlg {

enum class LightWay : uint8_t {
  point,       // light at the probe's own position; of a probe in solid: integrated
  integrated,  // the talk's: the mean of light under the probe's weights
  solved,      // least squares: blends give the light that was measured
};
// throws   UsageError on a name that is none of "point", "integrated", "solved"
LightWay lightWayFromName(const std::string& name);

// Rays of each of so many sample points: 64 to 512, some 16 million in all where these limits allow. More rays leave fewer stains on a
// small scene's walls; in a large level a cell's twelve points average out the noise of 64.
int raysOfPlace(size_t place_count);

struct ProbeLightOptions {
  LightWay way = LightWay::solved;
  GatherOptions place{64, 64};   // of every place in air
  GatherOptions probe{512, 64};  // of every probe, for `point`
  bool caches_surfaces = true;   // makeSurfaceCache's ends both of their paths
  double pull = 0.1;             // of the prior, in shares of the weight that places read a probe by
  double dark_share = 0.03;  // > 0, of the level's mean light: added to a place's own where its error is taken as a share of it
  double outlier = 1.0;      // > 0, of that light of the place: errors far beyond it count no more than at it (Cauchy)
  uint64_t seed = 1;
};

// The weights that a look-up blends at a place, not normalised; indices of the tree's probes. A count of 0 where there are none.
using WeightsAt = std::function<void(const glm::dvec3& position_m, ProbeWeights* weights)>;

// What a look-up in a grid gives, at positions relative to the scene's origin; the grid is where moveBy(origin_m) has put it. Both
// must outlive it.
WeightsAt weightsOf(const LightGrid& grid, const glm::dvec3& origin_m);

// As a light grid holds it.
std::vector<float> floatsOf(const std::vector<LightSh>& light);

// Of each group of lights (LightGroups) what every place, or every probe, has of it. Empty where all light is one group.
using LightByGroup = std::vector<std::vector<LightSh>>;

// Light at places. Places that follow one another should be neighbours: their rays go into each other's gaps.
// groups   receives what each group gives of it, when given
std::vector<LightSh> measureLight(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                  const GatherOptions& options, uint64_t seed, int thread_count, LightByGroup* groups = nullptr);

struct ProbeLight {
  std::vector<LightSh> light;  // by probe
  LightByGroup groups;         // by group and probe: they add up to light
  int iterations = 0;          // of the solve
  uint64_t unread = 0;         // probes that weigh nothing at every place: they hold the light of places around them
  uint64_t unseen = 0;         // places whose dark nobody sees (standing.h): a solve leaves them out
  // How far blends are from what was measured at places, over their mean light: RMS, of irradiance over all normals; and the place
  // where it is worst. The noise of what was measured is among it.
  double error = 0.0;
  size_t worst_place = 0;
  // The same by place, over the place's own light and a twentieth of the mean: what half of the places, and 19 of 20, stay below.
  double median_error = 0.0, p95_error = 0.0;
};

// What is lit: probes of a tree, or whatever else a look-up blends linearly, such as texels of an engine's grid.
struct LitPoints {
  std::vector<glm::dvec3> position_m;  // relative to the scene's origin
  WeightsAt around;                    // tents, as if there were no walls: what no look-up reads holds the light under these
  double spacing_m = 0.0;              // the finest
};

// tree   in the scene's coordinates; must outlive what is returned
LitPoints litPoints(const ProbeTree& tree);

// places       in air, among the points
// place_light  by place; place_groups: what each group gives of it, which is solved for by itself
// weights_at   what the look-up gives; called once a place, from any thread
ProbeLight lightProbes(const LightTransport& transport, const LitPoints& points, const std::vector<glm::dvec3>& places,
                       const std::vector<LightSh>& place_light, const WeightsAt& weights_at, const ProbeLightOptions& options,
                       int thread_count, const LightByGroup& place_groups = {});

// The same of a tree in the scene's coordinates; places in cells of it.
ProbeLight lightProbes(const LightTransport& transport, const ProbeTree& tree, const std::vector<glm::dvec3>& places,
                       const std::vector<LightSh>& place_light, const WeightsAt& weights_at, const ProbeLightOptions& options,
                       int thread_count, const LightByGroup& place_groups = {});

}  // namespace nlg
