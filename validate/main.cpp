// nlg-validate: how good exported generators are on held-out scenes, against direct optimisation and the bare tent.
// Writes summary.json, functions.csv and slices.json; docs/reference/formats.md says what stands in them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <sstream>

#include <nlohmann/json.hpp>

#include "bake/refinement_options.h"
#include "tool/atomic_file.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"
#include "validate/compare/compare_command.h"
#include "validate/errors/choice.h"
#include "validate/errors/csv_field.h"
#include "validate/errors/held_out.h"
#include "validate/errors/method.h"
#include "validate/errors/slice.h"
#include "validate/frontier/frontier_command.h"
#include "validate/look_up/look_up_command.h"
#include "validate/stability/stability_suite.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

struct Request {
  std::vector<std::string> weights, held_out, training;
  std::string out_dir;
};

void describe(ValidateOptions& o, OptionTable& table) {
  table.add("seed", &o.seed, "seed of random starts");
  table.add("direct_functions", &o.direct_functions, "held-out functions that fits are measured on", 1, 1000000);
  table.add("adam_refine_steps", &o.adam_refine_steps, "Adam steps when every function is refined", 0, 1000000);
  table.add("lm_refine_iterations", &o.lm_refine_iterations, "LM iterations when every function is refined", 0, 100000);
  describeCorrection(o.correction, table);
  describeRefinement(o.refinement, table);
  describeChoice(o.choice, table);
  table.add("hard_tent_rmse", &o.hard_tent_rmse, "hard functions: the bare tent's RMSE is at least this", 0.0, 1.0);
  table.add("direct_adam_steps", &o.direct.adam_steps, "direct optimisation: Adam steps a start", 0, 10000000);
  table.add("direct_lm_iterations", &o.direct.levenberg_iterations, "direct optimisation: LM iterations a start", 0, 100000);
  table.add("direct_restarts", &o.direct.restarts, "direct optimisation: random starts", 1, 1000);
  table.add("threads", &o.threads, "threads for fits; 0: all cores", 0, 1024);
}

Json quantilesJson(const std::vector<double>& values) {
  const Quantiles q = quantiles(values);
  return {{"median", q.median}, {"mean", q.mean}, {"p95", q.p95}, {"p99", q.p99}, {"worst", q.worst}, {"functions", q.count}};
}

// The figures of one method, over the functions that it ran on. hard: by function of the set.
Json methodJson(const MethodResult& method, const std::vector<bool>& hard, const ValidateOptions& options) {
  std::vector<double> rmse, rmse_hard, rmse_unseen, rmse_shadow, elapsed_us;
  uint64_t over_tau = 0;
  for (const MethodSample& sample : method.samples) {
    rmse.push_back(sample.error.rmse);
    if (hard[sample.function]) rmse_hard.push_back(sample.error.rmse);
    rmse_unseen.push_back(sample.error.rmse_unseen);
    if (sample.error.has_shadow) rmse_shadow.push_back(sample.error.rmse_shadow);
    elapsed_us.push_back(sample.elapsed_us);
    over_tau += needsRefinement(sample.error, options);
  }
  const Quantiles time = quantiles(elapsed_us);
  const double count = std::max<double>(1.0, static_cast<double>(method.samples.size()));
  return {{"functions", method.samples.size()},
          {"rmse", quantilesJson(rmse)},
          {"rmse_hard", quantilesJson(rmse_hard)},
          {"rmse_unseen_points", quantilesJson(rmse_unseen)},
          {"rmse_shadow", quantilesJson(rmse_shadow)},
          {"leak", {{"mean", method.leaks.mean()}, {"p99", method.leaks.quantile(0.99)}}},
          {"share_over_tau", static_cast<double>(over_tau) / count},
          {"us_per_function", time.mean},
          {"us_per_function_median", time.median}};
}

// The samples of a method on some functions only, so that methods that ran on more can be compared with those that did not.
// generator   null for the bare tent
MethodResult restrictTo(const MethodResult& method, const std::vector<uint64_t>& functions, const Generator* generator,
                        const std::vector<float>& theta, const FunctionSet& set) {
  MethodResult result{method.name};
  ErrorMeter meter(set);
  for (const uint64_t function : functions) {
    result.samples.push_back(method.samples[function]);
    if (generator) {
      meter.measure(generator->representation(),
                    &theta[function * static_cast<uint64_t>(generator->representation().thetaCount())], function, &result.leaks);
    } else {
      meter.measureTent(function, &result.leaks);
    }
  }
  return result;
}

