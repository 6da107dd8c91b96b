// What a grid's file says of its bake, for who bakes again.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "bake/prepared_scene.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "tool/command/options.h"
#include "tool/output_path.h"

namespace nlg {

// Files of nlg-bake and nlg-view of any version, which these tools may overwrite.
extern const OwnFiles kGridFiles, kReportFiles;

// Roles of inputs. That of light has another name whenever the list of what the hashes are of becomes another one (scene/model/scene.cpp).
inline constexpr const char* kWeightsRole = "weights of ";
inline constexpr const char* kLightRole = "scene and light";
inline constexpr const char* kUngroupedRole = "scene and light without groups";  // of scenes that have any
inline constexpr const char* kSearchedRole = "cells searched for air";           // PreparedScene::searched_sha256

// The settings that what a grid holds depends on.
nlohmann::ordered_json bakedOptions(const OptionTable& table);

// options   as bakedOptions has them
// weights   SHA-256 by kWeightsRole + representation
GridMetadata bakeMetadata(const PreparedScene& scene, const nlohmann::ordered_json& options,
                          const std::map<std::string, std::string>& weights);

struct BakedGrid {
  LightGrid grid;
  GridMetadata metadata;
};

// throws   InputError when the file is no light grid
BakedGrid readBakedGrid(const std::string& path);

// The same, of a grid with light. throws   InputError when it has none
BakedGrid readLitGrid(const std::string& path);

// Finest distance between the probes of a baked grid, metres, outside boxes with a spacing of their own (nlg_density).
double bakedSpacing(const LightGrid& grid, const GridMetadata& metadata);

// What the grid's provenance has at a JSON pointer: null, or an empty text, where it has nothing there, or not the kind.
nlohmann::ordered_json provenanceAt(const GridMetadata& metadata, const std::string& place);
std::string textAt(const GridMetadata& metadata, const std::string& place);

// The grid's provenance: `options` and `inputs`. path   of the grid, for messages
// throws   InputError where the grid does not say what it was baked of
nlohmann::ordered_json originOf(const std::string& path, const BakedGrid& baked);

// Of an origin: SHA-256 by kWeightsRole + representation.
std::map<std::string, std::string> weightsOf(const nlohmann::ordered_json& origin);

// Of an origin: the settings that are others now, as JSON.
struct ChangedSetting {
  std::string name, before, now;
};
std::vector<ChangedSetting> changedSettings(const OptionTable& table, const nlohmann::ordered_json& origin);

bool sameGeometry(const SceneSource& source, const BakedGrid& baked, const nlohmann::ordered_json& origin);

// What a grid was baked with that another scene has otherwise, its name or its light, in words for a warning; empty where nothing is, or
// where the grid does not say. How the light is put in groups does not count: what asks sums them.
std::string otherSceneOrLight(const GridMetadata& metadata, const SceneSource& source);

// throws   as originOf
KnownAir knownAir(const std::string& path, const BakedGrid& baked);

// Whether the probes of a bake would stand where those of the grid do: light may move them, since probes reach as far as lamps do.
bool standsWhere(const PreparedScene& scene, const BakedGrid& baked);

}  // namespace nlg
