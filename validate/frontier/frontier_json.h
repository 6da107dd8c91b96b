// Writes frontier.json (keys: docs/reference/formats.md).
#pragma once

#include <nlohmann/json.hpp>

#include "validate/frontier/front.h"
#include "validate/frontier/interleaved.h"

namespace nlg {

// Figures of the functions that take a theta, as formats.md has them: {figures: by population, null where it holds no functions;
// by_scene}.

// Of the bare tent, which takes no time and no theta: blend_rmse_mean. What does not have a smaller error is on no front.
nlohmann::ordered_json tentFigures(const FunctionSet& set, const ChosenFunctions& functions, const LossOptions& loss);

// Of a point. A time's sample is the mean over the functions of one run on one block; median and quartiles are over these samples.
nlohmann::ordered_json pointFigures(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                                    const std::vector<FunctionBlock>& blocks);

// The time of every function that takes a theta, the median of its runs, µs.
std::vector<double> functionTimes(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks);

// A word of a representation against its direct fits.
nlohmann::ordered_json speedJson(const EqualError& equal);

// Finds the fronts of median time and mean blend RMSE. The keys points, bare_tent, front_sentences and speed_at_equal_error.
//
// figures   by point
// tent      tentFigures of the same functions
// speeds    by representation and word
nlohmann::ordered_json frontierJson(const std::vector<PlotPoint>& points, const std::vector<nlohmann::ordered_json>& figures,
                                    const nlohmann::ordered_json& tent, const nlohmann::ordered_json& speeds);

}  // namespace nlg
