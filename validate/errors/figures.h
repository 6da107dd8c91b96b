// The figures of one word as JSON: quantiles of errors, leaks, shares, times, each over every population. Keys: docs/reference/formats.md.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datagen/dataset/known_functions.h"
#include "validate/errors/bootstrap.h"
#include "validate/errors/measured_word.h"

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

}  // namespace nlg
