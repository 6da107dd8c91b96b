// nlg-solve: weighting functions of a small scene solved for, and what rules that generate them make of the same scene.
// Writes SCENE.csv, a row a rule, and SCENE.json, slices for pictures (docs/lab/weighting_functions.md says what stands in them); with
// --weights instead SCENE.hierarchy.json, from solved functions to what a bake stores (docs/reference/frontier.md).

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/load_generators.h"
#include "bake/policy_options.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"
#include "validate/errors/held_out.h"
#include "validate/solved/comparison.h"
#include "validate/solved/hierarchy.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNoFalloff = std::numeric_limits<double>::infinity();

struct Request {
  std::string scene, out_dir;
  std::vector<std::string> weights;
};

void describeOptions(SolveSetup& o, DirectOptions& direct, OptionTable& table) {
  table.add("seed", &o.light.seed, "seed of rays and of the choice of lamps");
  table.add("fit_points", &o.samples.fit_points, "points in a cell that the solve sees", 8, 4096);
  table.add("test_points", &o.samples.test_points, "points in a cell that figures are taken at", 1, 4096);
  table.add("rays_per_point", &o.light.rays_per_point, "rays that gather the lighting of a point", 16, 1 << 20);
  table.add("lamp_m", &o.light.lamp_m, "side of a lamp, metres", 0.5, 100.0);
  table.add("fit_lamps", &o.light.fit_lamps, "lamps that the solve sees", 1, 1024);
  table.add("test_lamps", &o.light.test_lamps, "lamps that figures are taken under", 1, 1024);
  table.add("steps", &o.solve.steps, "steps of Adam", 0, 100000);
  table.add("rate", &o.solve.rate, "learning rate", 1e-6, 1.0);
  table.add("anchor", &o.solve.anchor, "weight of the error at the probes themselves", 0.0, 1e3);
  table.add("smoothness", &o.solve.smoothness, "weight of the squared slope of functions, square metres", 0.0, 1e3);
  table.add("direct_adam_steps", &direct.adam_steps, "--weights: best known: Adam steps a start", 0, 10000000);
  table.add("direct_lm_iterations", &direct.levenberg_iterations, "--weights: best known: LM iterations a start", 0, 100000);
  table.add("direct_restarts", &direct.restarts, "--weights: best known: random starts", 1, 1000);
}

// The rules that are compared; the first of `none` baseline is the present one.
std::vector<DiffusionRule> rules() {
  std::vector<DiffusionRule> list = {{"bare tent", Baseline::bare_tent}, {"seen tent", Baseline::visible_tent}, {"present"}};
  const auto add = [&](const std::string& name, Carry carry, int passes, double sigma, double falloff, double power) {
    list.push_back({name, Baseline::none, carry, passes, sigma, falloff, power});
  };
  for (const int passes : {1, 2, 3, 4, 16}) {
    for (const double falloff : {0.25, 0.5, 1.0, 2.0, 4.0, kNoFalloff}) {
      for (const double sigma : {0.05, 0.1, 0.2, 0.3}) add("weight", Carry::weight, passes, sigma, falloff, 0.0);
      add("share", Carry::share, passes, 0.1, falloff, 0.0);
    }
    for (const double power : {1.0, 2.0, 4.0, 8.0, 16.0}) add("path", Carry::path, passes, 0.1, 0.0, power);
  }
  return list;
}

std::string row(const std::string& scene, const DiffusionRule& rule, const Quality& q) {
  const bool is_diffused = rule.baseline == Baseline::none;
  const std::string constants = !is_diffused                ? ",,,"
                                : rule.carry == Carry::path ? fmt::format("{},,,{}", rule.passes, rule.path_power)
                                                            : fmt::format("{},{},{},", rule.passes, rule.sigma, rule.falloff);
  return fmt::format("{},{},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f}\n", scene, rule.name, constants, q.rmse, q.rmse_occluded,
                     q.unlit_share, q.leak, q.step_p99, q.distance_solved);
}

// One number a slice point: the weight of one probe.
Json weightsJson(const SolvedScene& scene, const BlendWeights& weights, int probe) {
  Json values = Json::array();
  for (size_t i = 0; i < scene.points.count(); ++i) {
    if (scene.points.use[i] != PointUse::slice) continue;
    float weight = 0.0f;
    for (int c = 0; c < kCornerCount; ++c) {
      if (scene.points.probe[i][c] == probe) weight = weights[i][c];
    }
    values.push_back(std::round(1e4 * weight) / 1e4);
  }
  return values;
}

// The probes of the layer nearest to the slice, those first whose tent the walls change most there.
std::vector<int> picturedProbes(const SolvedScene& scene, const BlendWeights& seen) {
  const SamplePoints& points = scene.points;
  std::vector<double> changed(points.probe_position_m.size());
  const BlendWeights tents = points.tent();
  for (size_t i = 0; i < points.count(); ++i) {
    if (points.use[i] != PointUse::slice) continue;
    for (int c = 0; c < kCornerCount; ++c) {
      if (points.probe[i][c] >= 0) changed[points.probe[i][c]] += std::fabs(tents[i][c] - seen[i][c]);
    }
  }
  std::vector<int> order(changed.size());
  for (size_t p = 0; p < order.size(); ++p) order[p] = static_cast<int>(p);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return changed[a] > changed[b]; });
  order.resize(std::min<size_t>(order.size(), 4));
  return order;
}

