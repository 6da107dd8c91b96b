#include "validate/generators/summary_json.h"

#include <filesystem>

#include "runtime_eval/evaluator/theta_form.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

Json ends(const Interval& interval) { return {interval.low, interval.high}; }

// Figures over values of functions, each with its function's scene.
struct ValuesByScene {
  std::vector<double> values;
  std::vector<uint32_t> scenes;

  void add(double value, uint32_t scene) { values.push_back(value), scenes.push_back(scene); }
};

// The columns of one population.
struct Columns {
  std::vector<uint32_t> scenes;  // of all but the occluded ones
  std::vector<double> blend_rmse, rmse, rmse_test_points, fails, fitted, elapsed_us;
  ValuesByScene rmse_occluded;
};

Columns columnsOf(const MeasuredWord& word, Scope scope, Population population, const FigureContext& context) {
  Columns columns;
  for (const MeasuredFunction& one : word.functions) {
    if (!context.populations.contains(scope, population, one.function)) continue;
    const uint32_t scene = context.set.scene_idx[one.function];
    columns.scenes.push_back(scene);
    columns.blend_rmse.push_back(one.error.blend_rmse);
    columns.rmse.push_back(one.error.rmse);
    columns.rmse_test_points.push_back(one.error.rmse_test_points);
    if (one.error.has_occluded) columns.rmse_occluded.add(one.error.rmse_occluded, scene);
    columns.fails.push_back(one.fails_check);
    columns.fitted.push_back(one.fitted);
    columns.elapsed_us.push_back(one.elapsed_us);
  }
  return columns;
}

// {median, mean, p95, p99, worst, functions}, and interval {median, mean, p95}: [low, high] each.
Json quantilesJson(const std::vector<double>& values, const SceneBootstrap& bootstrap) {
  const Quantiles q = quantiles(values);
  Json json = {{"median", q.median}, {"mean", q.mean},   {"p95", q.p95},
               {"p99", q.p99},       {"worst", q.worst}, {"functions", q.count}};
  const std::vector<Interval> quantiles = bootstrap.quantiles(values, {0.5, 0.95});
  json["interval"] = {{"median", ends(quantiles[0])}, {"mean", ends(bootstrap.mean(values))}, {"p95", ends(quantiles[1])}};
  return json;
}

Json figures(const MeasuredWord& word, Scope scope, Population population, const FigureContext& context) {
  const Columns columns = columnsOf(word, scope, population, context);
  const SceneBootstrap bootstrap(columns.scenes, context.bootstrap);
  const PooledMagnitudes& leaks = word.leaks.of(scope, population);
  return {{"functions", columns.rmse.size()},
          {"blend_rmse", quantilesJson(columns.blend_rmse, bootstrap)},
          {"rmse", quantilesJson(columns.rmse, bootstrap)},
          {"rmse_test_points", quantilesJson(columns.rmse_test_points, bootstrap)},
          {"rmse_occluded",
           quantilesJson(columns.rmse_occluded.values, SceneBootstrap(columns.rmse_occluded.scenes, context.bootstrap))},
          {"leak", {{"mean", leaks.mean()}, {"p99", leaks.quantile(0.99)}}},
          {"share_failing_check", intervalJson(bootstrap.mean(columns.fails))},
          {"share_fitted", intervalJson(bootstrap.mean(columns.fitted))},
          {"us_per_function", mean(columns.elapsed_us)}};
}

Json sampleJson(const PolicyWords& policy, const LongFits& fits, const FigureContext& context) {
  Json json = {{"functions", context.populations.count(Scope::sample, Population::theta)},
               {"hard", context.populations.count(Scope::sample, Population::hard)}};
  Json ratios;
  for (const MeasuredWord& word : policy.words) {
    json[word.name] = figuresByPopulation(word, Scope::sample, context);
    ratios[word.name] = {{"to_best_known", ratiosJson(word, fits.at(LongFit::best_known), context)}};
  }
  for (const MeasuredWord& fit : fits.words) json[fit.name] = figuresByPopulation(fit, Scope::sample, context);
  json["ratios"] = ratios;
  return json;
}

