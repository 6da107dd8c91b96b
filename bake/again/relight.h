// Relights a baked grid: functions depend on geometry alone, so that other lamps, skies, suns and materials need only new
// light, unless they move the probes.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "bake/light_bake.h"
#include "bake/prepared_scene.h"
#include "tool/command/options.h"

namespace nlg {

struct BakedGrid {
  LightGrid grid;
  GridMetadata metadata;
};

// throws   InputError when the file is no light grid
BakedGrid readBakedGrid(const std::string& path);

// throws   InputError where the grid does not say what it was baked of
KnownAir knownAir(const std::string& path, const BakedGrid& baked);

// Whether the functions of a grid are those that a bake of this scene with these settings would make. What the scene is lit by, and the
// settings of light, may be others.
//
// asked   representations; the default ones are taken for none
// path    of the grid, for messages
// table   of the bake's options, with their values of now
// throws  InputError that names the first thing that differs: the scene, a setting, a representation, or where probes stand
void requireFunctionsOf(const PreparedScene& scene, const OptionTable& table, const std::vector<std::string>& asked,
                        const std::string& path, const BakedGrid& baked);
// Whether the probes of a bake would stand where those of the grid do: light may move them, since probes reach as far as lamps do.
bool standsWhere(const PreparedScene& scene, const BakedGrid& baked);

inline constexpr const char* kLightChanged = "light changed";
inline constexpr const char* kGroupsChanged = "groups of light changed";  // and nothing else of it

// What has changed since a grid was baked, a line each: "geometry changed", kLightChanged, kGroupsChanged,
// "the scene's name changed to hall", "setting changed: spacing_m from 1.0 to 0.5", "weights changed". None: a bake would make the same grid, but for what another revision of
// the bake, or another machine's instructions, do otherwise, and for where light moves probes to (standsWhere).
//
// weights   SHA-256 by role, those that a bake would take now
// throws    InputError where the grid does not say what it was baked of
std::vector<std::string> changesSince(const std::string& path, const BakedGrid& baked, const SceneSource& source,
                                      const OptionTable& table, const std::map<std::string, std::string>& weights);

// The grid as a whole bake with this light would have left it, byte for byte; what of its metadata tells of light is of now.
LightStatistics relight(const PreparedScene& scene, const BakeOptions& options, const OptionTable& table, BakedGrid* baked);

}  // namespace nlg
