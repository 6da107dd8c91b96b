// The options of the diffusion, for whoever generates functions.
#pragma once

#include "datagen/weighting/weighting_builder.h"
#include "tool/command/options.h"

namespace nlg {

void describe(DiffusionOptions& options, OptionTable& table);

}  // namespace nlg
