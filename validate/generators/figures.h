// Writes the figures of one word as JSON: quantiles of errors, leaks, shares and times, by population
// (docs/reference/formats.md).
#pragma once

#include <functional>
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

// Figures over values of functions, each with its function's scene.
struct ValuesByScene {
  std::vector<double> values;
  std::vector<uint32_t> scenes;

  void add(double value, uint32_t scene) { values.push_back(value), scenes.push_back(scene); }
};

// {value, low, high}
nlohmann::ordered_json intervalJson(const Interval& interval);
// {median, mean, p95, p99, worst, functions}
nlohmann::ordered_json quantilesJson(const std::vector<double>& values);
// … and interval {median, mean, p95}: [low, high] each
nlohmann::ordered_json quantilesJson(const ValuesByScene& values, const BootstrapOptions& bootstrap);

// {all, theta, hard}: the figures of a word's functions in every population.
nlohmann::ordered_json figuresByPopulation(const MeasuredWord& word, Scope scope, const FigureContext& context);

// How far one word is above another, function by function of the sample: medians of ratios, with intervals.
//
// {median, median_hard, median_rmse, median_test_points, median_occluded_hard}: of word's error over the reference's, {value, low, high}
// each. The first two are of blend RMSEs, by which best known is the best; the others, of RMSEs, may be below 1.
// word        on functions that hold all of the reference's
// reference   on functions of the sample
// counts      which functions take part
nlohmann::ordered_json ratiosJson(const MeasuredWord& word, const MeasuredWord& reference, const FigureContext& context,
                                  const std::function<bool(uint64_t function)>& counts);

}  // namespace nlg
