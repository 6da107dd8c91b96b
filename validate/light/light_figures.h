// Errors of a method's irradiance against ground truth, over sample points.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "light/methods/light_method.h"
#include "validate/light/light_places.h"

namespace nlg {

inline constexpr double kDarkShare = 0.05;   // of the level's mean irradiance: below it a place is dark
inline constexpr double kBlackShare = 0.01;  // of the level's mean: less light is black to an eye, and no share of it an error
inline constexpr uint64_t kLeastOfRoom = 8;  // places of a group: a room with fewer says nothing of it
inline constexpr size_t kWorstPlaceCount = 10;

// Irradiance at all places, and what it says of the level. "Mean" is that of the channels.
struct LightTruth {
  std::vector<GatheredIrradiance> at;  // by place
  double mean = 0.0;                   // over places in air
  double rms = 0.0;                    // over places in air and channels
  double noise = 0.0;                  // truth's own standard deviation over rms: root mean square over places in air
  uint64_t dark = 0;                   // places, but for walks and those nearer than 5 cm
};

struct TruthOptions {
  GatherOptions gather;
  uint64_t seed = 1;
  int threads = 1;  // the same truth for any number
};

LightTruth lightTruth(const LightPlaces& places, const LightTransport& transport, const TruthOptions& options);

// Over a group of places, each counting by its weight.
struct GroupFigures {
  uint64_t places = 0;
  double rmse = 0.0;                  // of all channels, over the root mean square of truth in the group
  double smape = 0.0;                 // mean of Σ|difference| / Σ(|answer| + |truth|) over channels: 0 … 1
  double unlit = 0.0, outside = 0.0;  // shares
  double energy = 1.0;                // the answers' mean over truth's; 1 where truth is black
  // By room: the root mean square of error over the light where it stands, which is truth there or the room's mean, whichever is more,
  // and kBlackShare of the level's mean at least. Then the mean over rooms.
  uint64_t rooms = 0;
  double balanced = 0.0;
};

// The answers' mean less truth's over places where too much light is a leak.
struct ExcessFigures {
  uint64_t places = 0;
  double excess = 0.0;
};

// Between neighbouring steps of walks: how much more the answer changes than truth does, 0 where it changes less. Over truth's root
// mean square in air, of all channels.
struct WalkFigures {
  uint64_t steps = 0;
  double mean = 0.0, largest = 0.0;
};

struct WorstPlace {
  uint32_t place = 0;  // index
  double error = 0.0;  // over truth's root mean square in air
};

struct LightFigures {
  GroupFigures air, surface, turned;  // surface and turned: from 5 to 50 cm
  std::array<GroupFigures, kSurfaceClassCount> surface_class, turned_class;
  ExcessFigures dark;          // where truth is below kDarkShare of the level's mean; over that mean
  ExcessFigures edge, corner;  // over truth's mean there
  WalkFigures jumps;
  std::vector<WorstPlace> worst;  // walks not among them
};

// Where a method is asked, by place.
std::vector<Receiver> receiversAt(const LightPlaces& places);

// answers   by place
LightFigures lightFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers);

// Parts of light.json (keys: docs/reference/formats.md).
nlohmann::ordered_json truthJson(const LightPlaces& places, const LightTruth& truth, bool is_baked);

// origin_m   of the scene: positions of the worst places are the world's
nlohmann::ordered_json methodJson(const LightMethod& method, const LightFigures& figures, const LightPlaces& places,
                                  const LightTruth& truth, const std::vector<LightAnswer>& answers, const glm::dvec3& origin_m);

// Lines for a terminal: what of the spacings one looks at first.
std::string lightTable(const nlohmann::ordered_json& spacings);

}  // namespace nlg