// Median over functions of a's RMSE over b's.
// rmse_of   of an error: null where a function has none; hard: null for all functions
double medianRatio(const MethodResult& a, const MethodResult& b, const std::vector<bool>* hard,
                   const std::function<const double*(const FunctionError&)>& rmse_of) {
  std::vector<double> ratios;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    if (hard && !(*hard)[a.samples[i].function]) continue;
    const double *numerator = rmse_of(a.samples[i].error), *denominator = rmse_of(b.samples[i].error);
    if (numerator && denominator && *denominator > 0) ratios.push_back(*numerator / *denominator);
  }
  return quantile(ratios, 0.5);
}

// How far a method is above direct optimisation, function by function.
Json ratioToDirect(const MethodResult& method, const MethodResult& direct, const std::vector<bool>& hard) {
  const auto rmse = [](const FunctionError& error) { return &error.rmse; };
  const auto unseen = [](const FunctionError& error) { return &error.rmse_unseen; };
  const auto shadow = [](const FunctionError& error) { return error.has_shadow ? &error.rmse_shadow : nullptr; };
  return {{"reference", "direct: best of Adam and LM from theta0 and from random starts, per function"},
          {"median", medianRatio(method, direct, nullptr, rmse)},
          {"median_hard", medianRatio(method, direct, &hard, rmse)},
          {"median_unseen_points", medianRatio(method, direct, nullptr, unseen)},
          {"median_shadow_hard", medianRatio(method, direct, &hard, shadow)}};
}

Json sceneJson(const MethodResult& method, const FunctionSet& set) {
  Json json;
  for (uint32_t s = 0; s < set.scene_ids.size(); ++s) {
    std::vector<double> rmse;
    for (const MethodSample& sample : method.samples) {
      if (set.scene_idx[sample.function] == s) rmse.push_back(sample.error.rmse);
    }
    json[set.scene_ids[s]] = quantilesJson(rmse);
  }
  return json;
}

void appendCsv(std::ostringstream& csv, const std::string& representation, const MethodResult& method, const FunctionSet& set,
               const std::vector<bool>& hard) {
  for (const MethodSample& s : method.samples) {
    csv << representation << ',' << method.name << ',' << s.function << ',' << csvField(set.scene_ids[set.scene_idx[s.function]])
        << ',' << hard[s.function] << ',' << s.error.rmse << ',' << s.error.rmse_unseen << ',';
    if (s.error.has_shadow) csv << s.error.rmse_shadow;
    csv << ',' << s.error.leak_mean << ',' << s.error.leak_p99 << ',' << s.elapsed_us << '\n';
  }
}

// The functions to look at: best, median and worst of the generator among the hard ones (of all when none is hard).
std::vector<std::pair<std::string, uint64_t>> tellingFunctions(const MethodResult& generated, const std::vector<bool>& hard) {
  std::vector<MethodSample> samples;
  for (const MethodSample& sample : generated.samples) {
    if (hard[sample.function]) samples.push_back(sample);
  }
  if (samples.empty()) samples = generated.samples;
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end(),
            [](const MethodSample& a, const MethodSample& b) { return a.error.rmse < b.error.rmse; });
  const auto at = [&](double share) {
    return samples[static_cast<size_t>(share * static_cast<double>(samples.size() - 1))].function;
  };
  return {{"best", at(0.0)}, {"median", at(0.5)}, {"p95", at(0.95)}, {"worst", at(1.0)}};
}

Json sliceJson(const std::string& which, const Slice& slice, const MethodSample& sample, const FunctionSet& set) {
  const auto permille = [](const std::vector<float>& values) {
    std::vector<int> rounded;
    for (const float value : values) rounded.push_back(static_cast<int>(std::lround(1000.0f * std::clamp(value, -2.0f, 2.0f))));
    return rounded;
  };
  return {{"which", which},
          {"function", sample.function},
          {"scene", set.scene_ids[set.scene_idx[sample.function]]},
          {"rmse", sample.error.rmse},
          {"axis", slice.axis},
          {"size", slice.size},
          {"valid", slice.valid},
          {"seen", slice.seen},
          {"target_permille", permille(slice.target)},
          {"predicted_permille", permille(slice.predicted)},
          {"difference_permille", permille(slice.difference)}};
}

// Every so-many-th function, so that all scenes take part.
std::vector<uint64_t> evenChoice(uint64_t count, uint64_t wanted) {
  std::vector<uint64_t> chosen;
  for (uint64_t i = 0; i < std::min(count, wanted); ++i) chosen.push_back(i * count / std::min(count, wanted));
  return chosen;
}

