// Writes the figures of one word as JSON: quantiles of errors, leaks, shares and times, by population
// (docs/reference/formats.md).
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "validate/generators/measured_word.h"
#include "validate/generators/statistics.h"

namespace nlg {

// What all figures of a set share.
struct FigureContext {
  const FunctionSet& set;
  const Populations& populations;
  const KnownFunctions& known;  // to training
  BootstrapOptions bootstrap = {};
};

// {value, low, high}
nlohmann::ordered_json intervalJson(const Interval& interval);

// {all, theta, hard}: the figures of a word's functions in every population.
nlohmann::ordered_json figuresByPopulation(const MeasuredWord& word, Scope scope, const FigureContext& context);

// How far one word is above another, function by function of the sample: medians of ratios of blend RMSEs, {value, low, high}, over
// all (`median`) and over hard functions (`median_hard`).
//
// word        on functions that hold all of the reference's
// reference   on functions of the sample
nlohmann::ordered_json ratiosJson(const MeasuredWord& word, const MeasuredWord& reference, const FigureContext& context);

}  // namespace nlg
