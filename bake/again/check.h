// The command nlg-bake --check: says what has changed since a grid was baked, and bakes nothing.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bake/again/bake_provenance.h"
#include "bake/bake_command.h"

namespace nlg {

inline constexpr const char* kLightChanged = "light changed";
inline constexpr const char* kGroupsChanged = "groups of light changed";  // and nothing else of it

// What has changed, a line each: "geometry changed", kLightChanged, kGroupsChanged, "the scene's name changed to hall", "setting changed:
// spacing_m from 1.0 to 0.5", "weights changed". None: a bake would make the same grid, but for what another revision of the bake, or
// another machine's instructions, do otherwise, and for where light moves probes to (standsWhere).
//
// weights   SHA-256 by role, those that a bake would take now
// throws    InputError where the grid does not say what it was baked of
std::vector<std::string> changesSince(const std::string& path, const BakedGrid& baked, const SceneSource& source,
                                      const OptionTable& table, const std::map<std::string, std::string>& weights);

// throws   ToolError with ExitCode::check_failed where the grid is out of date; as changesSince, and as a bake does
void runCheck(BakeRequest request, const BakeOptions& options, const OptionTable& table);

}  // namespace nlg
