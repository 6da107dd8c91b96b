// The command nlg-bake --relight: functions depend on geometry alone, so that other lamps, skies, suns and materials need only new light,
// unless they move the probes.
#pragma once

#include "bake/bake_command.h"

namespace nlg {

// Writes the grid that a whole bake with this light would, byte for byte; or, of another light_state than the grid's, the grid with this
// light beside its own, dark to begin with.
// throws   InputError that names the first thing in which the functions of the grid are not those of such a bake: the scene, a setting
//          other than of light, a representation, or where probes stand; on a grid that cannot take
//          another state of light, or holds several; and as a bake does
void runRelight(BakeRequest request, const BakeOptions& options, const OptionTable& table);

}  // namespace nlg