// Counts over training and held-out shards together; a function that two shards hold is one function.
struct DataSetCounts {
  ShardCounts all;
  uint64_t held_out_in_training = 0;  // held-out functions that some training scene has too, by the rule for duplicates
};

DataSetCounts countAll(const Request& request, uint64_t held_out_count) {
  DataSetCounts counts;
  DuplicateFilter filter;
  const auto add = [&](const std::string& path) {
    Shard shard = readShard(path, supportPattern().hash, kSupportPointCount);
    filter.removeKnown(&shard);
    addCounts(shard.counts, &counts.all);
    return shard.counts.functions;
  };
  for (const std::string& path : request.training) add(path);
  uint64_t new_count = 0;
  for (const std::string& path : request.held_out) new_count += add(path);
  counts.held_out_in_training = held_out_count - new_count;
  return counts;
}

struct Outputs {
  Json summary;
  Json slices = Json::array();
  std::ostringstream csv;
  std::vector<ChoiceColumn> fields;  // product fields
};

std::vector<FunctionError> errorsOf(const MethodResult& method) {
  std::vector<FunctionError> errors;
  for (const MethodSample& sample : method.samples) errors.push_back(sample.error);
  return errors;
}

// path   where the generator was read from
void validateGenerator(const Generator& generator, const std::string& path, const FunctionSet& set,
                       const MethodResult& tent_result, const std::vector<bool>& hard, const ValidateOptions& options,
                       Outputs& outputs) {
  const std::string name = representationName(generator.representation());
  std::vector<float> theta;
  const MethodResult uncorrected = measureUncorrected(generator, set, &theta);
  const MethodResult generated = measureGenerator(generator, set, uncorrected, options.correction, &theta);
  const MethodResult policy = measurePolicy(generator, set, generated, theta, options);
  const std::vector<uint64_t> chosen = evenChoice(set.functionCount(), static_cast<uint64_t>(options.direct_functions));
  Progress progress(name + ": functions fitted", static_cast<int64_t>(chosen.size()));
  const std::vector<MethodResult> fits =
      measureFits(generator, set, chosen, theta, options, [&](int64_t done) { progress.update(done); });
  const MethodResult generated_chosen = restrictTo(generated, chosen, &generator, theta, set);
  MethodResult uncorrected_chosen{uncorrected.name};  // for ratios alone: its leaks are not asked for
  for (const uint64_t function : chosen) uncorrected_chosen.samples.push_back(uncorrected.samples[function]);
  const MethodResult tent_chosen = restrictTo(tent_result, chosen, nullptr, theta, set);

  Json json = {{"parameters", generator.representation().thetaCount()},
               {"bytes", static_cast<size_t>(generator.representation().thetaCount()) * sizeof(float)},
               {"weights_bytes", std::filesystem::file_size(path)}};
  json["correction_steps"] = generator.correctionStepCount();
  json["evaluate_us"] = measureEvaluation(generator.representation(), theta.data());
  json["uncorrected"] = methodJson(uncorrected, hard, options);
  json["generator"] = methodJson(generated, hard, options);
  json["refined"] = methodJson(policy, hard, options);
  const auto refined_count =
      std::count_if(policy.samples.begin(), policy.samples.end(), [](const MethodSample& s) { return s.refined; });
  json["share_refined"] = static_cast<double>(refined_count) / std::max<double>(1.0, static_cast<double>(policy.samples.size()));
  // everything below ran on the same chosen functions
  json["generator_chosen"] = methodJson(generated_chosen, hard, options);
  appendCsv(outputs.csv, name, uncorrected, set, hard);
  appendCsv(outputs.csv, name, generated, set, hard);
  appendCsv(outputs.csv, name, policy, set, hard);
  for (const MethodResult& fit : fits) {
    json[fit.name] = methodJson(fit, hard, options);
    appendCsv(outputs.csv, name, fit, set, hard);
    if (fit.name != "direct") continue;
    if (generator.representation().isField()) {
      outputs.fields.push_back({name, generator.representation().thetaCount(), errorsOf(generated_chosen), errorsOf(fit)});
    }
    json["uncorrected_to_direct"] = ratioToDirect(uncorrected_chosen, fit, hard);
    json["generator_to_direct"] = ratioToDirect(generated_chosen, fit, hard);
  }
  json["tent_chosen"] = methodJson(tent_chosen, hard, options);
  json["by_scene"] = sceneJson(generated, set);
  json["weights_sha256"] = fileSha256(path);
  outputs.summary["representations"][name] = json;
  for (const auto& [which, function] : tellingFunctions(generated, hard)) {
    const Slice slice = makeSlice(set, function, generator.representation(),
                                  &theta[function * static_cast<uint64_t>(generator.representation().thetaCount())], 96);
    Json entry = sliceJson(which, slice, generated.samples[function], set);
    entry["representation"] = name;
    outputs.slices.push_back(entry);
  }
}

