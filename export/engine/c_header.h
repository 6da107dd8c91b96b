// For programs in C: grid.bin, as `nlg-export shader` writes it, and nlg_light_grid.h, which looks up in it with no library at all.
// Nothing is resampled.
#pragma once

#include <string_view>

#include "export/engine/engine_format.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

extern const std::string_view kCHeaderText;  // runtime_eval/shader_grid/nlg_light_grid.h

// grid       one that checkLightGrid accepts
// returns    that of packShaderGrid; *files is empty where it is not ok
FileResult cHeaderFiles(const LightGrid& grid, std::vector<EngineFile>* files);

// The header's own look-up, in grid.bin of any format that has it.
EngineIrradiance readCHeader(const std::vector<EngineFile>& files);

}  // namespace nlg
