// How far a method's irradiance is from ground truth, over places.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "light/methods/light_method.h"
#include "validate/light/light_places.h"

namespace nlg {

inline constexpr double kDarkShare = 0.05;        // of the level's mean irradiance: below it a place is dark
inline constexpr double kEdgeBlackShare = 0.001;  // of it: less light is black to an eye that is used to the dark
inline constexpr double kExposedMean = 0.18;      // what a display shows the level's mean irradiance as: middle grey
inline constexpr size_t kWorstPlaceCount = 10;

// Irradiance at all places, and what it says of the level. "Mean" is that of the channels.
struct LightTruth {
  std::vector<GatheredIrradiance> at;  // by place
  double mean = 0.0;                   // over places in air
  double rms = 0.0;                    // over places in air and channels
  double noise = 0.0;                  // truth's own standard deviation over rms: root mean square over places in air
  uint64_t dark = 0;                   // places, but for walks and those nearer than 5 cm
};

LightTruth lightTruth(const LightPlaces& places, const LightTransport& transport, const GatherOptions& options, uint64_t seed,
                      int thread_count);

// Over a group of places, each counting by its weight.
struct GroupFigures {
  uint64_t places = 0;
  double rmse = 0.0;         // of all channels, over the root mean square of truth in the group
  double smape = 0.0;        // mean of Σ|difference| / Σ(|answer| + |truth|) over channels: 0 … 1
  double colour_mean = 0.0;  // HyAB, of a white surface at an exposure that shows the level's mean as middle grey
  double colour_p95 = 0.0;
  double unlit = 0.0, outside = 0.0, fallback = 0.0;  // shares
};

struct DarkFigures {
  uint64_t places = 0;
  double truth = 0.0;   // mean over dark places, over the level's mean
  double excess = 0.0;  // the answer's mean less truth's: what leaks
  double added = 0.0;   // mean of what answers are brighter than truth by, where they are
};

// Of places beside edges, or in corners.
struct EdgeFigures {
  uint64_t places = 0;
  double truth = 0.0;                          // mean, over the level's mean
  double excess = 0.0;                         // the answers' mean over truth's, less 1: pooled over places
  double ratio_median = 0.0, ratio_p95 = 0.0;  // answer over truth where it stands; truth is taken for kEdgeBlackShare at least
};

// Between neighbouring steps of walks: how much more the answer changes than truth does, 0 where it changes less. Over truth's root
// mean square in air, of all channels.
struct WalkFigures {
  uint64_t steps = 0;
  double mean = 0.0, p99 = 0.0, largest = 0.0;
};

struct WorstPlace {
  uint32_t place = 0;  // index
  double error = 0.0;  // over truth's root mean square in air
};

struct LightFigures {
  GroupFigures air, surface, turned;  // surface and turned: from 5 to 50 cm
  std::array<GroupFigures, kSurfaceClassCount> surface_class, turned_class;
  DarkFigures dark;
  EdgeFigures edge, corner;
  WalkFigures jumps;
  std::vector<WorstPlace> worst;  // walks not among them
};

// answers   by place
LightFigures lightFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers);

}  // namespace nlg
