#include "validate/errors/validation.h"

#include <iostream>

#include "bake/load_generators.h"
#include "bake/policy_options.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "validate/errors/function_counts.h"
#include "validate/errors/functions_csv.h"
#include "validate/errors/held_out.h"
#include "validate/errors/summary_json.h"
#include "validate/errors/telling_functions.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchemaVersion = 2;

ValidatedGenerator measure(const Generator& generator, const std::string& path, const FigureContext& context,
                           const ValidateOptions& options) {
  PolicyWords policy = measurePolicy(generator, context.set, context.populations, options);
  LongFits fits = measureLongFits(generator, context.set, context.populations, policy.least_wrong, options);
  Convergence convergence = measureConvergence(generator, context.set, context.populations, fits, options);
  return {generator, path, std::move(policy), std::move(fits), std::move(convergence)};
}

}  // namespace

void validate(const ValidationRequest& request, ValidateOptions options, const OptionTable& table) {
  requireOutputFolder(request.out_dir);
  options.policy.theta_precision = thetaPrecisionFromName(options.theta_precision);
  const auto [generators, paths] = loadGenerators(request.weights);
  const FunctionSet set = readHeldOut(request.held_out);
  const Populations populations(set, options);
  const FunctionCounts counts = countFunctions(request.training, request.held_out, set, options.threadCount());
  const FigureContext context{set, populations, counts.known};
  const MeasuredWord tents = measureTents(set, populations, options);

  FunctionsCsv csv(set, populations);
  csv.add(tents.name, tents);
  Json slices = Json::array();
  Json summary = {{"schema_version", kSchemaVersion},
                  {"provenance", provenance("nlg-validate", table.toJson(), {{"held_out", set.sha256}})},
                  {"tau", tauJson(options)},
                  {"theta_precision", thetaPrecisionName(options.policy.theta_precision)},
                  {"functions", functionsJson(counts.all, context)},
                  {"bootstrap", bootstrapJson(context)},
                  {tents.name, figuresByPopulation(tents, Scope::set, context)}};
  for (size_t i = 0; i < generators.size(); ++i) {
    const Representation& representation = generators[i].representation();
    const std::string name = representationName(representation);
    const ValidatedGenerator validated = measure(generators[i], paths[i], context, options);
    summary["representations"][name] = representationJson(validated, context);
    for (const MeasuredWord& word : validated.policy.words) csv.add(name, word);
    for (const MeasuredWord& fit : validated.fits.words) csv.add(name, fit);
    appendSlices(representation, validated.policy, set, populations, &slices);
  }
  writeFileAtomically(request.out_dir + "/functions.csv", csv.text());
  writeFileAtomically(request.out_dir + "/slices.json", slices.dump());
  writeFileAtomically(request.out_dir + "/summary.json", summary.dump(1) + "\n");
  std::cout << request.out_dir << "/summary.json\n";
}

}  // namespace nlg
