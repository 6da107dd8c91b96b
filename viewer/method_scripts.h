// Methods as scripts for the page's shaders. Positions are relative to the scene's origin.
#pragma once

#include <string>

#include "light/methods/ddgi.h"
#include "light/methods/method_set.h"
#include "viewer/data_script.h"

namespace nlg {

// A light grid: words of a shader grid, and what look_up.glsl is to be compiled for.
// grid      with light, in the scene's coordinates
// throws    InputError on a grid that shaders cannot show
DataScript gridScript(const std::string& name, const LightGrid& grid);

// A blend of the probes around by bare tents, which is the trilinear one, as a light grid without functions.
// light           by probe
// of_all_probes   false: those in solid have no weight
LightGrid trilinearGrid(const ProbeSet& probes, const std::vector<LightSh>& light, bool of_all_probes);

// DDGI as shipped: its tree, as the words of a light grid of bare tents, whose probes are in the order of maps; and a probe's maps,
// kDdgiMapWords each: 1 if it is active, 36 texels of irradiance in 10 bits a channel, 196 pairs of moments in float16.
inline constexpr size_t kDdgiMapWords = 236;  // a multiple of 4; 233 are used
DataScript ddgiScript(const ProbeSet& probes, const DdgiMaps& maps);

// Probes and cells, for drawing.
enum class ProbeKind : uint8_t {
  function,           // in air
  bare_tent,          // nothing is stored of its weights
  function_in_solid,  // its own place is in solid, but not all of what it lights
  empty,              // without weight anywhere
};
// is_in_air   by probe
DataScript probesScript(const LightGrid& grid, const std::vector<uint8_t>& is_in_air);

}  // namespace nlg
