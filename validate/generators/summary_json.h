// Writes the parts of summary.json, schema version 2, and figures as JSON: quantiles of errors, leaks, shares and times, by population
// (docs/reference/formats.md).
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "tool/output_path.h"
#include "validate/generators/best_known.h"
#include "validate/generators/measured_word.h"
#include "validate/generators/policy_words.h"
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

// Everything that was measured of one generator.
struct ValidatedGenerator {
  const Generator& generator;
  std::string path;  // where it was read from
  PolicyWords policy;
  LongFits fits;
};

nlohmann::ordered_json tauJson(const ValidateOptions& options);
nlohmann::ordered_json functionsJson(const ShardCounts& counts, const FigureContext& context);
// By scene: functions that take a theta, and how many of them some training scene has too, as they are or mirrored.
nlohmann::ordered_json inTrainingJson(const FigureContext& context);
nlohmann::ordered_json bootstrapJson(const FigureContext& context);
// A stage a line: name, word, population, above_rmse, budget, and the sentence that --help prints.
nlohmann::ordered_json stagesJson(const std::vector<StagePlan>& plan);
nlohmann::ordered_json representationJson(const ValidatedGenerator& validated, const FigureContext& context);

// Whatever nlg-validate writes.
extern const OwnFiles kValidationFiles;

// functions.csv: one line a function and word, under this one.
inline constexpr const char* kCsvHead =
    "representation,word,function,scene,take_theta,hard,blend_rmse,rmse,rmse_test_points,rmse_occluded,leak_mean,leak_p99,"
    "fails_check,fitted,elapsed_us\n";

// representation   "tent" for the bare tent, which is of none
void appendCsv(const std::string& representation, const MeasuredWord& word, const FunctionSet& set,
               const Populations& populations, std::ostream& csv);

}  // namespace nlg