void validate(const Request& request, const ValidateOptions& options, const OptionTable& table) {
  const std::vector<Generator> generators = loadGenerators(request.weights);
  const FunctionSet set = readHeldOut(request.held_out);
  const MethodResult tent_result = measureTent(set);
  std::vector<bool> hard;
  for (const MethodSample& sample : tent_result.samples) hard.push_back(sample.error.rmse >= options.hard_tent_rmse);
  const DataSetCounts data_set = countAll(request, set.functionCount());
  const ShardCounts& counts = data_set.all;

  Outputs outputs;
  outputs.csv << "representation,method,function,scene,hard,rmse,rmse_unseen_points,rmse_shadow,leak_mean,leak_p99,elapsed_us\n";
  outputs.summary["schema_version"] = 1;
  outputs.summary["provenance"] = provenance("nlg-validate", table.toJson(), {{"held_out", set.sha256}});
  outputs.summary["functions"] = {{"distinct", counts.functions},
                                  {"free_space", counts.free_space},
                                  {"duplicates", counts.duplicates},
                                  {"in_solid", counts.in_solid},
                                  {"empty", counts.empty},
                                  {"visited_probes", counts.visited_probes},
                                  {"grid_probes", counts.grid_probes},
                                  {"held_out", set.functionCount()},
                                  {"held_out_in_training", data_set.held_out_in_training},
                                  {"held_out_scenes", set.scene_ids.size()},
                                  {"hard", std::count(hard.begin(), hard.end(), true)}};
  outputs.summary["tau"] = {{"rmse", options.refinement.check.tau_rmse},
                            {"leak_p99", options.refinement.check.tau_leak},
                            {"hard_tent_rmse", options.hard_tent_rmse}};
  outputs.summary["tent"] = methodJson(tent_result, hard, options);
  appendCsv(outputs.csv, "tent", tent_result, set, hard);
  for (size_t i = 0; i < generators.size(); ++i)
    validateGenerator(generators[i], request.weights[i], set, tent_result, hard, options, outputs);

  if (outputs.fields.size() > 1) {
    std::sort(outputs.fields.begin(), outputs.fields.end(),
              [](const ChoiceColumn& a, const ChoiceColumn& b) { return a.theta_count < b.theta_count; });
    outputs.summary["choice"] = choiceJson(outputs.fields, options.refinement.check, options.choice);
  }
  writeFileAtomically(request.out_dir + "/functions.csv", outputs.csv.str());
  writeFileAtomically(request.out_dir + "/slices.json", outputs.slices.dump());
  writeFileAtomically(request.out_dir + "/summary.json", outputs.summary.dump(1) + "\n");
  std::cout << request.out_dir << "/summary.json\n";
}

int validateMain(int argc, char** argv) {
  CLI::App app{
      "Measures exported generators on held-out scenes against direct optimisation.\n"
      "nlg-validate stability --out FILE: stiff and extreme cases, what must hold and what was measured.\n"
      "nlg-validate frontier: error against run time, of generators, their settings and every fit.\n"
      "nlg-validate look-up SCENE: what a viewer sees of a level's light grid, at random places in its air.\n"
      "nlg-validate compare OLD NEW: what got better or worse between two runs, beyond noise.",
      "nlg-validate"};
  Request request;
  ValidateOptions options;
  OptionTable table("validate");
  describe(options, table);
  app.add_option("--weights", request.weights, "exported generators, one a representation")->required();
  app.add_option("--held-out", request.held_out, "shards of held-out scenes")->required();
  app.add_option("--training", request.training, "training shards: only their counts are read");
  app.add_option("--out", request.out_dir, "folder for summary.json, functions.csv and slices.json")->required();
  return runTool(argc, argv, app, table, [&] { validate(request, options, table); });
}

// What the tool does when its first argument is one of these names; without one it validates.
struct Command {
  const char* name;
  int (*run)(int argc, char** argv);
};
constexpr Command kCommands[] = {{"stability", stabilityMain},
                                 {"frontier", frontierMain},
                                 {"look-up", lookUpMain},
                                 {"compare", compareMain},
                                 {"--compare", compareMain}};

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  for (const nlg::Command& command : nlg::kCommands) {
    if (argc > 1 && std::strcmp(argv[1], command.name) == 0) return command.run(argc - 1, argv + 1);
  }
  return nlg::validateMain(argc, argv);
}
