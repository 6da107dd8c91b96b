// Savings: a line for everything that a bake left out because its scene does not need it, and for what it could leave out and does
// not yet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake/scene_bake.h"

namespace nlg {

// The lines' names, in the order of the table; they are the key "what" of the report.
namespace saving {
inline constexpr const char* kFreeSpace = "probes in free space";
inline constexpr const char* kInSolid = "probes in solid";
inline constexpr const char* kEmpty = "probes whose function is 0 everywhere";
inline constexpr const char* kDuplicates = "duplicates";
inline constexpr const char* kAllProbes = "all of these probes together";
inline constexpr const char* kLargerGenerators = "functions that the smallest representation already fits";
inline constexpr const char* kLargestTheta = "theta of the largest representation";
inline constexpr const char* kBareTent = "functions that are all but the bare tent";
inline constexpr const char* kPassingTent = "functions whose bare tent passes the check";
inline constexpr const char* kGoodTheta = "corrections and fits of thetas that are good";
inline constexpr const char* kRefinement = "refinements";
inline constexpr const char* kNeverChosen = "representations and resolutions never chosen";
inline constexpr const char* kNeverChosenGenerators = "generators of representations never chosen";
inline constexpr const char* kThetaBits = "bits of theta beyond its stored form";
inline constexpr const char* kSolidRays = "rays that tell air from solid, of probes in free space";
inline constexpr const char* kLevels = "look-up levels without a node";
inline constexpr const char* kThroughLevels = "look-up levels that only lead on";
inline constexpr const char* kEmptyRoots = "roots of the probe tree that hold nothing";
inline constexpr const char* kAirlessCells = "cells without air";
inline constexpr const char* kUnreadProbes = "probes that only cells without air read";
inline constexpr const char* kStoredBounces = "bounces that the level's own light holds";
inline constexpr const char* kSharedBounces = "bounces traced once for all probes";
inline constexpr const char* kLightBits = "bits and coefficients of light beyond the file's form";
}  // namespace saving

struct Saving {
  std::string what;
  std::optional<bool> left_out;  // false: could be, and is not yet; nothing: there is none of it in this bake
  uint64_t count = 0, of = 0;    // how many of how many
  // Of what is left out: what the bake would take more with it; of what is not: what it would take less without. Below 0 where
  // leaving out costs more than it saves. Nothing where it was not measured or cannot be counted.
  std::optional<double> seconds_saved;  // of the processor, all threads together
  std::optional<int64_t> bytes_saved;   // of the light grid's file; of never chosen representations, of their weights
  std::optional<bool> same_result;  // whether every look-up that was compared, all in air, gives the same bits with and without
  std::string note;
  // How far apart measuring the same twice comes: a saving that is not above it was not seen. Nothing where nothing was measured.
  std::optional<double> seconds_noise = {};
};

// The table by counting alone: no seconds, and bytes where counts tell them.
//
// generators      those of the bake, and weights_bytes the sizes of their files, in the same order
// tree of bake    unmoved or moved: only its shape is looked at
std::vector<Saving> countSavings(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
                                 const std::vector<uint64_t>& weights_bytes);

// The line of a name; nothing when the table has none.
Saving* findSaving(std::vector<Saving>& savings, const std::string& what);

// Keys: docs/guide/bake.md.
nlohmann::ordered_json toJson(const std::vector<Saving>& savings);
// One line of text each.
std::string toTable(const std::vector<Saving>& savings);

}  // namespace nlg
