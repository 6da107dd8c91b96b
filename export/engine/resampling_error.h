// What a resampled texture gets wrong of a light grid's own look-up.
#pragma once

#include <cstdint>
#include <optional>

#include "export/engine/engine_format.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

// Differences from lookUpIrradiance, over the root mean square of irradiance at the same places; red, green and blue count alike.
struct ResamplingError {
  int64_t places = 0;
  double rmse = 0.0, p95 = 0.0;            // of planes that face any direction; p95: of places' own root mean squares
  double axes_rmse = 0.0, axes_p95 = 0.0;  // of planes that face along an axis, as most floors and walls do
};

// At places drawn uniformly in the volume of the used cells, where the look-up is lit, on a plane that faces any direction and on one
// that faces along an axis. The seed is fixed.
//
// box       places outside of it are not drawn; nullptr: all cells
// wanted    places; fewer where so few of those that are drawn are lit, 50 times as many at most
// returns   nothing where no place was lit, or light is 0 at all of them
std::optional<ResamplingError> resamplingError(const LightGrid& grid, const LightBox* box, const EngineIrradiance& irradiance,
                                               int64_t wanted);

}  // namespace nlg