// Mean over the functions that take a theta: codes are as long as each function needs.
double meanStoredBytes(const ValidatedGenerator& validated) {
  double sum = 0.0;
  int64_t count = 0;
  for (const MadeTheta& made : validated.policy.made) {
    if (made.isBareTent()) continue;
    sum += static_cast<double>(storedThetaBytes(validated.generator.representation(), ThetaPrecision::int8, made.theta.data()));
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

// A text as a field: file stems may hold commas.
std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

}  // namespace

Json intervalJson(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

Json figuresByPopulation(const MeasuredWord& word, Scope scope, const FigureContext& context) {
  Json json;
  for (int p = 0; p < kPopulationCount; ++p) {
    const auto population = static_cast<Population>(p);
    json[populationName(population)] = figures(word, scope, population, context);
  }
  return json;
}

Json ratiosJson(const MeasuredWord& word, const MeasuredWord& reference, const FigureContext& context) {
  Json json;
  for (const auto& [name, population] : {std::pair("median", Population::theta), {"median_hard", Population::hard}}) {
    ValuesByScene ratios;
    size_t at = 0;  // in the word's functions, which rise as the reference's do
    for (const MeasuredFunction& one : reference.functions) {
      while (word.functions[at].function != one.function) ++at;
      if (!context.populations.contains(Scope::sample, population, one.function) || !(one.error.blend_rmse > 0.0)) continue;
      ratios.add(word.functions[at].error.blend_rmse / one.error.blend_rmse, context.set.scene_idx[one.function]);
    }
    const SceneBootstrap bootstrap(ratios.scenes, context.bootstrap);
    json[name] = intervalJson(bootstrap.quantiles(ratios.values, {0.5}).front());
  }
  return json;
}

Json tauJson(const ValidateOptions& options) {
  const CheckOptions& check = options.policy.check();
  return {{"rmse", check.tau_rmse},
          {"blend", check.tau_blend},
          {"leak", check.tau_leak},
          {"dark_weight", check.dark_weight},
          {"blend_floor", check.blend_floor},
          {"hard_tent_rmse", options.hard_tent_rmse},
          {"bare_tent_rmse", options.policy.bare_tent_rmse}};
}

Json functionsJson(const ShardCounts& counts, const FigureContext& context) {
  return {{"distinct", counts.functions},
          {"free_space", counts.free_space},
          {"duplicates", counts.duplicates},
          {"in_solid", counts.in_solid},
          {"empty", counts.empty},
          {"outside", counts.outside},
          {"visited_probes", counts.visited_probes},
          {"grid_probes", counts.grid_probes},
          {"held_out", context.set.functionCount()},
          {"held_out_scenes", context.set.scene_ids.size()},
          {"take_theta", context.populations.count(Scope::set, Population::theta)},
          {"hard", context.populations.count(Scope::set, Population::hard)},
          {"held_out_in_training", context.known.countInTraining()},
          {"held_out_in_training_mirrored", context.known.countInTrainingMirrored()}};
}

Json inTrainingJson(const FigureContext& context) {
  const std::vector<std::string>& names = context.set.scene_ids;
  std::vector<uint64_t> functions(names.size()), known(names.size());
  for (uint64_t i = 0; i < context.set.functionCount(); ++i) {
    if (!context.populations.takesTheta(i)) continue;
    ++functions[context.set.scene_idx[i]];
    known[context.set.scene_idx[i]] += context.known.in_training_mirrored[i];
  }
  Json json = Json::object();
  for (size_t s = 0; s < names.size(); ++s) json[names[s]] = {{"take_theta", functions[s]}, {"in_training", known[s]}};
  return json;
}

Json bootstrapJson(const FigureContext& context) {
  return {{"over", "scenes, and functions of each"},
          {"scenes", context.set.scene_ids.size()},
          {"resamples", context.bootstrap.resamples},
          {"confidence", context.bootstrap.confidence},
          {"seed", context.bootstrap.seed}};
}

Json stagesJson(const std::vector<StagePlan>& plan) {
  Json json = Json::array();
  for (const StagePlan& stage : plan) {
    const std::string budget = budgetText(stage);
    json.push_back({{"name", stageName(stage.stage)},
                    {"title", stageTitle(stage.stage)},
                    {"word", wordName(wordOf(stage.stage))},
                    {"budget", budget.empty() ? Json(nullptr) : Json(budget)},
                    {"takes", takersText(stage)},
                    {"text", describe(stage)}});
  }
  return json;
}

Json thetaBytesJson(const Representation& representation) {
  Json json;
  for (const ThetaPrecision precision : {ThetaPrecision::float32, ThetaPrecision::float16, ThetaPrecision::int8}) {
    json[thetaPrecisionName(precision)] = thetaForm(representation, precision).bytes();
  }
  return json;
}

Json representationJson(const ValidatedGenerator& validated, const FigureContext& context) {
  const Representation& representation = validated.generator.representation();
  Json json = {{"parameters", representation.thetaCount()},       {"theta_bytes", thetaBytesJson(representation)},
               {"stored_bytes_mean", meanStoredBytes(validated)}, {"weights_bytes", std::filesystem::file_size(validated.path)},
               {"weights_sha256", fileSha256(validated.path)},    {"evaluate_us", measureEvaluation(representation)},
               {"stages", stagesJson(validated.policy.plan)}};
  for (const MeasuredWord& word : validated.policy.words) json[word.name] = figuresByPopulation(word, Scope::set, context);
  json["sample"] = sampleJson(validated.policy, validated.fits, context);
  return json;
}

// results, functions.csv, slices.json with slices and without
const OwnFiles kValidationFiles = {"a file of nlg-validate", [](std::string_view bytes) {
                                     return hold(bytes, "\"nlg-validate") || bytes.starts_with("representation,word,") ||
                                            bytes.starts_with(R"([{"which":)") || bytes == "[]";
                                   }};

void appendCsv(const std::string& representation, const MeasuredWord& word, const FunctionSet& set,
               const Populations& populations, std::ostream& csv) {
  for (const MeasuredFunction& one : word.functions) {
    const FunctionError& error = one.error;
    csv << representation << ',' << word.name << ',' << one.function << ','
        << csvField(set.scene_ids[set.scene_idx[one.function]]) << ',' << populations.takesTheta(one.function) << ','
        << populations.isHard(one.function) << ',' << error.blend_rmse << ',' << error.rmse << ',' << error.rmse_test_points
        << ',';
    if (error.has_occluded) csv << error.rmse_occluded;
    csv << ',' << error.leak_mean << ',' << error.leak_p99 << ',' << one.fails_check << ',' << one.fitted << ',' << one.elapsed_us
        << '\n';
  }
}

}  // namespace nlg
