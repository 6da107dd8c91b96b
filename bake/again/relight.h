// The command nlg-bake --relight: functions depend on geometry alone, so that other lamps, skies, suns and materials need only new light,
// unless they move the probes.
#pragma once

#include "bake/bake_command.h"

namespace nlg {

// Writes the grid that a whole bake with this light would, byte for byte.
// throws   InputError that names the first thing in which the functions of the grid are not those of such a bake: the scene, a setting
//          other than of light, a representation, or where probes stand; and as a bake does
void runRelight(BakeRequest request, const BakeOptions& options, const OptionTable& table);

}  // namespace nlg
