// Bakes that are to end in time (max_seconds): what costs least of the picture is left out, by what samples of this bake's own work take.
//
// Seconds are those of the clock, on a machine that may have other things to do: they are aimed at, not kept for certain.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bake/scene_bake.h"

namespace nlg {

// Probes stand at most so many times as far apart as they were asked to.
inline constexpr double kMostCoarser = 4.0;

// What parts of a bake are going to take, seconds by the clock.
struct BakeCosts {
  FunctionCosts functions;
  double rays_s = 0.0;   // light at places and bounces, with the rays and places that were asked for
  double solve_s = 0.0;  // and what comes behind it
};

// Leaves out what costs least of the picture (docs/lab/light.md, "Less time"), one after another, until the bake is likely to end in time:
// refinement, which gets whatever time is left, short fits, and rays of places. Where even that is too much, all of them are left out.
BakeOptions inTime(const BakeOptions& asked, const BakeCosts& costs, double left_s);
// What is left then, refinement not among it.
// asked   as costs are of
double secondsOf(const BakeOptions& chosen, const BakeOptions& asked, const BakeCosts& costs);
// "probes 1.25 m apart, 16 rays a place"; empty where nothing is left out.
std::string leftOutText(const BakeOptions& asked, const BakeOptions& chosen);

// What a bake came to.
struct ChosenInTime {
  BakeOptions options;       // settings that it took: with them any bake makes this grid, but for refinement that time cut short
  bool is_coarsest = false;  // since there was likely to be no time even for that
};

struct BakedInTime {
  Bake bake;
  ChosenInTime chosen;
};

// throws   UsageError where settings ask for what takes nobody knows how long
void requireKnownTimes(const BakeOptions& options);

// scene     of these options; made anew where its probes have to stand further apart
// options   that requireKnownTimes lets pass
// left_s    seconds, now
// throws    as bakeScene does
BakedInTime bakeInTime(std::unique_ptr<BakeScene>* scene, const std::vector<Generator>& generators, const BakeOptions& options,
                       const std::string& spool_folder, const std::function<double()>& left_s);

// The same for light alone: what of it there is time for. Rays go first, then places.
//
// scene   made anew where it has to have fewer places
// known   that the scene was made with
// grid    of that scene
ChosenInTime chooseLightInTime(std::unique_ptr<BakeScene>* scene, const KnownAir& known, const LightGrid& grid,
                               const BakeOptions& options, const std::function<double()>& left_s);

}  // namespace nlg