Json slicesJson(const SolvedScene& scene) {
  const int axis = scene.small.slice_axis, u = axis == 0 ? 2 : 0, v = axis == 1 ? 2 : 1;
  Json slice = {{"scene", scene.small.name}, {"axes", {u, v}}, {"pixel_m", scene.small.lattice.spacing_m / kSlicePixelsACell}};
  slice["room"] = {scene.small.room.min[u], scene.small.room.max[u], scene.small.room.min[v], scene.small.room.max[v]};
  slice["u"] = slice["v"] = slice["light"] = Json::array();
  for (size_t i = 0; i < scene.points.count(); ++i) {
    if (scene.points.use[i] != PointUse::slice) continue;
    slice["u"].push_back(scene.points.position_m[i][u]);
    slice["v"].push_back(scene.points.position_m[i][v]);
    float sum = 0.0f;
    for (int axis_idx = 0; axis_idx < kAxisCount; ++axis_idx) sum += scene.light.test.row(i)[axis_idx];
    slice["light"].push_back(std::round(1e3 * sum / kAxisCount) / 1e3);
  }
  const auto weightsOf = [&](const DiffusionRule& rule) { return generateWeights(scene.table, scene.views, scene.points, rule); };
  const BlendWeights seen = weightsOf({"", Baseline::visible_tent});
  const std::vector<std::pair<std::string, BlendWeights>> kinds = {
      {"solved", scene.solved.weights},
      {"seen tent", normalised(seen)},
      {"present", normalised(weightsOf({""}))},
      {"falloff 1", normalised(weightsOf({"", Baseline::none, Carry::weight, 2, 0.1, 1.0}))},
      {"path", normalised(weightsOf({"", Baseline::none, Carry::path, 2, 0.1, 0.0, 8.0}))}};
  slice["functions"] = Json::array();
  for (const int probe : picturedProbes(scene, seen)) {
    const glm::vec3 at = scene.points.probe_position_m[probe];
    Json function = {{"probe", {at.x, at.y, at.z}}, {"at", {at[u], at[v]}}};
    for (const auto& [name, weights] : kinds) function[name] = weightsJson(scene, weights, probe);
    slice["functions"].push_back(std::move(function));
  }
  return slice;
}

void compareRules(const Request& request, const SolvedScene& scene) {
  std::string csv = "scene,rule,passes,sigma,falloff,path_power,rmse,rmse_occluded,unlit_share,leak,step_p99,distance_solved\n";
  const DiffusionRule tent{"bare tent", Baseline::bare_tent}, seen{"seen tent", Baseline::visible_tent}, present{"present"};
  const auto weightsOf = [&](const DiffusionRule& rule) { return generateWeights(scene.table, scene.views, scene.points, rule); };
  // functions are solved for at the fit points only: elsewhere they are carried over, which costs some of their quality
  csv += row(request.scene, {"solved", Baseline::visible_tent}, judge(scene, scene.solved.weights));
  csv += row(request.scene, {"at fit points: solved", Baseline::visible_tent}, judge(scene, scene.solved.weights, PointUse::fit));
  for (DiffusionRule rule : {tent, seen, present}) {
    rule.name = "at fit points: " + rule.name;
    csv += row(request.scene, rule, judge(scene, weightsOf(rule), PointUse::fit));
  }
  for (const DiffusionRule& rule : rules()) {
    csv += row(request.scene, rule, judge(scene, weightsOf(rule)));
  }
  writeFileAtomically(request.out_dir + "/" + request.scene + ".csv", csv);
  writeFileAtomically(request.out_dir + "/" + request.scene + ".json", slicesJson(scene).dump() + "\n");
}

void descendHierarchy(const Request& request, const SolvedScene& scene, const std::vector<Generator>& generators,
                      const DirectOptions& direct, const OptionTable& table) {
  std::map<std::string, std::string> hashes;
  for (size_t i = 0; i < generators.size(); ++i) hashes["weights." + std::to_string(i)] = fileSha256(request.weights[i]);
  Json json = {{"schema_version", 1}, {"provenance", provenance("nlg-solve", table.toJson(), hashes)}};
  json.update(hierarchyJson(scene, generators, defaultBakePolicy(), direct));
  writeFileAtomically(request.out_dir + "/" + request.scene + ".hierarchy.json", json.dump(1) + "\n");
}

void solve(const Request& request, const SolveSetup& setup, const DirectOptions& direct, const OptionTable& table) {
  requireOutputFolder(request.out_dir, "--out-dir");
  const std::vector<Generator> generators = loadGenerators(request.weights).generators;
  const SolvedScene scene(request.scene, setup);
  if (generators.empty()) {
    compareRules(request, scene);
  } else {
    descendHierarchy(request, scene, generators, direct, table);
  }
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  CLI::App app{
      "Solves for the weighting functions of a small scene and compares what generates them with it: rules, or exported "
      "generators.",
      "nlg-solve"};
  nlg::Request request;
  nlg::SolveSetup setup;
  nlg::DirectOptions direct;
  nlg::OptionTable table("solve");
  nlg::describeOptions(setup, direct, table);
  table.common({"weights", "steps", "seed"});
  app.add_option("--scene", request.scene, "two_rooms, doorway, column, clutter, corridor or table")->required();
  app.add_option("--out-dir", request.out_dir, "folder for SCENE.csv and SCENE.json; with --weights: for SCENE.hierarchy.json")
      ->required();
  app.add_option("--weights", request.weights,
                 "exported generators: instead of comparing rules, say how much error a bake with each adds to the target "
                 "functions, stage by stage");
  return nlg::runTool(argc, argv, app, table, [&] { nlg::solve(request, setup, direct, table); });
}
