#include "validate/commands.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "bake/load_generators.h"
#include "bake/policy_options.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/output_path.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "validate/frontier/frontier_json.h"
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

constexpr int kLargestStepCount = 1000000;

std::vector<int> risingNumbers(const std::string& flag, const std::vector<std::string>& texts) {
  std::vector<int> numbers;
  for (const std::string& text : texts) {
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool is_number = error == std::errc() && end == text.data() + text.size();
    if (!is_number || number > kLargestStepCount || number <= (numbers.empty() ? 0 : numbers.back())) {
      throw UsageError(flag, "rising whole numbers from 1 to " + std::to_string(kLargestStepCount), "'" + text + "'");
    }
    numbers.push_back(number);
  }
  return numbers;
}

// Options of nlg-validate frontier: section `frontier` of pipeline.yaml.
struct FrontierOptions {
  int functions = 192;           // that take a theta
  double hard_tent_rmse = 0.01;  // functions whose bare tent is at least so wrong are hard
  InterleaveOptions interleave;
  // lists of rising whole numbers
  std::vector<std::string> lm_steps = {"4", "16", "64"};
  std::vector<std::string> adam_steps = {"200", "1000", "4000"};
  std::vector<std::string> direct_lm_steps = {"1", "2", "4", "8", "16", "32", "64"};
  std::vector<std::string> direct_adam_steps = {"125", "250", "500", "1000", "2000", "4000", "8000", "16000"};
  PolicyOptions policy;
  int bootstrap_draws = 1000;
  uint64_t seed = 1;

  // throws   UsageError naming the flag when a list is not one of rising whole numbers from 1 on
  FitBudgets budgets() const {
    return {risingNumbers("--corrected-lm-steps", lm_steps), risingNumbers("--corrected-adam-steps", adam_steps),
            risingNumbers("--direct-lm-steps", direct_lm_steps), risingNumbers("--direct-adam-steps", direct_adam_steps)};
  }
};

// Adds every option to the table, but those of the policy, which are describePolicy's.
void describe(FrontierOptions& o, OptionTable& table) {
  table.group("Measurement");
  table.add("functions", &o.functions,
            "number of held-out functions that take a theta, evenly over scenes, on which all points run", 1, 1000000);
  table.add("hard_tent_rmse", &o.hard_tent_rmse, "RMSE of the bare tent from which a function counts as hard", 0.0, 1.0);
  table.add("repeats", &o.interleave.repeats, "timed runs of a short point per block", 1, 10000);
  table.add("repeat_seconds", &o.interleave.repeat_seconds,
            "time of a point's fastest block, seconds, above which the point runs only once", 0.0, 1e6);
  table.add("corrected_lm_steps", &o.lm_steps, "budgets of LM steps from the corrected theta");
  table.add("corrected_adam_steps", &o.adam_steps,
            "budgets of Adam steps from the corrected theta; product fields and codes take 1/32 as many");
  table.add("direct_lm_steps", &o.direct_lm_steps, "budgets of LM steps from theta0");
  table.add("direct_adam_steps", &o.direct_adam_steps,
            "budgets of Adam steps from theta0 and from random starts; product fields and codes take 1/32 as many");
  table.add("bootstrap_draws", &o.bootstrap_draws,
            "bootstrap draws of scenes and functions for the interval of the speed at equal error", 1, 1000000);
  table.add("seed", &o.seed, "seed of random starts and draws");
}

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
