#include "validate/frontier/frontier_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "bake/policy_options.h"
#include "tool/atomic_file.h"
#include "tool/one_file_each.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"
#include "validate/errors/even_choice.h"
#include "validate/errors/function_error.h"
#include "validate/errors/held_out.h"
#include "validate/frontier/frontier_json.h"
#include "validate/frontier/frontier_options.h"
#include "validate/frontier/generator_points.h"

namespace nlg {
namespace {

struct Request {
  std::vector<std::string> weights, held_out, hierarchies;
  std::string out_dir;
};

void append(std::vector<PlotPoint> more, std::vector<PlotPoint>& points) {
  std::move(more.begin(), more.end(), std::back_inserter(points));
}

// The points of all weights, and the choice between those of product fields when there are several.
std::vector<PlotPoint> allPoints(const Request& request, const FrontierOptions& options) {
  const std::vector<int> coefficients = options.coefficientCounts();
  const FitBudgets budgets = options.budgets();
  std::vector<PlotPoint> points;
  std::vector<std::shared_ptr<const Generator>> fields;
  OneFileEach given("--weights", "representation");
  for (const std::string& path : request.weights) {
    const GeneratorData data = loadGeneratorData(path);
    given.add(path, representationName(data.representation));
    const int all = data.basis.coefficientCount();
    if (!coefficients.empty() && coefficients.back() > all) {
      throw UsageError("--coefficients", "at most the " + std::to_string(all) + " of " + path,
                       std::to_string(coefficients.back()));
    }
    const auto generator = std::make_shared<const Generator>(data);
    append(generatorPoints(data, generator, options.correction, coefficients), points);
    append(fitPoints(std::make_shared<GeneratorRun>(generator, options.correction), budgets, options.seed), points);
    if (generator->representation().isField()) fields.push_back(generator);
  }
  std::sort(fields.begin(), fields.end(),
            [](const auto& a, const auto& b) { return a->representation().thetaCount() < b->representation().thetaCount(); });
  if (fields.size() > 1) points.push_back(choicePoint(fields, options.correction, options.check, options.choice));
  return points;
}

std::map<std::string, std::string> inputHashes(const Request& request, const FunctionSet& set) {
  std::map<std::string, std::string> hashes = {{"held_out", set.sha256}};
  for (size_t i = 0; i < request.weights.size(); ++i) hashes["weights." + std::to_string(i)] = fileSha256(request.weights[i]);
  return hashes;
}

std::vector<double> tentErrors(const FunctionSet& set, const std::vector<uint64_t>& functions) {
  ErrorMeter meter(set);
  std::vector<double> rmse;
  for (const uint64_t function : functions) rmse.push_back(meter.measureTent(function, nullptr).rmse);
  return rmse;
}

void measureFrontier(const Request& request, const FrontierOptions& options, const OptionTable& table) {
  std::vector<PlotPoint> points = allPoints(request, options);
  const FunctionSet set = readHeldOut(request.held_out);
  nlohmann::ordered_json json = {{"schema_version", 1}};
  json["provenance"] = provenance("nlg-validate frontier", table.toJson(), inputHashes(request, set));
  addHierarchies(request.hierarchies, json);
  const std::vector<uint64_t> functions =
      chooseEvenly(set.scene_idx, set.scene_ids.size(), static_cast<uint64_t>(options.functions));
  const std::vector<FunctionBlock> blocks = makeBlocks(set, functions);
  Progress progress("runs", static_cast<int64_t>(points.size() * blocks.size()) * (1 + options.interleave.repeats));
  const std::vector<PointMeasurement> measured =
      measureInterleaved(set, blocks, points, options.interleave, [&](int64_t done) { progress.update(done); });
  std::vector<PointFigures> figures;
  const std::vector<double> tent_rmse = tentErrors(set, functions);
  std::vector<bool> hard;
  for (const double rmse : tent_rmse) hard.push_back(rmse >= options.hard_tent_rmse);
  for (const PointMeasurement& point : measured) figures.push_back(figuresOf(point, blocks, set, hard));
  const FrontierResult result =
      makeResult(std::move(points), std::move(figures), figuresOfTent(tent_rmse, blocks, set, hard), options.front);
  json["functions"] = functions.size();
  json["hard_functions"] = std::count(hard.begin(), hard.end(), true);
  json["scenes"] = set.scene_ids;
  json.update(pointsJson(result));
  writeFileAtomically(request.out_dir + "/frontier.csv", pointsCsv(result));
  writeFileAtomically(request.out_dir + "/frontier.json", json.dump(1) + "\n");
  std::cout << result.all.sentence << '\n' << result.hard.sentence << '\n' << request.out_dir << "/frontier.json\n";
}

}  // namespace

int frontierMain(int argc, char** argv) {
  CLI::App app{"Measures error against run time: generators, their settings and every fit, on the same held-out functions.",
               "nlg-validate frontier"};
  Request request;
  FrontierOptions options;
  OptionTable table("frontier");
  describe(options, table);
  describeCorrection(options.correction, table);
  describeChoice(options.choice, table);
  app.add_option("--weights", request.weights, "exported generators, one a representation")->required();
  app.add_option("--held-out", request.held_out, "shards of held-out scenes")->required();
  app.add_option("--hierarchy", request.hierarchies, "SCENE.hierarchy.json of nlg-solve --weights, one a scene");
  app.add_option("--out", request.out_dir, "folder for frontier.json and frontier.csv")->required();
  return runTool(argc, argv, app, table, [&] { measureFrontier(request, options, table); });
}

}  // namespace nlg
