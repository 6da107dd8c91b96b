// How far one word is above another, function by function of the sample: medians of ratios, with intervals.
#pragma once

#include <functional>

#include <nlohmann/json.hpp>

#include "validate/errors/figures.h"

namespace nlg {

// {median, median_hard, median_rmse, median_test_points, median_occluded_hard}: of word's error over the reference's, {value, low, high}
// each. The first two are of blend RMSEs, by which best known is the best; the others, of RMSEs, may be below 1.
// word        on functions that hold all of the reference's
// reference   on functions of the sample
// counts      which functions take part
nlohmann::ordered_json ratiosJson(const MeasuredWord& word, const MeasuredWord& reference, const FigureContext& context,
                                  const std::function<bool(uint64_t function)>& counts);

}  // namespace nlg
