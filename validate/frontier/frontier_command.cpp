#include "validate/commands.h"

#include <CLI/CLI.hpp>

#include "bake/load_generators.h"
#include "bake/policy_options.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/output_path.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "validate/frontier/frontier_json.h"
#include "validate/frontier/frontier_options.h"
#include "validate/frontier/timed_policy.h"
#include "validate/generators/function_counts.h"
#include "validate/generators/summary_json.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchemaVersion = 2;

struct Request {
  std::vector<std::string> weights, held_out;
  std::string out_dir;
};

// What is measured, from the smallest representation on.
struct Plan {
  std::vector<PlotRun> runs;
  Json representations;  // name → stages

  void append(std::vector<PlotRun> more) { std::move(more.begin(), more.end(), std::back_inserter(runs)); }
  std::vector<PlotPoint> points() const {
    std::vector<PlotPoint> all;
    for (const PlotRun& run : runs) all.insert(all.end(), run.points.begin(), run.points.end());
    return all;
  }
};

// The points of all weights.
Plan planOf(const Request& request, const FrontierOptions& options) {
  const FitBudgets budgets = options.budgets();
  Plan plan;
  LoadedGenerators loaded = loadGenerators(request.weights);  // by rising number of parameters
  for (Generator& one : loaded.generators) {
    const auto generator = std::make_shared<const Generator>(std::move(one));
    plan.representations[representationName(generator->representation())]["stages"] =
        stagesJson(stagesOf(stageFacts(*generator), options.policy));
    plan.append(stagePoints(generator, options.policy));
    plan.append(fitsOfCorrected(generator, options.policy, budgets));
    plan.append(directFits(generator, options.policy, budgets, options.seed));
  }
  return plan;
}

std::map<std::string, std::string> inputHashes(const Request& request, const FunctionSet& set) {
  std::map<std::string, std::string> hashes = {{"held_out", set.sha256}};
  for (size_t i = 0; i < request.weights.size(); ++i) hashes["weights." + std::to_string(i)] = fileSha256(request.weights[i]);
  return hashes;
}

// Every word of every representation against its direct fits.
Json speeds(const std::vector<PlotPoint>& points, const std::vector<PointMeasurement>& measured,
            const std::vector<FunctionBlock>& blocks, const FunctionSet& set, const FrontierOptions& options) {
  std::vector<uint32_t> scene;
  for (const FunctionBlock& block : blocks) {
    for (const uint64_t function : block.functions) scene.push_back(set.scene_idx[function]);
  }
  const SceneBootstrap bootstrap(scene, {options.bootstrap_draws, 0.95, options.seed});
  const auto timed = [&](size_t p) {
    return TimedPoint{points[p].family,
                      points[p].label,
                      functionTimes(measured[p], blocks),
                      measured[p].blend_rmse,
                      {measured[p].fails_check.begin(), measured[p].fails_check.end()}};
  };
  std::map<std::string, std::vector<TimedPoint>> baselines;
  for (size_t p = 0; p < measured.size(); ++p) {
    if (points[p].is_direct) baselines[points[p].representation].push_back(timed(p));
  }
  Json speeds = Json::object();
  for (size_t p = 0; p < measured.size(); ++p) {
    const std::string& name = points[p].representation;
    if (points[p].words.empty()) continue;
    const EqualError equal = compareAtEqualError(timed(p), baselines[name], bootstrap);
    for (const ThetaWord word : points[p].words) speeds[name][wordName(word)] = speedJson(equal);
  }
  return speeds;
}

void measureFrontier(const Request& request, const FrontierOptions& options, const OptionTable& table) {
  requireOutputFolder(request.out_dir);
  refuseToReplaceOthers(request.out_dir + "/frontier.json", kValidationFiles);
  const Plan plan = planOf(request, options);
  const FunctionSet set = readHeldOut(request.held_out);
  Json json = {{"schema_version", kSchemaVersion}};
  json["provenance"] = provenance("nlg-validate frontier", table.toJson(), inputHashes(request, set));
  // the same functions for every point, in blocks: all points run on a block before the next
  const ChosenFunctions functions =
      chooseFunctions(set, static_cast<uint64_t>(options.functions), options.policy, options.hard_tent_rmse);
  const std::vector<FunctionBlock> blocks = makeBlocks(set, functions.with_theta);
  Progress progress("runs", static_cast<int64_t>(plan.runs.size() * blocks.size()) * (1 + options.interleave.repeats));
  // interleaved: a change of the machine's speed meets all points alike
  const std::vector<PointMeasurement> measured =
      measureInterleaved(set, functions, blocks, plan.runs, options.policy.check(), options.interleave,
                         [&](int64_t done) { progress.update(done); });
  std::vector<Json> figures;
  for (const PointMeasurement& point : measured) figures.push_back(pointFigures(point, set, functions, blocks));
  const std::vector<PlotPoint> points = plan.points();
  for (const Population population : kPopulations) {
    const std::vector<bool> counts = functions.of(population);
    json["functions"][populationName(population)] = std::count(counts.begin(), counts.end(), true);
  }
  json["scenes"] = set.scene_ids;
  json["representations"] = plan.representations;
  json.update(frontierJson(points, figures, tentFigures(set, functions, options.policy.check().loss()),
                           speeds(points, measured, blocks, set, options)));
  writeFileAtomically(request.out_dir + "/frontier.json", json.dump(1) + "\n");
  for (const Json& sentence : json["front_sentences"]) {
    if (const auto text = sentence.get<std::string>(); !text.empty()) std::cout << text << '\n';
  }
  std::cout << request.out_dir << "/frontier.json\n";
}

}  // namespace

int frontierMain(int argc, char** argv) {
  CLI::App app{"Measures blend RMSE against run time: generators, their settings and every fit, on the same held-out functions.",
               "nlg-validate frontier"};
  Request request;
  FrontierOptions options;
  OptionTable table("frontier");
  describe(options, table);
  describePolicy(options.policy, table);
  table.common({"functions", "repeats"});
  app.add_option("--weights", request.weights, "exported generators, one per representation")->required();
  app.add_option("--held-out", request.held_out, "shards of held-out scenes")->required();
  app.add_option("--out", request.out_dir, "folder for frontier.json")->required();
  return runTool(argc, argv, app, table, [&] { measureFrontier(request, options, table); });
}

}  // namespace nlg
