#include "validate/generators/validation.h"

#include <iostream>
#include <sstream>

#include <fmt/format.h>

#include "bake/load_generators.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/provenance.h"
#include "validate/generators/function_counts.h"
#include "validate/generators/summary_json.h"
#include "validate/generators/telling_functions.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchemaVersion = 2;

}  // namespace

int ValidateOptions::threadCount() const { return threads > 0 ? threads : machineThreadCount(); }

void describe(ValidateOptions& o, OptionTable& table) {
  table.group("Measurement");
  table.add("seed", &o.seed, "seed of random starts");
  describePolicy(o.policy, table);
  table.group("Measurement");
  table.add("theta_precision", &o.theta_precision,
            "number format in which the light grid would store theta: float32, float16 or int8");
  table.add("hard_tent_rmse", &o.hard_tent_rmse, "RMSE of the bare tent from which a function counts as hard", 0.0, 1.0);
  table.add("direct_functions", &o.direct_functions,
            "number of functions in the sample for long fits: they take a theta, and are spread evenly over scenes", 1, 1000000);
  table.add("direct_adam_steps", &o.direct.adam_steps, "direct optimisation: Adam steps per start", 0, 10000000);
  table.add("direct_lm_iterations", &o.direct.levenberg_iterations, "direct optimisation: LM iterations per start", 0, 100000);
  table.add("direct_restarts", &o.direct.restarts, "direct optimisation: number of random starts", 1, 1000);
  table.add("threads", &o.threads, "number of threads. 0: one per hardware thread. No error depends on it", 0, 1024);
}

void validate(const ValidationRequest& request, ValidateOptions options, const OptionTable& table) {
  // the folder first: a run of hours must not end without a place for its result
  requireOutputFolder(request.out_dir);
  for (const char* name : {"functions.csv", "slices.json", "summary.json"})
    refuseToReplaceOthers(request.out_dir + "/" + name, kValidationFiles);
  options.policy.theta_precision = thetaPrecisionFromName(options.theta_precision);
  const auto [generators, paths] = loadGenerators(request.weights);
  const FunctionSet set = readHeldOut(request.held_out);
  // populations, counts and tents are of the set: all generators are compared on the same functions
  const Populations populations(set, options);
  const FunctionCounts counts = countFunctions(request.training, request.held_out, set, options.threadCount());
  const FigureContext context{set, populations, counts.known};
  const MeasuredWord tents = measureTents(set, populations, options);

  // tables grow generator by generator, and are written together at the end
  std::ostringstream csv;
  csv << kCsvHead;
  appendCsv(tents.name, tents, set, populations, csv);
  Json slices = Json::array();
  Json summary = {{"schema_version", kSchemaVersion},
                  {"provenance", provenance("nlg-validate", table.toJson(), {{"held_out", set.sha256}})},
                  {"tau", tauJson(options)},
                  {"theta_precision", thetaPrecisionName(options.policy.theta_precision)},
                  {"functions", functionsJson(counts.all, context)},
                  {"in_training", inTrainingJson(context)},
                  {"bootstrap", bootstrapJson(context)},
                  {tents.name, figuresByPopulation(tents, Scope::set, context)}};
  // for each generator the bake's policy, long fits from its thetas, and slices of telling functions
  for (size_t i = 0; i < generators.size(); ++i) {
    const Representation& representation = generators[i].representation();
    const std::string name = representationName(representation);
    PolicyWords policy = measurePolicy(generators[i], set, populations, options);
    LongFits fits = measureLongFits(generators[i], set, populations, policy.least_wrong, options);
    const ValidatedGenerator validated{generators[i], paths[i], std::move(policy), std::move(fits)};
    summary["representations"][name] = representationJson(validated, context);
    for (const MeasuredWord& word : validated.policy.words) appendCsv(name, word, set, populations, csv);
    for (const MeasuredWord& fit : validated.fits.words) appendCsv(name, fit, set, populations, csv);
    appendSlices(representation, validated.policy, set, populations, &slices);
  }
  writeFileAtomically(request.out_dir + "/functions.csv", csv.str());
  writeFileAtomically(request.out_dir + "/slices.json", slices.dump());
  writeFileAtomically(request.out_dir + "/summary.json", summary.dump(1) + "\n");
  std::cout << request.out_dir << "/summary.json\n";
  for (const auto& [name, node] : summary["representations"].items()) {
    const Json& stored = node["stored"]["theta"];
    if (stored["functions"] == 0) continue;
    std::cout << fmt::format(
        "{}: mean blend RMSE {:.4f}, {:.1f} % fail the check, of {} functions that take a theta, as stored\n", name,
        stored["blend_rmse"]["mean"].get<double>(), 100.0 * stored["share_failing_check"]["value"].get<double>(),
        stored["functions"].get<uint64_t>());
  }
}

}  // namespace nlg
