// Errors of a method's irradiance against ground truth, over sample points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "light/methods/light_method.h"
#include "validate/light/light_places.h"

namespace nlg {

inline constexpr double kDarkShare = 0.05;   // of the level's mean irradiance, or of what is around: below it a place is dark
inline constexpr double kBlackShare = 0.01;  // of the level's mean: less light is black to an eye, and no share of it an error
inline constexpr double kEdgeBlackShare = 0.001;  // likewise, to an eye that is used to the dark
inline constexpr double kExposedMean = 0.18;      // what a display shows the level's mean irradiance as: middle grey
inline constexpr int kAroundPlaces = 8;           // in air, drawn around a place
inline constexpr uint64_t kLeastOfRoom = 8;       // places of a group: a room with fewer says nothing of it
inline constexpr size_t kWorstPlaceCount = 10;

// Irradiance at all places, and what it says of the level. "Mean" is that of the channels.
struct LightTruth {
  std::vector<GatheredIrradiance> at;  // by place
  double mean = 0.0;                   // over places in air
  double rms = 0.0;                    // over places in air and channels
  double noise = 0.0;                  // truth's own standard deviation over rms: root mean square over places in air
  uint64_t dark = 0;                   // places, but for walks and those nearer than 5 cm
  // The brightest of kAroundPlaces places in air within around_m of each: irradiance, its mean over all normals. 0 for walks, edges
  // and corners, and those nearer than 5 cm.
  std::vector<double> around;
};

struct TruthOptions {
  GatherOptions gather;
  double around_m = 1.0;  // how far a look-up reaches: the finest spacing. 0: nothing is looked for around places
  uint64_t seed = 1;
  int threads = 1;  // the same truth for any number
};

LightTruth lightTruth(const LightPlaces& places, const LightTransport& transport, const TruthOptions& options);

// Over a group of places, each counting by its weight.
struct GroupFigures {
  uint64_t places = 0;
  double rmse = 0.0;         // of all channels, over the root mean square of truth in the group
  double smape = 0.0;        // mean of Σ|difference| / Σ(|answer| + |truth|) over channels: 0 … 1
  double colour_mean = 0.0;  // HyAB, of a white surface at an exposure that shows the level's mean as middle grey
  double colour_p95 = 0.0;
  double unlit = 0.0, outside = 0.0, fallback = 0.0;  // shares
  double energy = 1.0;                                // the answers' mean over truth's; 1 where truth is black
  // By room: the root mean square of error over the light where it stands, which is truth there or the room's mean, whichever is more,
  // and kBlackShare of the level's mean at least. Then the mean over rooms.
  uint64_t rooms = 0;
  double balanced = 0.0;
  std::vector<double> room_energy;  // by room, the same rooms; the largest first
};

// Of places where truth is below kDarkShare of a scale: the level's mean, or what is around. All over that scale's mean.
struct DarkFigures {
  uint64_t places = 0;
  double truth = 0.0;   // mean over dark places
  double excess = 0.0;  // the answer's mean less truth's: what leaks
  double added = 0.0;   // mean of what answers are brighter than truth by, where they are
};

// Of places beside edges, or in corners.
struct EdgeFigures {
  uint64_t places = 0;
  double truth = 0.0;                          // mean, over the level's mean
  double excess = 0.0;                         // the answers' mean over truth's, less 1: pooled over places
  double ratio_median = 0.0, ratio_p95 = 0.0;  // answer over truth where it stands; truth is taken for kEdgeBlackShare at least
  uint64_t rooms = 0;
  double balanced = 0.0;  // the mean over rooms of their own excess, truth's mean taken for kEdgeBlackShare at least
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
  DarkFigures dark, beside_light;  // by the level's mean; by what is around
  EdgeFigures edge, corner;
  WalkFigures jumps;
  std::vector<WorstPlace> worst;  // walks not among them
};

// Where a method is asked, by place.
std::vector<Receiver> receiversAt(const LightPlaces& places);

// answers   by place
LightFigures lightFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers);

}  // namespace nlg
